#pragma once

#include <stdexcept>

#include "library.hpp"
#include "ros_version.hpp"

namespace srmp_moveit {

/// What of a message is wrong, or cannot be held by the library's structures; the session checks all else.
struct Refusal : std::runtime_error {
  Refusal(srmp::MoveItErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code(code) {}
  srmp::MoveItErrorCode code;
};

// ROS messages as the library's plain structures. Throw Refusal.

/// MoveIt's robot model, with its limits, and the texts that it was made of.
srmp::MoveItRobot robot_of(const moveit::core::RobotModel& model, const std::string& urdf_text,
                           const std::string& srdf_text);
/// The whole scene.
srmp::io::SceneFile scene_of(const Library& library, const planning_scene::PlanningScene& scene);
/// The request, whose start state is completed by the scene's as MoveIt does it.
srmp::io::RequestFile request_of(const Library& library, const moveit_messages::MotionPlanRequest& request,
                                 const planning_scene::PlanningScene& scene);
/// The trajectory, from a state that says where the other joints are. `rows` only: a path without times.
robot_trajectory::RobotTrajectoryPtr trajectory_of(const srmp::Trajectory& trajectory,
                                                   const moveit::core::RobotState& start, const std::string& group);
robot_trajectory::RobotTrajectoryPtr path_of(const srmp::Trajectory& trajectory, const moveit::core::RobotState& start,
                                             const std::string& group);

}  // namespace srmp_moveit
