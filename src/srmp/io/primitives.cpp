#include "srmp/io/primitives.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/io/yaml_reader.h"

namespace srmp::io {

namespace {

using YAML::Node;
using Names = std::vector<std::string>;

const Names set_keys{"units", "families", "near_distance", "prismatic"};
const Names family_keys{"name", "joints", "by", "use"};

class PrimitiveReader {
 public:
  PrimitiveReader(const std::string& path, const std::vector<Joint>& joints) : file_(path), joints_(joints) {
    for (const Joint& joint : joints) joint_names_.push_back(joint.name);
  }

  PrimitiveSet read() {
    const Node& root = file_.root();
    file_.require_map(root, "a primitive file", set_keys);
    read_units(file_.require(root, "units", "a primitive file"));
    read_lengths(root);
    const Node families = file_.require(root, "families", "a primitive file");
    file_.require_list(families, "families");
    for (const Node& family : families) set_.families.push_back(read_family(family));
    require_moves_everywhere(families);
    return set_;
  }

 private:
  void read_units(const Node& node) {
    const std::string units = file_.text(node, "units");
    if (units != "degrees" && units != "radians")
      file_.fail(node, "units are '" + units + "'; they must be degrees or radians");
    degrees_ = units == "degrees";
  }

  void read_lengths(const Node& root) {
    if (const Node node = root["near_distance"]; !is_empty(node)) {
      set_.near_distance = file_.number(node, "near_distance");
      if (set_.near_distance < 0.0)
        file_.fail(node, "near_distance is " + to_text(set_.near_distance) + "; it must be 0 or above");
    }
    if (const Node node = root["prismatic"]; !is_empty(node)) {
      prismatic_step_ = file_.number(node, "prismatic");
      if (!(prismatic_step_ > 0.0))
        file_.fail(node, "prismatic is " + to_text(prismatic_step_) + " m; it must be above 0");
    }
  }

  PrimitiveFamily read_family(const Node& node) {
    file_.require_map(node, "a family", family_keys);
    PrimitiveFamily family;
    const Node name = file_.require(node, "name", "a family");
    family.name = file_.text(name, "a family's name");
    if (family.name.empty()) file_.fail(name, "a family's name is empty");
    for (const PrimitiveFamily& other : set_.families)
      if (other.name == family.name) file_.fail(name, "there are two families named '" + family.name + "'");
    family.use = read_use(node["use"]);
    const std::string what = "family '" + family.name + "'";
    const Node joints = file_.require(node, "joints", what), by = file_.require(node, "by", what);
    if (joints.IsScalar())
      read_each(joints, by, family);
    else
      read_joint_list(joint_indices(joints, what), by, family);
    return family;
  }

  PrimitiveUse read_use(const Node& node) const {
    if (is_empty(node)) return PrimitiveUse::always;
    const std::string use = file_.text(node, "use");
    if (use == "always") return PrimitiveUse::always;
    if (use == "far") return PrimitiveUse::far;
    if (use == "near") return PrimitiveUse::near;
    file_.fail(node, "use is '" + use + "'; it must be far, near or always");
  }

  /// Every planned joint alone; prismatic ones by the file's step.
  void read_each(const Node& joints, const Node& by, PrimitiveFamily& family) const {
    const std::string text = file_.text(joints, "joints");
    if (text != "each") file_.fail(joints, "joints is '" + text + "'; it must be 'each' or a list of joint names");
    const double step = file_.number(by, "by, for each joint,");
    for (std::size_t j = 0; j < joints_.size(); ++j)
      add(by, {j}, {joints_[j].kind == JointKind::prismatic && step != 0.0 ? prismatic_step_ : to_native(step, j)},
          family);
  }

  std::vector<std::size_t> joint_indices(const Node& list, const std::string& what) const {
    file_.require_list(list, what + "'s joints");
    std::vector<std::size_t> indices;
    for (const Node& node : list) {
      const std::string name = file_.text(node, "a joint name");
      const auto found = std::find(joint_names_.begin(), joint_names_.end(), name);
      if (found == joint_names_.end()) {
        const std::string nearest = did_you_mean(name, joint_names_);
        file_.fail(node, "unknown joint '" + name + "'" +
                             (nearest.empty() ? "; planned joints are " + quoted_list(joint_names_) : nearest));
      }
      const auto index = static_cast<std::size_t>(found - joint_names_.begin());
      if (std::find(indices.begin(), indices.end(), index) != indices.end())
        file_.fail(node, "joint '" + name + "' appears twice in " + what);
      indices.push_back(index);
    }
    if (indices.empty()) file_.fail(list, what + " names no joints");
    return indices;
  }

  void read_joint_list(const std::vector<std::size_t>& joints, const Node& by, PrimitiveFamily& family) const {
    if (by.IsScalar()) {
      require_one_unit(by, joints);
      add_native(by, joints, std::vector<double>(joints.size(), file_.number(by, "by")), family);
      return;
    }
    file_.require_list(by, "by");
    if (by.size() == 0) file_.fail(by, "by is an empty list");
    if (!by[0].IsSequence()) {
      add_native(by, joints, file_.numbers(by, "by", joints.size()), family);
      return;
    }
    for (const Node& alternative : by)
      add_native(alternative, joints, file_.numbers(alternative, "an alternative of by", joints.size()), family);
  }

  /// One number for revolute and prismatic joints would be degrees and metres at once.
  void require_one_unit(const Node& by, const std::vector<std::size_t>& joints) const {
    const auto prismatic = [&](std::size_t j) { return joints_[j].kind == JointKind::prismatic; };
    if (std::any_of(joints.begin(), joints.end(), prismatic) && !std::all_of(joints.begin(), joints.end(), prismatic))
      file_.fail(
          by, "by is one number, but some of the joints are revolute and some prismatic; write one number per joint");
  }

  double to_native(double value, std::size_t joint) const {
    if (joints_[joint].kind == JointKind::prismatic || !degrees_) return value;
    return value * std::numbers::pi / 180.0;
  }

  void add_native(const Node& at, const std::vector<std::size_t>& joints, std::vector<double> values,
                  PrimitiveFamily& family) const {
    for (std::size_t i = 0; i < joints.size(); ++i) values[i] = to_native(values[i], joints[i]);
    add(at, joints, values, family);
  }

  /// The move and its opposite.
  void add(const Node& at, const std::vector<std::size_t>& joints, const std::vector<double>& values,
           PrimitiveFamily& family) const {
    Eigen::VectorXd move = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(joints_.size()));
    for (std::size_t i = 0; i < joints.size(); ++i) {
      if (joints_[joints[i]].kind != JointKind::prismatic && std::abs(values[i]) > std::numbers::pi)
        file_.fail(at, "joint '" + joint_names_[joints[i]] + "' would move by " + to_text(values[i]) +
                           " rad; at most half a turn is allowed (are the units right?)");
      move[static_cast<Eigen::Index>(joints[i])] = values[i];
    }
    if (move.isZero(0.0))
      file_.fail(at, "a move of family '" + family.name + "' is zero; at least one joint must move");
    for (const Eigen::VectorXd& other : family.moves)
      if (other == move)
        file_.fail(at, "a move of family '" + family.name + "' is repeated (every move is made in both directions)");
    family.moves.push_back(move);
    family.moves.push_back(-move);
  }

  void require_moves_everywhere(const Node& families) const {
    const auto used = [&](PrimitiveUse use) {
      return std::any_of(set_.families.begin(), set_.families.end(), [&](const PrimitiveFamily& family) {
        return family.use == PrimitiveUse::always || family.use == use;
      });
    };
    if (!used(PrimitiveUse::far))
      file_.fail(families, "no family is used far from the goal; one needs 'use: far' or 'use: always'");
    if (!used(PrimitiveUse::near) && set_.near_distance > 0.0)
      file_.fail(families,
                 "no family is used near the goal; one needs 'use: near' or 'use: always', or near_distance: 0");
  }

  YamlFile file_;
  const std::vector<Joint>& joints_;
  Names joint_names_;
  PrimitiveSet set_;
  bool degrees_{true};
  double prismatic_step_{0.05};
};

}  // namespace

PrimitiveSet read_primitives(const std::string& path, const std::vector<Joint>& joints) {
  if (joints.empty()) throw InvalidArgument("motion primitives need at least one planned joint, but there is none");
  return PrimitiveReader(path, joints).read();
}

}  // namespace srmp::io
