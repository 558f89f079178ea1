#include "srmp/robot/planar_base.hpp"

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/robot/urdf.hpp"
#include "srmp/robot/xml.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

constexpr std::array kCoordinates{"/x", "/y", "/theta"};

void require_bounds(const PlanarBounds& bounds) {
  for (int i = 0; i < 2; ++i) {
    const double lower = bounds.lower[i], upper = bounds.upper[i];
    const std::string what = std::string("planar_bounds: ") + (i == 0 ? "x" : "y") + " is from " + to_text(lower) +
                             " to " + to_text(upper) + " m; ";
    if (!(std::isfinite(lower) && std::isfinite(upper))) throw InvalidArgument(what + "bounds must be finite numbers");
    if (!(lower < upper)) throw InvalidArgument(what + "the lower bound must be below the upper one");
    if (std::max(std::abs(lower), std::abs(upper)) > max_length)
      throw InvalidArgument(what.substr(0, what.size() - 2) + length_rule());
  }
}

std::string xyz_text(const Eigen::Vector3d& v) { return to_text(v.x()) + " " + to_text(v.y()) + " " + to_text(v.z()); }

XMLElement& root_of(XMLDocument& document, const std::string& text, const char* kind) {
  document.Parse(text.c_str(), text.size());
  XMLElement* root = document.Error() ? nullptr : document.FirstChildElement("robot");
  if (!root) throw FileError(std::string("the ") + kind + " text is not XML with a <robot>");
  return *root;
}

std::string printed(const XMLDocument& document) {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

bool has(const XMLElement& element, const char* attribute, const std::string& value) {
  const char* text = element.Attribute(attribute);
  return text && value == text;
}

/// The joint that is expanded: of the URDF, or above its root link.
struct PlanarJoint {
  std::string name, parent, child;
  Eigen::Vector3d normal{0, 0, 1}, xyz{0, 0, 0}, rpy{0, 0, 0};
  double velocity{1.0};  // [m/s]

  bool is_above_root() const { return parent.empty(); }
};

/// Throws InvalidArgument where the URDF has a name that the three joints need.
void require_new_names(const Urdf& urdf, const PlanarJoint& planar) {
  if (planar.is_above_root() && urdf.find_joint(planar.name))
    throw InvalidArgument("planar_bounds: the planar joint above the root link is called '" + planar.name +
                          "', as a joint of the URDF is; rename that one");
  for (const char* coordinate : kCoordinates)
    if (const std::string name = planar.name + coordinate; urdf.find_joint(name))
      throw InvalidArgument("planar_bounds: the URDF has a joint '" + name +
                            "' already, which is what the planar joint '" + planar.name +
                            "' would become; rename one of them");
  for (const char* place : {"/origin", "/at_x", "/at_xy"})
    if (const std::string name = planar.name + place; urdf.find_link(name))
      throw InvalidArgument("planar_bounds: the URDF has a link '" + name + "' already, which the planar joint '" +
                            planar.name + "' needs; rename one of them");
}

PlanarJoint find_planar(const Urdf& urdf, const Srdf* srdf) {
  for (const std::size_t index : urdf.joint_order) {
    const UrdfJoint& joint = urdf.joints[index];
    if (joint.type != UrdfJointType::planar) continue;
    PlanarJoint found{joint.name, urdf.links[joint.parent].name, urdf.links[joint.child].name};
    found.normal = joint.axis, found.xyz = joint.xyz, found.rpy = joint.rpy;
    if (joint.velocity.value_or(0.0) > 0.0) found.velocity = *joint.velocity;
    return found;
  }
  const bool is_planar = srdf && srdf->virtual_joint && srdf->virtual_joint->type == "planar";
  return {is_planar ? srdf->virtual_joint->name : "base", "", urdf.links[urdf.root].name};
}

XMLElement& add_joint(XMLElement& robot, const PlanarJoint& planar, const char* coordinate, const char* type,
                      const std::string& parent, const std::string& child, const Eigen::Vector3d& axis) {
  XMLElement& joint = *robot.InsertNewChildElement("joint");
  joint.SetAttribute("name", (planar.name + coordinate).c_str());
  joint.SetAttribute("type", type);
  joint.InsertNewChildElement("parent")->SetAttribute("link", parent.c_str());
  joint.InsertNewChildElement("child")->SetAttribute("link", child.c_str());
  joint.InsertNewChildElement("axis")->SetAttribute("xyz", xyz_text(axis).c_str());
  return joint;
}

void set_limit(XMLElement& joint, double velocity, const double* lower, const double* upper) {
  XMLElement& limit = *joint.InsertNewChildElement("limit");
  limit.SetAttribute("velocity", to_text(velocity).c_str());
  if (lower) limit.SetAttribute("lower", to_text(*lower).c_str());
  if (upper) limit.SetAttribute("upper", to_text(*upper).c_str());
}

std::string with_three_joints(const std::string& urdf_text, const PlanarJoint& planar, const PlanarBounds& bounds) {
  XMLDocument document;
  XMLElement& robot = root_of(document, urdf_text, "URDF");
  for (auto e = robot.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint"))
    if (!planar.is_above_root() && has(*e, "name", planar.name)) {
      robot.DeleteChild(e);
      break;
    }
  const auto add_link = [&](const std::string& name) {
    robot.InsertNewChildElement("link")->SetAttribute("name", name.c_str());
    return name;
  };
  const std::string parent = planar.is_above_root() ? add_link(planar.name + "/origin") : planar.parent;
  const std::string along_x = add_link(planar.name + "/at_x"), along_y = add_link(planar.name + "/at_xy");
  const Eigen::Matrix3d plane =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), planar.normal).toRotationMatrix();

  XMLElement& x = add_joint(robot, planar, "/x", "prismatic", parent, along_x, plane.col(0));
  XMLElement& origin = *x.InsertNewChildElement("origin");
  origin.SetAttribute("xyz", xyz_text(planar.xyz).c_str());
  origin.SetAttribute("rpy", xyz_text(planar.rpy).c_str());
  set_limit(x, planar.velocity, &bounds.lower.x(), &bounds.upper.x());
  XMLElement& y = add_joint(robot, planar, "/y", "prismatic", along_x, along_y, plane.col(1));
  set_limit(y, planar.velocity, &bounds.lower.y(), &bounds.upper.y());
  XMLElement& theta = add_joint(robot, planar, "/theta", "continuous", along_y, planar.child, planar.normal);
  set_limit(theta, 1.0, nullptr, nullptr);
  return printed(document);
}

/// Puts the three joints in place of the planar one below `parent`; where it is not there, adds them if `always`.
void expand_in(XMLElement& parent, const std::string& planar, bool always, bool with_values) {
  XMLElement* old = parent.FirstChildElement("joint");
  while (old && !has(*old, "name", planar)) old = old->NextSiblingElement("joint");
  if (!old && !always) return;
  std::array<double, 3> values{};
  if (old && with_values) {
    std::istringstream text(old->Attribute("value") ? old->Attribute("value") : "");
    for (double& value : values) text >> value;
  }
  if (old) parent.DeleteChild(old);
  for (std::size_t i = 0; i < kCoordinates.size(); ++i) {
    XMLElement& joint = *parent.InsertNewChildElement("joint");
    joint.SetAttribute("name", (planar + kCoordinates[i]).c_str());
    if (with_values) joint.SetAttribute("value", to_text(values[i]).c_str());
  }
}

/// `group` is planned.
std::string srdf_with_three_joints(const std::string& srdf_text, const Srdf& srdf, const std::string& planar,
                                   const std::string& group) {
  const auto is_of_gripper = [&](const XMLElement& state) {
    return std::any_of(srdf.end_effectors.begin(), srdf.end_effectors.end(),
                       [&](const SrdfEndEffector& each) { return has(state, "group", each.group); });
  };
  XMLDocument document;
  XMLElement& robot = root_of(document, srdf_text, "SRDF");
  for (auto e = robot.FirstChildElement("group"); e; e = e->NextSiblingElement("group"))
    expand_in(*e, planar, !group.empty() && has(*e, "name", group), false);
  for (auto e = robot.FirstChildElement("group_state"); e; e = e->NextSiblingElement("group_state"))
    expand_in(*e, planar, !is_of_gripper(*e), true);
  for (auto e = robot.FirstChildElement("virtual_joint"); e;) {
    XMLElement* next = e->NextSiblingElement("virtual_joint");
    if (has(*e, "name", planar)) robot.DeleteChild(e);
    e = next;
  }
  return printed(document);
}

}  // namespace

void expand_planar_joint(RobotDescription& description, const Urdf& urdf, const Srdf* srdf) {
  if (!description.planar_bounds) return;
  const PlanarBounds bounds = *description.planar_bounds;
  require_bounds(bounds);
  description.planar_bounds.reset();
  const PlanarJoint planar = find_planar(urdf, srdf);
  require_new_names(urdf, planar);
  description.urdf_text = with_three_joints(description.urdf_text, planar, bounds);
  const bool chosen = !description.joint_names.empty() || !description.end_effector.empty();
  const bool only_group = description.group.empty() && !chosen && srdf && srdf->groups.size() == 1;
  const std::string group = only_group ? srdf->groups[0].name : description.group;
  if (srdf) description.srdf_text = srdf_with_three_joints(description.srdf_text, *srdf, planar.name, group);

  std::vector<std::string>& names = description.joint_names;
  const auto is_named = [&](const char* coordinate) {
    return std::find(names.begin(), names.end(), planar.name + coordinate) != names.end();
  };
  if (names.empty() || std::any_of(kCoordinates.begin(), kCoordinates.end(), is_named)) return;
  std::erase(names, planar.name);
  for (std::size_t i = 0; i < kCoordinates.size(); ++i)
    names.insert(names.begin() + static_cast<std::ptrdiff_t>(i), planar.name + kCoordinates[i]);
}

}  // namespace srmp
