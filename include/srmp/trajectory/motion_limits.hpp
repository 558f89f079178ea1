#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "srmp/robot/robot_description.hpp"

namespace srmp {

class RobotModel;

/// A limit of how fast a link of the robot moves, at every instant.
struct LinkSpeedLimit {
  std::string link{};                                             ///< "" = the end effector
  double speed{std::numeric_limits<double>::infinity()};          ///< of `point` [m/s], > 0; infinity: not limited
  double angular_speed{std::numeric_limits<double>::infinity()};  ///< [rad/s], > 0; infinity: not limited
  Eigen::Vector3d point{0.0, 0.0, 0.0};                           ///< whose speed it is, in the link's frame [m]
  /// Whether all numbers are the same.
  bool operator==(const LinkSpeedLimit& other) const {
    return link == other.link && speed == other.speed && angular_speed == other.angular_speed && point == other.point;
  }
};

/// Limits beyond these no machine has. Computing with them would lose the digits of a double.
inline constexpr double min_motion_limit = 1e-6, max_motion_limit = 1e9;

/// Limits of each joint's motion; all > 0, one entry a joint, in the order of the joint names.
struct MotionLimits {
  Eigen::VectorXd velocity;      ///< [rad/s or m/s]
  Eigen::VectorXd acceleration;  ///< [rad/s^2 or m/s^2]
  Eigen::VectorXd jerk;          ///< [rad/s^3 or m/s^3]
  std::vector<bool> continuous;  ///< joints that turn without limits: waypoints follow by the short way; empty = none
  std::vector<LinkSpeedLimit> link_speeds{};  ///< limits of links, in the world; any number of a link
  /// [N m, prismatic joints N], > 0, infinity: not limited; of the torques that the motion needs in gravity, by the
  /// masses of the URDF. Empty: none is limited.
  Eigen::VectorXd torque{};
  std::optional<Payload> payload{};  ///< that counts in the torques; none: nothing is carried

  /// Number of joints.
  std::size_t size() const { return static_cast<std::size_t>(velocity.size()); }
};

/// Limits for robots of which only velocity limits are known: acceleration = 2/s * velocity (full speed in half a
/// second) and jerk = 10/s * acceleration. A velocity limit of 0, or none (infinite, or above 1e6), becomes 1.0 rad/s
/// (m/s). Throws InvalidArgument when one is negative or NaN.
MotionLimits default_limits(const Eigen::VectorXd& velocity);
/// The same from the model's velocity limits, with its continuous joints.
MotionLimits default_limits(const RobotModel& robot);

/// (dof,) the URDF's effort limits, for MotionLimits::torque; infinity for joints without one. Throws InvalidArgument
/// where no joint has one.
Eigen::VectorXd effort_limits(const RobotModel& robot);

/// Throws InvalidArgument unless there is one of each a joint, all above 0 (of torques: or none), every limit of a link
/// limits something, and the payload is one; names the joint or link. Whether the robot has the links is not checked.
void require_limits(const MotionLimits& limits, const std::vector<std::string>& joint_names);

}  // namespace srmp
