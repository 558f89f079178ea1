#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace srmp {

class RobotModel;

/// Limits of each joint's motion; all > 0, one entry a joint, in the order of the joint names.
struct MotionLimits {
  Eigen::VectorXd velocity;      ///< [rad/s or m/s]
  Eigen::VectorXd acceleration;  ///< [rad/s^2 or m/s^2]
  Eigen::VectorXd jerk;          ///< [rad/s^3 or m/s^3]
  std::vector<bool> continuous;  ///< joints that turn without limits: waypoints follow by the short way; empty = none

  /// Number of joints.
  std::size_t size() const { return static_cast<std::size_t>(velocity.size()); }
};

/// Limits for robots of which only velocity limits are known: acceleration = 2/s * velocity (full speed in half a
/// second) and jerk = 10/s * acceleration. A velocity limit of 0, or none (infinite, or above 1e6), becomes 1.0 rad/s
/// (m/s). Throws InvalidArgument when one is negative or NaN.
MotionLimits default_limits(const Eigen::VectorXd& velocity);
/// The same from the model's velocity limits, with its continuous joints.
MotionLimits default_limits(const RobotModel& robot);

/// Throws InvalidArgument unless there is one of each a joint, all above 0; names the joint.
void require_limits(const MotionLimits& limits, const std::vector<std::string>& joint_names);

}  // namespace srmp
