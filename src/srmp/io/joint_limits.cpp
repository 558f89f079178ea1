#include "srmp/io/joint_limits.hpp"

#include <optional>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/io/yaml_reader.h"

namespace srmp::io {

namespace {

using YAML::Node;
using Names = std::vector<std::string>;

constexpr double rounding = 1e-5;  // [rad or m]: a position limit of pi, written with six digits, is not narrower

const Names file_keys{"joint_limits", "default_velocity_scaling_factor", "default_acceleration_scaling_factor"};
const Names joint_keys{"has_position_limits",
                       "min_position",
                       "max_position",
                       "has_velocity_limits",
                       "max_velocity",
                       "has_acceleration_limits",
                       "max_acceleration",
                       "has_jerk_limits",
                       "max_jerk",
                       "angle_wraparound",
                       "has_deceleration_limits",
                       "max_deceleration",
                       "has_effort_limits",
                       "max_effort",
                       "has_soft_limits",
                       "k_position",
                       "k_velocity",
                       "soft_lower_limit",
                       "soft_upper_limit"};

class JointLimitsReader {
 public:
  JointLimitsReader(const std::string& path, const RobotModel& robot)
      : file_(path), joints_(robot.joints()), result_{default_limits(robot), {}} {}

  JointLimitsFile read() {
    const Node& root = file_.root();
    file_.require_map(root, "a joint limits file", file_keys);
    if (const Node joints = root["joint_limits"]; !is_empty(joints)) read_joints(joints);
    MotionLimits& limits = result_.limits;
    limits.velocity *= scaling(root, "default_velocity_scaling_factor");
    const double acceleration = scaling(root, "default_acceleration_scaling_factor");
    limits.acceleration *= acceleration;
    limits.jerk *= acceleration;
    return result_;
  }

 private:
  void read_joints(const Node& joints) {
    if (!joints.IsMap()) file_.fail(joints, "joint_limits must be a map of joint names");
    std::set<std::string> seen;
    for (const auto& entry : joints) {
      const std::string name = file_.text(entry.first, "a joint's name");
      if (!seen.insert(name).second) file_.fail(entry.first, "joint '" + name + "' appears twice in joint_limits");
      file_.require_map(entry.second, "the limits of '" + name + "'", joint_keys);
      const auto joint = std::find_if(joints_.begin(), joints_.end(), [&](const Joint& j) { return j.name == name; });
      if (joint == joints_.end())
        result_.unused.push_back(name);
      else
        read_joint(entry.second, *joint, joint - joints_.begin());
    }
  }

  void read_joint(const Node& node, const Joint& joint, Eigen::Index j) {
    if (const auto limit = above_zero(node, joint.name, "velocity")) result_.limits.velocity[j] = *limit;
    if (const auto limit = above_zero(node, joint.name, "acceleration")) result_.limits.acceleration[j] = *limit;
    if (const auto limit = above_zero(node, joint.name, "jerk")) result_.limits.jerk[j] = *limit;
    if (flag(node, joint.name, "has_position_limits").value_or(true)) check_positions(node, joint);
    for (const char* key : {"has_deceleration_limits", "has_effort_limits", "has_soft_limits"})
      if (flag(node, joint.name, key).value_or(false))
        file_.unsupported(node[key], joint.name + ": " + key + " is true, but only limits of velocity, acceleration " +
                                         "and jerk are supported; set it to false");
    const auto wraps = flag(node, joint.name, "angle_wraparound");
    if (wraps && *wraps != (joint.kind == JointKind::continuous))
      file_.unsupported(node["angle_wraparound"], joint.name + ": angle_wraparound is " + (*wraps ? "true" : "false") +
                                                      ", but the URDF's joint is " +
                                                      (*wraps ? "not continuous" : "continuous"));
  }

  std::optional<bool> flag(const Node& node, const std::string& joint, const std::string& key) const {
    if (!node[key].IsDefined()) return {};
    return file_.boolean(node[key], joint + ": " + key);
  }

  double number(const Node& node, const std::string& what) const {
    if (const std::string& tag = node.Tag(); tag.size() > 1)
      file_.unsupported(node, what + " has the tag " + tag + "; only plain numbers are read, in rad, metres, seconds");
    return file_.number(node, what);
  }

  /// max_<what>; none: the file does not limit it.
  std::optional<double> above_zero(const Node& node, const std::string& joint, const std::string& what) const {
    const std::string has = "has_" + what + "_limits", max = "max_" + what;
    const auto limited = flag(node, joint, has);
    if (!limited.value_or(true)) return {};
    if (!node[max].IsDefined()) {
      if (limited) file_.fail(node[has], joint + ": " + has + " is true, but there is no " + max);
      return {};
    }
    const double limit = number(node[max], joint + ": " + max);
    if (!(limit > 0.0)) file_.fail(node[max], joint + ": " + max + " is " + to_text(limit) + "; it must be above 0");
    return limit;
  }

  void check_positions(const Node& node, const Joint& joint) const {
    const auto check = [&](const char* key, bool is_upper, double urdf) {
      if (!node[key].IsDefined()) return;
      const double limit = number(node[key], joint.name + ": " + key);
      if (is_upper ? limit >= urdf - rounding : limit <= urdf + rounding) return;
      file_.unsupported(node[key], joint.name + ": " + key + " is " + to_text(limit) + ", but the URDF's limit is " +
                                       to_text(urdf) + "; narrower position limits belong in the URDF");
    };
    check("min_position", false, joint.lower);
    check("max_position", true, joint.upper);
  }

  double scaling(const Node& root, const std::string& key) const {
    if (!root[key].IsDefined()) return 1.0;
    const double factor = number(root[key], key);
    if (!(factor > 0.0 && factor <= 1.0))
      file_.fail(root[key], key + " is " + to_text(factor) + "; it must be above 0 and at most 1");
    return factor;
  }

  YamlFile file_;
  const std::vector<Joint>& joints_;
  JointLimitsFile result_;
};

}  // namespace

JointLimitsFile read_joint_limits(const std::string& path, const RobotModel& robot) {
  return JointLimitsReader(path, robot).read();
}

}  // namespace srmp::io
