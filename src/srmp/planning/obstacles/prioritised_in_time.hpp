#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/obstacles/plan_in_time.hpp"
#include "srmp/planning/strategies/robot_path.hpp"

namespace srmp {

struct PrioritisedOptions {
  int max_roadmaps{3};  ///< of a robot, each richer than the one before: more find more, and take longer
  std::uint64_t max_checks{20'000'000};  ///< of a robot's search: more finds more, and takes longer to give up
  /// Of all robots, where motions are known already and only earlier ones are searched: few, so that the plan as a
  /// whole takes little longer than without.
  std::uint64_t checks_for_earlier{500'000};
};

/// Robots that are planned in time one after the other, each around the moving obstacles and the robots planned
/// before it (priorities: Erdmann, Lozano-Pérez 1987).
class PrioritisedInTime {
 public:
  using Motions = std::map<std::string, Trajectory>;

  /// `group`: checkers, by Coal alone, of the problem's robots, in their order, and after them the moving obstacles.
  /// References outlive this.
  PrioritisedInTime(const PlanProblem& problem, const GroupCheckers& group, const Deadline& deadline,
                    PlanStatistics& statistics, const PrioritisedOptions& options = {});

  /// Checks starts and goals as the pipeline does, but a start may be where the motion of an obstacle ends. Throws
  /// PlanningError.
  void require_endpoints();

  /// A robot that finds no motion is put first, until an order recurs. Robots whose motion of `at_once` stays clear of
  /// the others keep it. Throws PlanningError where a robot has no path even among what stands still.
  std::optional<Motions> plan(const Motions& at_once);
  /// Only if all arrive earlier than `before` [s], with a budget that is small next to that of a plan.
  std::optional<Motions> plan_earlier(const Motions& at_once, double before);

 private:
  bool plan_one(std::size_t i, const Motions& at_once, const TimedBudget& budget, Motions& done);
  std::vector<MovingRobot> others_of(std::size_t i, const Motions& done) const;
  TimedTask task_of(std::size_t i, const Motions& at_once, const std::vector<MovingRobot>& others);
  const RobotPath& path_of(std::size_t i);

  const PlanProblem& problem_;
  const PrioritisedOptions options_;
  const CommonOptions& common_;
  const GroupCheckers& group_;
  const GroupCheckers quick_;  // the same robots, by the checkers that plan
  std::vector<Checker::WorkspacePtr> workspaces_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::map<std::size_t, RobotPath> paths_;  // by robot, among what stands still
};

}  // namespace srmp
