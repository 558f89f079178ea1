#pragma once

#include <string>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/trajectory/motion_limits.hpp"

namespace srmp::io {

/// The contents of a joint_limits.yaml for a robot's planned joints.
struct JointLimitsFile {
  MotionLimits limits;              ///< of the planned joints
  std::vector<std::string> unused;  ///< joints of the file that are not planned, in its order
};

/// Reads MoveIt's joint_limits.yaml (rad, metres, seconds):
///
///     default_velocity_scaling_factor: 0.1      # in (0, 1]: multiplies the velocity limits of all joints
///     default_acceleration_scaling_factor: 0.1  # the same for accelerations, and jerks with them
///     joint_limits:
///       elbow:
///         has_velocity_limits: true             # true: max_… is required, above 0; false: max_… is ignored
///         max_velocity: 2.5
///         has_acceleration_limits: true
///         max_acceleration: 5
///         has_jerk_limits: false
///
/// Limits that are not given are those of default_limits. Position limits may be as wide as the URDF's or wider, which
/// changes nothing; narrower ones (by more than 1e-5) belong in the URDF.
///
/// Throws FileError with file and line for a missing or empty file, unknown keys (with the nearest), and values that
/// are not numbers or out of range; NotSupported for narrower position limits, limits of deceleration or effort, soft
/// limits, and an angle_wraparound that is not the URDF's, each of a planned joint.
JointLimitsFile read_joint_limits(const std::string& path, const RobotModel& robot);

}  // namespace srmp::io
