#pragma once

// All that differs in the checks between MoveIt 1 and MoveIt 2, beside ../src/ros_version.hpp.

#include <memory>

#include "ros_version.hpp"

#if SRMP_ROS_VERSION == 1
#include <moveit/planning_pipeline/planning_pipeline.h>
#include <moveit/robot_model_loader/robot_model_loader.h>
#include <tf2_eigen/tf2_eigen.h>
#else
#if __has_include(<moveit/planning_pipeline/planning_pipeline.hpp>)
#include <moveit/planning_pipeline/planning_pipeline.hpp>
#include <moveit/robot_model_loader/robot_model_loader.hpp>
#else
#include <moveit/planning_pipeline/planning_pipeline.h>
#include <moveit/robot_model_loader/robot_model_loader.h>
#endif
#include <tf2_eigen/tf2_eigen.hpp>
#endif

namespace srmp_moveit {

template <class Response>
int code_of(const Response& response) {
  return error_code_of(response).val;
}
template <class Response>
bool is_solved(const Response& response) {
  return code_of(response) == moveit_messages::MoveItErrorCodes::SUCCESS;
}

#if SRMP_ROS_VERSION == 1

inline void start_node(int& argc, char** argv) {
  ros::init(argc, argv, "srmp_moveit_check", ros::init_options::AnonymousName);
}
inline void set_parameter(const std::string& name, const std::string& text) { ros::param::set(name, text); }
inline std::unique_ptr<robot_model_loader::RobotModelLoader> load_model(const std::string& description) {
  return std::make_unique<robot_model_loader::RobotModelLoader>(description);
}
inline std::unique_ptr<planning_pipeline::PlanningPipeline> make_pipeline(const moveit::core::RobotModelPtr& model,
                                                                          const std::string& name_space) {
  return std::make_unique<planning_pipeline::PlanningPipeline>(model, ros::NodeHandle(name_space));
}
inline void set_padding(planning_scene::PlanningScene& scene, double padding) {
  scene.getCollisionEnvNonConst()->setPadding(padding);
  scene.propogateRobotPadding();
}

#else

/// One node, with the parameters of --params-file, as move_group's.
inline rclcpp::Node::SharedPtr& node() {
  static rclcpp::Node::SharedPtr node;
  return node;
}
inline void start_node(int& argc, char** argv) {
  const std::vector<std::string> rest = rclcpp::init_and_remove_ros_arguments(argc, argv);
  argc = static_cast<int>(rest.size());  // which stand first
  node() = std::make_shared<rclcpp::Node>("srmp_moveit_check",
                                          rclcpp::NodeOptions().automatically_declare_parameters_from_overrides(true));
}
inline void set_parameter(const std::string& name, const std::string& text) { node()->declare_parameter(name, text); }
inline std::unique_ptr<robot_model_loader::RobotModelLoader> load_model(const std::string& description) {
  return std::make_unique<robot_model_loader::RobotModelLoader>(node(), description);
}
inline std::unique_ptr<planning_pipeline::PlanningPipeline> make_pipeline(const moveit::core::RobotModelPtr& model,
                                                                          const std::string& name_space) {
  return std::make_unique<planning_pipeline::PlanningPipeline>(model, node(), name_space);
}
inline void set_padding(planning_scene::PlanningScene& scene, double padding) {
  scene.getCollisionEnvNonConst()->setPadding(padding);
}

#endif

}  // namespace srmp_moveit
