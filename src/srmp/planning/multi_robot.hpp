#pragma once

#include "srmp/planning/group_checkers.hpp"
#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/user_heuristic.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// One robot's part of a question to many.
struct MultiRobotPart {
  std::string robot;
  Eigen::VectorXd start;
  GoalConstraint goal;
  MotionLimits limits;  ///< of the robot, not scaled
  std::shared_ptr<const PlacedRobot> placed;
};

/// One question to a planner for many robots. References outlive the call.
struct MultiRobotProblem {
  const Scene& scene;                  ///< those that hold stand at their starts
  std::vector<MultiRobotPart> moving;  ///< in the order of the checkers' names
  const GroupCheckers& checkers;
  const GroupCheckers& judges;  ///< the same by Coal alone, to prove what was planned
  const PlannerOptions& options;
  const UserHeuristics& heuristics;
};

/// Answers it; throws PlanningError. `statistics` is filled either way.
MultiTrajectory plan_multi_robot(const MultiRobotProblem& problem, const Deadline& deadline,
                                 PlanStatistics& statistics);

}  // namespace srmp
