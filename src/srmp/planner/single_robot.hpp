#pragma once

#include "srmp/planner/planner_interface.hpp"

namespace srmp {

/// One question to a single-robot planner. References outlive the call.
struct SingleRobotProblem {
  const Scene& scene;
  const std::string& robot;
  const Checker& checker;
  const Checker& judge;  ///< of the same scene, for the certificate: CheckMode::coal
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

}  // namespace srmp
