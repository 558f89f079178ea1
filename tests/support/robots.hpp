#pragma once

#include <memory>
#include <string>

#include "srmp/robot/robot_model.hpp"

/// Tiny robots, as URDF text.
namespace robots {

inline std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& origin, const std::string& axis,
                         const std::string& limit) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
         "'/><origin xyz='" + origin + "'/><axis xyz='" + axis + "'/>" + limit + "</joint>";
}

inline std::string bar(const std::string& name) {
  return "<link name='" + name +
         "'><collision><origin xyz='0.5 0 0'/><geometry><box size='0.9 0.1 0.1'/></geometry></collision></link>";
}

/// Two bars of 1 m in the plane, turning about z:   base ──a── upper ──b── lower ── tip
inline srmp::RobotDescription planar_description(const std::string& first_joint = "revolute") {
  const std::string limit = "<limit lower='-3' upper='3' velocity='2' effort='1'/>";
  srmp::RobotDescription description;
  description.urdf_text = "<robot name='planar'><link name='base'/>" + bar("upper") + bar("lower") +
                          "<link name='tip'/>" + joint("a", first_joint, "base", "upper", "0 0 0", "0 0 1", limit) +
                          joint("b", "revolute", "upper", "lower", "1 0 0", "0 0 1", limit) +
                          joint("t", "fixed", "lower", "tip", "1 0 0", "0 0 1", "") + "</robot>";
  description.end_effector = "tip";
  return description;
}

inline std::shared_ptr<const srmp::RobotModel> planar(const std::string& first_joint = "revolute") {
  return srmp::RobotModel::load(planar_description(first_joint));
}

/// Three bars, the first joint of the kind given:   base ──a── upper ──b── middle ──c── lower ── tip
inline std::shared_ptr<const srmp::RobotModel> planar3(const std::string& first_joint = "revolute") {
  const std::string limit = "<limit lower='-3' upper='3' velocity='2' effort='1'/>";
  srmp::RobotDescription description;
  description.urdf_text = "<robot name='planar3'><link name='base'/>" + bar("upper") + bar("middle") + bar("lower") +
                          "<link name='tip'/>" + joint("a", first_joint, "base", "upper", "0 0 0", "0 0 1", limit) +
                          joint("b", "revolute", "upper", "middle", "1 0 0", "0 0 1", limit) +
                          joint("c", "revolute", "middle", "lower", "1 0 0", "0 0 1", limit) +
                          joint("t", "fixed", "lower", "tip", "1 0 0", "0 0 1", "") + "</robot>";
  description.end_effector = "tip";
  return srmp::RobotModel::load(description);
}

}  // namespace robots
