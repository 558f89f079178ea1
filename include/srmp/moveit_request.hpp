#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "srmp/io/moveit.hpp"
#include "srmp/planning/goal.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/path_constraint.hpp"

namespace srmp {

/// A MoveIt motion plan request (io::read_moveit_request) as a planning problem of one robot:
/// PlannerInterface::apply_moveit_request makes it, docs/moveit.md says of every field what it means here.
struct MoveItProblem {
  Eigen::VectorXd start;              ///< (dof,) [rad or m]; joints that the file leaves out stand at their set_qpos
  std::vector<GoalConstraint> goals;  ///< any one of them is enough
  /// For make_planner, what the request says: time_limit, velocity_scaling and acceleration_scaling where they are
  /// given, and planner_id where it is an id of this library.
  OptionMap options;
  std::vector<std::string> ignored_joints;  ///< named by the start state, but not movable joints of this robot
  std::vector<PathConstraint> constraints;  ///< of the whole motion: PlanRequest::constraints
  Eigen::VectorXd start_velocity;           ///< (dof,) [rad/s or m/s]: PlanRequest::start_velocity; empty: at rest
  /// For MotionLimits::link_speeds: the request's max_cartesian_speed, of its cartesian_speed_limited_link.
  std::vector<LinkSpeedLimit> link_speeds{};
};

}  // namespace srmp
