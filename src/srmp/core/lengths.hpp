#pragma once

#include <Eigen/Core>
#include <string>

#include "srmp/core/pose.hpp"

namespace srmp {

/// No robot and no scene is larger than this [m]: what exceeds it is a mistake, such as millimetres for metres, and
/// beyond what distances, boxes and grids in double precision can represent soundly.
inline constexpr double max_length = 1000.0;

/// No joint goes farther than this in one motion [rad or m]: checking a motion takes time in proportion to its length.
inline constexpr double max_joint_travel = 1e4;

/// "; at most 1000 m are allowed": the end of the sentence that refuses a length.
std::string length_rule();

/// Throws InvalidArgument unless `value` is above 0 and at most max_length; `what` names it.
void require_length(double value, const std::string& what);

/// Throws InvalidArgument unless every coordinate is finite and at most max_length from 0; `what` names the point.
void require_position(const Eigen::Vector3d& point, const std::string& what);

/// The pose with a unit quaternion. Throws InvalidArgument with the owner's name for NaN, infinity, a zero quaternion
/// and a place beyond max_length. A quaternion of unit length is returned bit for bit, so that scenes do not change
/// when they are saved and loaded.
Pose checked_pose(const Pose& pose, const std::string& owner);

}  // namespace srmp
