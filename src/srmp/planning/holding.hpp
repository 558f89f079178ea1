#pragma once

#include <vector>

#include "srmp/planning/multi_robot.hpp"
#include "srmp/planning/obstacles/moving_obstacles.hpp"

namespace srmp {

/// Robots of a question to many that stay where they start, while those of `moving` do not. References outlive this.
class HoldingRobots {
 public:
  /// Lets the robots stand at their starts in the scene, if those are within limits.
  HoldingRobots(Scene& scene, std::vector<MultiRobotPart> robots, std::vector<std::string> moving);

  /// Throws PlanningError, start_invalid, for the first robot that stands outside its limits, or touches itself or what
  /// stands still; the statistics say so.
  void require_starts(const Deadline& deadline, PlanStatistics& statistics) const;

  /// Adds them to the others' motions, with certificates that cover those and the committed ones, if the options ask
  /// for any.
  void join(MultiTrajectory& motions, const CommittedMotions& committed, const CommonOptions& options,
            const Deadline& deadline, PlanStatistics& statistics) const;

 private:
  /// What the robot touches at its start; "" = nothing.
  std::string contact(const MultiRobotPart& part) const;

  const Scene& scene_;
  std::vector<MultiRobotPart> robots_;  // starts a hair outside a limit are on it
  std::vector<std::string> moving_;
};

}  // namespace srmp
