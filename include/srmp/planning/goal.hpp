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
  pose,      ///< position and orientation of the end effector, or of links, world frame
  position,  ///< position of the end effector, or of links, world frame; any orientation
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
  /// frame; position: x, y, z [m], world frame. With n links a target has as many numbers for each link in turn.
  std::vector<Eigen::VectorXd> targets;
  /// Each a number, or one for each axis of the target's own frame (position targets: of the world); infinity: that
  /// axis is free, and the solutions are spread over it.
  AxisTolerance position_tolerance{1e-3};  ///< [m], > 0
  AxisTolerance rotation_tolerance{1e-2};  ///< [rad], > 0
  /// Whose poses or positions the targets are: links of the robot, all of which reach theirs at the same time, each to
  /// the tolerances. Empty: the end effector.
  std::vector<std::string> links{};

  /// A configuration of the planned joints (dof,) [rad or m].
  static GoalConstraint joints(const Eigen::VectorXd& q);
  /// A pose of a link ("" = the end effector) in the world frame.
  static GoalConstraint pose(const Pose& pose, const std::string& link = "");
  /// Poses of links in the world frame, by link name, which are reached at the same time: both hands on a box.
  static GoalConstraint poses(const std::map<std::string, Pose>& of_links);
  /// A position of a link ("" = the end effector) in the world frame [m], with any orientation.
  static GoalConstraint position(const Eigen::Vector3d& p, const std::string& link = "");
  /// With plan_multi: the robot stays where it starts.
  static GoalConstraint hold();
  /// With plan_multi: the robot may move out of the others' way and end anywhere.
  static GoalConstraint any();

  /// Throws InvalidArgument for no target, a wrong size, NaN, a zero quaternion, a tolerance that is not above 0, when
  /// all axes are free, for a link that is named twice or has no name, and for links of a goal without poses.
  void validate() const;
};

/// A goal in any form that PlannerInterface::plan accepts: a GoalConstraint; a pose of the end effector in the world
/// frame; a configuration (dof,) [rad or m]; positions [rad or m] of planned joints by name, where joints not named
/// stay as at the start; the name of a state of the SRDF that gives every planned joint (RobotModel::group_states); or
/// poses of links in the world frame by link name, which are reached at the same time.
using Goal = std::variant<GoalConstraint, Pose, Eigen::VectorXd, std::map<std::string, double>, std::string,
                          std::map<std::string, Pose>>;

}  // namespace srmp
