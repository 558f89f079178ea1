#pragma once

#include "srmp/collision/checker.hpp"
#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/user_heuristic.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// One question to a single-robot planner. References outlive the call.
struct SingleRobotProblem {
  const Scene& scene;
  const std::string& robot;
  const Checker& checker;
  Eigen::VectorXd start;
  const std::vector<GoalConstraint>& goals;
  const PlannerOptions& options;
  const UserHeuristics& heuristics;
  MotionLimits limits;  ///< of the robot, not scaled
  OnSolution on_solution;
  std::shared_ptr<const PlacedRobot> placed{};  ///< `robot` as it stands in `scene`, for Trajectory::robot
};

/// Answers it; throws PlanningError. `statistics` is filled either way.
Trajectory plan_single_robot(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics);

/// A way of one robot, before it is timed.
struct RobotPath {
  Eigen::VectorXd start;                   ///< free, within limits
  std::vector<Eigen::VectorXd> targets;    ///< configurations that meet a goal, free
  std::vector<int> goal_indices;           ///< of the targets: PlanStatistics::goal_index
  std::vector<Eigen::VectorXd> waypoints;  ///< from start to one of them
};
/// The same question without timing, and without a way out of a start in collision; throws PlanningError.
RobotPath find_robot_path(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics);

}  // namespace srmp
