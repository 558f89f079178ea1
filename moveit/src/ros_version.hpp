#pragma once

// All that differs between MoveIt 1 (Noetic), MoveIt 2 Humble, and MoveIt 2 Jazzy and later. CMake defines
// SRMP_ROS_VERSION (1 or 2); from MoveIt 2.7.1 on SRMP_MOVEIT_RESPONSE_WITHOUT_UNDERSCORES (moveit2#1939), and
// from 2.9.0 on SRMP_MOVEIT_SOLVE_RETURNS_VOID (moveit2#2429). Headers end with .hpp from 2.12.0 on.

#include <map>
#include <sstream>
#include <string>
#include <vector>

#if SRMP_ROS_VERSION == 1

#include <moveit/planning_interface/planning_interface.h>
#include <moveit/planning_scene/planning_scene.h>
#include <moveit/robot_state/conversions.h>
#include <moveit_msgs/MotionPlanRequest.h>
#include <moveit_msgs/PlanningScene.h>
#include <ros/ros.h>

#include <pluginlib/class_list_macros.hpp>

namespace srmp_moveit {

namespace moveit_messages = moveit_msgs;
namespace shape_messages = shape_msgs;
namespace geometry_messages = geometry_msgs;
namespace sensor_messages = sensor_msgs;

#else

#if __has_include(<moveit/planning_interface/planning_interface.hpp>)
#include <moveit/planning_interface/planning_interface.hpp>
#include <moveit/planning_scene/planning_scene.hpp>
#include <moveit/robot_state/conversions.hpp>
#else
#include <moveit/planning_interface/planning_interface.h>
#include <moveit/planning_scene/planning_scene.h>
#include <moveit/robot_state/conversions.h>
#endif
#include <moveit_msgs/msg/motion_plan_request.hpp>
#include <moveit_msgs/msg/planning_scene.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp/rclcpp.hpp>

namespace srmp_moveit {

namespace moveit_messages = moveit_msgs::msg;
namespace shape_messages = shape_msgs::msg;
namespace geometry_messages = geometry_msgs::msg;
namespace sensor_messages = sensor_msgs::msg;

#endif

// --- responses

#ifdef SRMP_MOVEIT_SOLVE_RETURNS_VOID
using SolveResult = void;
inline void result_of_solve(bool) {}
#else
using SolveResult = bool;
inline bool result_of_solve(bool solved) { return solved; }
#endif

#ifdef SRMP_MOVEIT_RESPONSE_WITHOUT_UNDERSCORES
template <class Response>
auto& trajectory_of(Response& response) {
  return response.trajectory;
}
template <class Response>
auto& planning_time_of(Response& response) {
  return response.planning_time;
}
template <class Response>
auto& error_code_of(Response& response) {
  return response.error_code;
}
template <class Response>
auto& descriptions_of(Response& response) {
  return response.description;
}
template <class Response>
auto& processing_times_of(Response& response) {
  return response.processing_time;
}
#else
template <class Response>
auto& trajectory_of(Response& response) {
  return response.trajectory_;
}
template <class Response>
auto& planning_time_of(Response& response) {
  return response.planning_time_;
}
template <class Response>
auto& error_code_of(Response& response) {
  return response.error_code_;
}
template <class Response>
auto& descriptions_of(Response& response) {
  return response.description_;
}
template <class Response>
auto& processing_times_of(Response& response) {
  return response.processing_time_;
}
#endif

/// The code, and the sentence where the message has room for one (MoveIt 2).
template <class ErrorCodes>
auto set_code(ErrorCodes& codes, int value, const std::string& sentence) -> decltype(void(codes.message)) {
  codes.val = value;
  codes.message = sentence;
  codes.source = "SRMP";
}
template <class ErrorCodes, class... Sentence>
void set_code(ErrorCodes& codes, int value, const Sentence&...) {
  codes.val = value;
}

/// Planner configurations by name, with their options as text.
using Configurations = std::map<std::string, std::map<std::string, std::string>>;

#if SRMP_ROS_VERSION == 1

inline void log_error(const std::string& text) { ROS_ERROR_STREAM_NAMED("srmp", text); }
inline void log_warning(const std::string& text) { ROS_WARN_STREAM_NAMED("srmp", text); }
inline void log_debug(const std::string& text) { ROS_DEBUG_STREAM_NAMED("srmp", text); }

/// The parameters of a pipeline.
class Parameters {
 public:
  explicit Parameters(const std::string& name_space) : node_(name_space) {}

  /// A text that is a parameter of this name here or in a namespace above; "" where there is none.
  std::string text(const std::string& name) const {
    std::string found, value;
    if (node_.searchParam(name, found)) node_.getParam(found, value);
    return value;
  }
  std::vector<std::string> texts(const std::string& group, const std::string& name) const {
    std::vector<std::string> values;
    node_.getParam(group + "/" + name, values);
    return values;
  }
  std::string text(const std::string& group, const std::string& name) const {
    std::string value;
    node_.getParam(group + "/" + name, value);
    return value;
  }
  Configurations planner_configurations() const {
    Configurations configurations;
    XmlRpc::XmlRpcValue all;
    if (!node_.getParam("planner_configs", all) || all.getType() != XmlRpc::XmlRpcValue::TypeStruct)
      return configurations;
    for (auto& [name, options] : all) {
      configurations[name];
      if (options.getType() != XmlRpc::XmlRpcValue::TypeStruct) continue;
      for (auto& [option, value] : options) configurations[name][option] = as_text(value);
    }
    return configurations;
  }

 private:
  static std::string as_text(XmlRpc::XmlRpcValue& value) {
    if (value.getType() == XmlRpc::XmlRpcValue::TypeString) return static_cast<std::string>(value);
    if (value.getType() == XmlRpc::XmlRpcValue::TypeBoolean) return static_cast<bool>(value) ? "true" : "false";
    if (value.getType() != XmlRpc::XmlRpcValue::TypeArray) return value.toXml().empty() ? "" : number(value);
    std::string list;
    for (int i = 0; i < value.size(); ++i) list += (i ? " " : "") + as_text(value[i]);
    return list;
  }
  static std::string number(XmlRpc::XmlRpcValue& value) {
    std::ostringstream text;
    text.precision(17);
    if (value.getType() == XmlRpc::XmlRpcValue::TypeInt)
      text << static_cast<int>(value);
    else if (value.getType() == XmlRpc::XmlRpcValue::TypeDouble)
      text << static_cast<double>(value);
    return text.str();
  }

  ros::NodeHandle node_;
};

#else

inline rclcpp::Logger logger() { return rclcpp::get_logger("srmp"); }
inline void log_error(const std::string& text) { RCLCPP_ERROR_STREAM(logger(), text); }
inline void log_warning(const std::string& text) { RCLCPP_WARN_STREAM(logger(), text); }
inline void log_debug(const std::string& text) { RCLCPP_DEBUG_STREAM(logger(), text); }

/// The parameters of a pipeline.
class Parameters {
 public:
  Parameters(rclcpp::Node::SharedPtr node, const std::string& name_space)
      : node_(std::move(node)), prefix_(name_space.empty() ? "" : name_space + ".") {}

  /// A text that is a parameter of this name in the pipeline's namespace or of the node; "" where there is none.
  std::string text(const std::string& name) const {
    for (const std::string& full : {prefix_ + name, name})
      if (rclcpp::Parameter value; node_->get_parameter(full, value)) return as_text(value);
    return "";
  }
  std::vector<std::string> texts(const std::string& group, const std::string& name) const {
    rclcpp::Parameter value;
    const bool found = node_->get_parameter(prefix_ + group + "." + name, value) &&
                       value.get_type() == rclcpp::ParameterType::PARAMETER_STRING_ARRAY;
    return found ? value.as_string_array() : std::vector<std::string>{};
  }
  std::string text(const std::string& group, const std::string& name) const {
    rclcpp::Parameter value;
    return node_->get_parameter(prefix_ + group + "." + name, value) ? as_text(value) : "";
  }
  Configurations planner_configurations() const {
    Configurations configurations;
    const std::string prefix = prefix_ + "planner_configs.";
    for (const std::string& full : node_->list_parameters({prefix_ + "planner_configs"}, 10).names) {
      const std::string rest = full.substr(prefix.size());
      const std::size_t dot = rest.find('.');
      if (dot != std::string::npos)
        configurations[rest.substr(0, dot)][rest.substr(dot + 1)] = as_text(node_->get_parameter(full));
    }
    return configurations;
  }

 private:
  /// As the library reads options: value_to_string() writes six digits after the point, and lists in brackets.
  static std::string as_text(const rclcpp::Parameter& value) {
    using Type = rclcpp::ParameterType;
    const Type type = value.get_type();
    if (type == Type::PARAMETER_NOT_SET) return "";
    std::ostringstream text;
    text.precision(17);
    if (type == Type::PARAMETER_DOUBLE)
      text << value.as_double();
    else if (type == Type::PARAMETER_INTEGER)
      text << value.as_int();
    else if (type == Type::PARAMETER_STRING_ARRAY)
      for (const std::string& word : value.as_string_array()) text << (text.tellp() > 0 ? " " : "") << word;
    else
      text << value.value_to_string();
    return text.str();
  }

  rclcpp::Node::SharedPtr node_;
  std::string prefix_;
};

#endif

}  // namespace srmp_moveit
