#include "srmp/robot/joint_names.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_impl.hpp"

namespace srmp {

namespace {

/// Limits of joints are rarely wider; what is beyond them in radians is often in degrees.
constexpr double kMaxUsualAngle = 2 * std::numbers::pi;

std::string rounded(double value) { return to_text(std::round(value * 1e4) / 1e4); }

}  // namespace

const Joint* find_joint(const std::vector<Joint>& joints, const std::string& name) {
  const auto it = std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) { return joint.name == name; });
  return it == joints.end() ? nullptr : &*it;
}

std::string degrees_hint(const Joint& joint, double value) {
  const double radians = value * std::numbers::pi / 180.0;
  const bool fits = radians >= joint.lower && radians <= joint.upper;
  if (joint.kind == JointKind::prismatic || !(std::abs(value) > kMaxUsualAngle) || !fits) return {};
  return "; angles are in radians (" + to_text(value) + " degrees are " + rounded(radians) + " rad)";
}

std::string why_not_a_joint(const RobotModelImpl& robot, const std::string& name) {
  const std::string subject = "joint '" + name + "' of robot '" + robot.name + "' ";
  const auto index = robot.urdf.find_joint(name);
  if (!index) {
    std::vector<std::string> known = robot.joint_names;
    for (const Joint& other : robot.other_joints) known.push_back(other.name);
    return "robot '" + robot.name + "' has no joint '" + name + "'" + did_you_mean(name, known);
  }
  const UrdfJoint& joint = robot.urdf.joints[*index];
  if (joint.mimic)
    return subject + "follows joint '" + robot.urdf.joints[joint.mimic->source].name +
           "' (<mimic> in the URDF) and has no position of its own; set that one";
  if (joint.type == UrdfJointType::fixed) return subject + "is fixed and has no position";
  return subject + "has more than one degree of freedom and stays at its origin; set_base_pose moves the whole robot";
}

}  // namespace srmp
