#include "srmp/robot/urdf.hpp"

#include <algorithm>
#include <limits>

#include "srmp/core/error.hpp"
#include "srmp/core/pose.hpp"

namespace srmp {

namespace {

template <class Item>
std::optional<std::size_t> find_named(const std::vector<Item>& items, const std::string& name) {
  const auto it = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return it == items.end() ? std::nullopt : std::optional<std::size_t>(it - items.begin());
}

template <class Item>
std::vector<std::string> names_of(const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  return names;
}

const char* type_name(UrdfJointType type) {
  switch (type) {
    case UrdfJointType::revolute: return "revolute";
    case UrdfJointType::continuous: return "continuous";
    case UrdfJointType::prismatic: return "prismatic";
    case UrdfJointType::floating:
    case UrdfJointType::planar:  // held at their origin
    case UrdfJointType::fixed: break;
  }
  return "fixed";
}

std::string text_of(const Eigen::Vector3d& v) { return to_text(v.x()) + " " + to_text(v.y()) + " " + to_text(v.z()); }

std::string escaped(const std::string& name) {
  std::string result;
  for (const char c : name) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

}  // namespace

std::optional<std::size_t> Urdf::find_link(const std::string& link) const { return find_named(links, link); }
std::optional<std::size_t> Urdf::find_joint(const std::string& joint) const { return find_named(joints, joint); }
std::vector<std::string> Urdf::link_names() const { return names_of(links); }
std::vector<std::string> Urdf::joint_names() const { return names_of(joints); }

std::vector<std::size_t> Urdf::chain_to(std::size_t link) const {
  std::vector<std::size_t> chain;
  for (auto joint = links[link].parent_joint; joint; joint = links[joints[*joint].parent].parent_joint)
    chain.push_back(*joint);
  std::reverse(chain.begin(), chain.end());
  return chain;
}

std::vector<std::size_t> Urdf::leaves() const {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].child_joints.empty()) result.push_back(i);
  return result;
}

std::string Urdf::kinematics_text() const {
  std::string text = "<robot name=\"" + escaped(name) + "\">\n";
  for (const UrdfLink& link : links) text += "<link name=\"" + escaped(link.name) + "\"/>\n";
  for (const UrdfJoint& joint : joints) {
    text += "<joint name=\"" + escaped(joint.name) + "\" type=\"" + type_name(joint.type) + "\">";
    text += "<origin xyz=\"" + text_of(joint.xyz) + "\" rpy=\"" + text_of(joint.rpy) + "\"/>";
    text += "<parent link=\"" + escaped(links[joint.parent].name) + "\"/>";
    text += "<child link=\"" + escaped(links[joint.child].name) + "\"/>";
    if (joint.scalar()) {
      text += "<axis xyz=\"" + text_of(joint.axis) + "\"/>";
      const bool bounded = joint.type != UrdfJointType::continuous;
      text += "<limit effort=\"0\" velocity=\"" + to_text(joint.velocity.value_or(0.0)) + "\" lower=\"" +
              to_text(bounded ? joint.lower : 0.0) + "\" upper=\"" + to_text(bounded ? joint.upper : 0.0) + "\"/>";
    }
    text += "</joint>\n";
  }
  return text + "</robot>\n";
}

}  // namespace srmp
