#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/robot/inverse_kinematics.hpp"

namespace srmp {

/// The kind of a goal: what its targets are.
enum class GoalType {
  joints,    ///< a configuration of the planned joints
  pose,      ///< position and orientation of the end effector, world frame
  position,  ///< position of the end effector, world frame; any orientation
  hold,      ///< with plan_multi: the robot stays where it starts
  any,       ///< with plan_multi: the robot may move out of the others' way and end anywhere
};

/// The name in files and messages: "joints", "pose", "position", "hold" or "any".
std::string_view to_string(GoalType type);

/// A goal of a plan: any one of several targets of one type. Joint targets are reached exactly; for poses and positions
/// inverse kinematics supplies configurations, to 1e-5 m and 1e-4 rad where it can and within the tolerances otherwise.
struct GoalConstraint {
  GoalType type{GoalType::joints};  ///< what the targets are
  /// The targets, none with hold and any. joints: dof numbers [rad or m]; pose: x, y, z [m], qx, qy, qz, qw, world
  /// frame; position: x, y, z [m], world frame.
  std::vector<Eigen::VectorXd> targets;
  /// Each a number, or one for each axis of the target's own frame (position targets: of the world); infinity: that
  /// axis is free, and the solutions are spread over it.
  AxisTolerance position_tolerance{1e-3};  ///< [m], > 0
  AxisTolerance rotation_tolerance{1e-2};  ///< [rad], > 0

  /// A configuration of the planned joints (dof,) [rad or m].
  static GoalConstraint joints(const Eigen::VectorXd& q);
  /// A pose of the end effector in the world frame.
  static GoalConstraint pose(const Pose& pose);
  /// A position of the end effector in the world frame [m], with any orientation.
  static GoalConstraint position(const Eigen::Vector3d& p);
  /// With plan_multi: the robot stays where it starts.
  static GoalConstraint hold();
  /// With plan_multi: the robot may move out of the others' way and end anywhere.
  static GoalConstraint any();

  /// Throws InvalidArgument for no target, a wrong size, NaN, a zero quaternion, a tolerance that is not above 0, and
  /// when all axes are free.
  void validate() const;
};

/// A goal in any form that PlannerInterface::plan accepts: a GoalConstraint; a pose of the end effector in the world
/// frame; a configuration (dof,) [rad or m]; positions [rad or m] of planned joints by name, where joints not named
/// stay as at the start; or the name of a state of the SRDF that gives every planned joint (RobotModel::group_states).
using Goal = std::variant<GoalConstraint, Pose, Eigen::VectorXd, std::map<std::string, double>, std::string>;

}  // namespace srmp
