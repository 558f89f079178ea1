#pragma once

// Problems of MotionBenchMaker as MoveIt's scenes and requests.

#include <string>

#include "ros_version.hpp"

/// The Panda of the data; sets robot_description and robot_description_semantic, where the plugin reads them.
moveit::core::RobotModelPtr load_panda(const std::string& directory);

/// Two arms of three joints side by side in the plane, within reach of each other: groups "left", "right" and, of both,
/// "both".
moveit::core::RobotModelPtr load_two_arms();

/// A scene of a file, its objects given in the frame "camera", which the scene knows.
planning_scene::PlanningScenePtr read_scene(const std::string& path, const moveit::core::RobotModelPtr& model);

/// The joint goal of a request file, with its start state.
srmp_moveit::moveit_messages::MotionPlanRequest read_request(const std::string& path);

/// The same goal as a pose of the last link, in the frame of an object of the scene.
srmp_moveit::moveit_messages::MotionPlanRequest with_pose_goal(srmp_moveit::moveit_messages::MotionPlanRequest request,
                                                               const planning_scene::PlanningScene& scene);

/// Adds a box [m] at a position in the model's frame.
void add_box(planning_scene::PlanningScene& scene, const std::string& id, const Eigen::Vector3d& position,
             const Eigen::Vector3d& size);
