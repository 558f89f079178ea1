#pragma once

// Internal: the rules that MoveIt's messages keep to, wherever they come from. The readers of files apply them where
// they read a value, so that errors have a line; require_valid applies them to messages that were filled by a program.

#include <string>

#include "srmp/io/moveit.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp::io {

inline constexpr double rest_speed = 0.01;  // [rad/s or m/s]: sensors of a robot that stands report a little velocity

inline const std::string prism_fault = "is a prism, which is not supported; use a mesh";
inline const std::string plane_fault = ", which are not supported; use a large box";

// What is wrong, as a sentence; "" = nothing.

std::string scaling_fault(const std::string& field, double value);
std::string tolerance_fault(const std::string& field, double value);
std::string time_fault(double allowed_planning_time);
std::string attempts_fault(double attempts);
std::string workspace_fault(const WorkspaceBounds& bounds);
std::string length_fault(double quaternion_length);
std::string padding_fault(const std::string& link, double padding);
/// What of path constraints is not supported.
std::string path_constraints_fault(const GoalAlternative& path);

/// No constraint at all?
bool holds_nothing(const GoalAlternative& constraints);
/// Does a joint move, faster than sensors report of one that stands?
bool is_moving(const RobotState& start);

/// The sentences about what is never right.
std::string cartesian_speed_fault(double max_cartesian_speed);
std::string unsupported(const std::string& field);
std::string twice_fault(const std::string& joint);
std::string scale_fault(const std::string& link);

// Throw InvalidArgument for what is wrong and NotSupported for what is not supported.

/// A start state: finite, and multi-dof joints at rest.
void require_valid(const RobotState& start);
/// A goal: at least one constraint, tolerances, unit quaternions, sizes.
void require_valid(const GoalAlternative& goal);
/// A request but for its start and its goals.
void require_valid(const RequestFile& request);
/// A scene but for its robot state's joints.
void require_valid(const SceneFile& scene);

/// The velocity of the planned joints [rad/s or m/s]; empty where all stand still, to rest_speed. Throws NotSupported
/// for joints that are not planned and move.
Eigen::VectorXd start_velocity(const RobotState& start, const RobotModel& robot);

}  // namespace srmp::io
