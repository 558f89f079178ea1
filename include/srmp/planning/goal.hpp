#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/robot/inverse_kinematics.hpp"

namespace srmp {

enum class GoalType {
  joints,    ///< a configuration of the planned joints
  pose,      ///< position and orientation of the end effector, world frame
  position,  ///< position of the end effector, world frame; any orientation
  hold,      ///< with plan_multi: the robot stays where it starts
  any,       ///< with plan_multi: it may move out of the others' way and end anywhere
};

std::string_view to_string(GoalType type);

/// What a plan must reach: any one of several targets of one type. Joint targets are met exactly; for poses and
/// positions inverse kinematics supplies configurations, to 1e-5 m and 1e-4 rad where it can and within the
/// tolerances at worst.
struct GoalConstraint {
  GoalType type{GoalType::joints};
  /// One row a target; none with hold and aside. joints: dof numbers [rad or m]; pose: x, y, z, qx, qy, qz, qw;
  /// position: x, y, z [m].
  std::vector<Eigen::VectorXd> targets;
  /// Each a number, or one for each axis of the target's own frame (position targets: of the world); infinity: that
  /// axis is free, and the solutions are spread over it.
  AxisTolerance position_tolerance{1e-3};  ///< [m], > 0
  AxisTolerance rotation_tolerance{1e-2};  ///< [rad], > 0

  static GoalConstraint joints(const Eigen::VectorXd& q);
  static GoalConstraint pose(const Pose& pose);
  static GoalConstraint position(const Eigen::Vector3d& p);
  static GoalConstraint hold();
  static GoalConstraint any();

  /// Throws InvalidArgument: no target, wrong size, NaN, zero quaternion, a tolerance not above 0, all axes free.
  void validate() const;
};

}  // namespace srmp
