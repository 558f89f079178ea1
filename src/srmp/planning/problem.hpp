#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/group_checkers.hpp"
#include "srmp/planning/request.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/user_heuristic.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// A start in motion. From `position`, where the robot has the velocity and acceleration, the motion goes straight to
/// RobotProblem::start, before which it could stop.
struct StartInMotion {
  Eigen::VectorXd position;                ///< (dof,) [rad or m]
  Eigen::VectorXd velocity, acceleration;  ///< (dof,)
};

/// What one robot of a problem is to do.
struct RobotProblem {
  std::string robot;
  Eigen::VectorXd start;              ///< dof [rad or m]
  std::vector<GoalConstraint> goals;  ///< any one of them; a single one of GoalType::any: every end will do
  MotionLimits limits;                ///< of the robot, not scaled by the options
  std::shared_ptr<const PlacedRobot> placed;
  std::shared_ptr<const PlacedConstraints> constraints{};  ///< of its path; null: none
  std::optional<StartInMotion> start_in_motion{};          ///< of one robot alone; none: it begins at rest

  bool may_end_anywhere() const { return goals.size() == 1 && goals.front().type == GoalType::any; }
};

/// What is to be planned: motions of n >= 1 robots on one clock. References outlive the plan.
struct PlanProblem {
  const Scene& scene;                ///< stationary robots stand at their starts, moving obstacles where they end
  std::vector<RobotProblem> robots;  ///< in the order of the checkers' names; at least one
  const ProblemCheckers& checkers;
  const PlannerOptions& options;
  const UserHeuristics& heuristics;
  OnSolution on_solution{};                       ///< of one robot alone; may be empty
  std::vector<RobotProblem> stationary{};         ///< robots that stay where they start
  std::map<std::string, Trajectory> obstacles{};  ///< by robot name: motions that others are committed to

  /// Whether one robot is planned, by a planner for one: that planner plans all there is.
  bool is_for_one() const;
};

}  // namespace srmp
