#include "srmp/robot/multi_dof_joint.hpp"

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <locale>
#include <numbers>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/robot/joint_names.hpp"
#include "srmp/robot/srdf.hpp"
#include "srmp/robot/urdf.hpp"
#include "srmp/robot/xml_edit.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

/// One of the joints that a planar or floating joint becomes.
struct Coordinate {
  const char* joint;      ///< its name, behind that of the joint
  std::string_view type;  ///< as in a URDF
  int axis;               ///< of the joint's frame: x, y or z
  const char* link;       ///< which it moves, behind the joint's name; "": the joint's child
};

constexpr std::array kPlanarCoordinates{Coordinate{"/x", "prismatic", 0, "/at_x"},
                                        Coordinate{"/y", "prismatic", 1, "/at_xy"},
                                        Coordinate{"/theta", "continuous", 2, ""}};
constexpr std::array kFloatingCoordinates{
    Coordinate{"/x", "prismatic", 0, "/at_x"},        Coordinate{"/y", "prismatic", 1, "/at_xy"},
    Coordinate{"/z", "prismatic", 2, "/at_xyz"},      Coordinate{"/yaw", "continuous", 2, "/at_yaw"},
    Coordinate{"/pitch", "revolute", 1, "/at_pitch"}, Coordinate{"/roll", "continuous", 0, ""}};

/// A type of joint with several degrees of freedom.
struct MultiDofType {
  const char* name;    ///< in SRDFs
  const char* option;  ///< that asks for it to be planned
  UrdfJointType type;
  std::span<const Coordinate> coordinates;
  std::size_t values;  ///< in a state of an SRDF
  const char* value_names;
};

constexpr MultiDofType kPlanar{"planar", "planar_bounds", UrdfJointType::planar, kPlanarCoordinates, 3, "x, y, theta"};
constexpr MultiDofType kFloating{"floating", "floating_bounds",        UrdfJointType::floating, kFloatingCoordinates,
                                 7,          "x, y, z, qx, qy, qz, qw"};

/// Where the joint may be [m]; z of a planar joint counts for nothing.
struct MultiDofBounds {
  Eigen::Vector3d lower{0, 0, 0}, upper{0, 0, 0};
};

void require_bounds(const MultiDofType& type, const MultiDofBounds& bounds) {
  for (const Coordinate& coordinate : type.coordinates) {
    if (coordinate.type != "prismatic") continue;
    const double lower = bounds.lower[coordinate.axis], upper = bounds.upper[coordinate.axis];
    const std::string what = std::string(type.option) + ": " + (coordinate.joint + 1) + " is from " + to_text(lower) +
                             " to " + to_text(upper) + " m";
    if (!(std::isfinite(lower) && std::isfinite(upper)))
      throw InvalidArgument(what + "; bounds must be finite numbers");
    if (!(lower < upper)) throw InvalidArgument(what + "; the lower bound must be below the upper one");
    if (std::max(std::abs(lower), std::abs(upper)) > max_length) throw InvalidArgument(what + length_rule());
  }
}

/// x, y, z [m], yaw, pitch, roll [rad], those of Pose::rpy.
std::array<double, 6> floating_positions(const Pose& transform) {
  const Eigen::Vector3d &p = transform.p, turns = transform.rpy();
  return {p.x(), p.y(), p.z(), turns.z(), turns.y(), turns.x()};
}

bool has(const XMLElement& element, const char* attribute, const std::string& value) {
  const char* text = element.Attribute(attribute);
  return text && value == text;
}

/// The joint that is expanded: of the URDF, or above its root link.
struct MultiDofJoint {
  const MultiDofType& type;
  std::string name, parent, child;
  Eigen::Vector3d normal{0, 0, 1}, xyz{0, 0, 0}, rpy{0, 0, 0};
  double velocity{1.0};  // [m/s]

  bool is_above_root() const { return parent.empty(); }
};

/// Throws InvalidArgument where the URDF has a name that the new joints need.
void require_new_names(const Urdf& urdf, const MultiDofJoint& joint) {
  const std::string option = std::string(joint.type.option) + ": ", type = joint.type.name;
  if (joint.is_above_root() && urdf.find_joint(joint.name))
    throw InvalidArgument(option + "the " + type + " joint above the root link is called '" + joint.name +
                          "', as a joint of the URDF is; rename that one");
  const auto require_new_link = [&](const std::string& link) {
    if (urdf.find_link(link))
      throw InvalidArgument(option + "the URDF has a link '" + link + "' already, which the " + type + " joint '" +
                            joint.name + "' needs; rename one of them");
  };
  require_new_link(joint.name + "/origin");
  for (const Coordinate& coordinate : joint.type.coordinates) {
    if (const std::string name = joint.name + coordinate.joint; urdf.find_joint(name))
      throw InvalidArgument(option + "the URDF has a joint '" + name + "' already, which is what the " + type +
                            " joint '" + joint.name + "' would become; rename one of them");
    if (*coordinate.link) require_new_link(joint.name + coordinate.link);
  }
}

MultiDofJoint find_multi_dof_joint(const MultiDofType& type, const Urdf& urdf, const Srdf* srdf) {
  for (const std::size_t index : urdf.joint_order) {
    const UrdfJoint& joint = urdf.joints[index];
    if (joint.type != type.type) continue;
    MultiDofJoint found{type, joint.name, urdf.links[joint.parent].name, urdf.links[joint.child].name};
    if (joint.type == UrdfJointType::planar) found.normal = joint.axis;
    found.xyz = joint.xyz, found.rpy = joint.rpy;
    if (joint.velocity.value_or(0.0) > 0.0) found.velocity = *joint.velocity;
    return found;
  }
  const bool is_virtual = srdf && srdf->virtual_joint && srdf->virtual_joint->type == type.name;
  return {type, is_virtual ? srdf->virtual_joint->name : "base", "", urdf.links[urdf.root].name};
}

XMLElement& add_joint(XMLElement& robot, const MultiDofJoint& joint, const Coordinate& coordinate,
                      const std::string& parent, const std::string& child, const Eigen::Vector3d& axis) {
  XMLElement& added = xml::add_named(robot, "joint", joint.name + coordinate.joint);
  added.SetAttribute("type", coordinate.type.data());
  added.InsertNewChildElement("parent")->SetAttribute("link", parent.c_str());
  added.InsertNewChildElement("child")->SetAttribute("link", child.c_str());
  xml::set_vector(*added.InsertNewChildElement("axis"), "xyz", axis);
  return added;
}

void add_limit(XMLElement& joint, double velocity, double lower, double upper) {
  XMLElement& limit = *joint.InsertNewChildElement("limit");
  limit.SetAttribute("velocity", to_text(velocity).c_str());
  if (std::isfinite(lower)) limit.SetAttribute("lower", to_text(lower).c_str());
  if (std::isfinite(upper)) limit.SetAttribute("upper", to_text(upper).c_str());
}

std::string expanded_urdf(const std::string& urdf_text, const MultiDofJoint& joint, const MultiDofBounds& bounds) {
  XMLDocument document;
  XMLElement& robot = xml::parse_robot(document, urdf_text, "URDF");
  for (auto e = robot.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint"))
    if (!joint.is_above_root() && has(*e, "name", joint.name)) {
      robot.DeleteChild(e);
      break;
    }
  const auto add_link = [&](const std::string& name) {
    xml::add_named(robot, "link", name);
    return name;
  };
  Eigen::Matrix3d axes =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), joint.normal).normalized().toRotationMatrix();
  axes.col(2) = joint.normal;
  std::string parent = joint.is_above_root() ? add_link(joint.name + "/origin") : joint.parent;
  for (const Coordinate& coordinate : joint.type.coordinates) {
    const std::string child = *coordinate.link ? add_link(joint.name + coordinate.link) : joint.child;
    XMLElement& added = add_joint(robot, joint, coordinate, parent, child, axes.col(coordinate.axis));
    if (&coordinate == &joint.type.coordinates.front()) {
      XMLElement& origin = *added.InsertNewChildElement("origin");
      xml::set_vector(origin, "xyz", joint.xyz);
      xml::set_vector(origin, "rpy", joint.rpy);
    }
    if (coordinate.type == "prismatic")
      add_limit(added, joint.velocity, bounds.lower[coordinate.axis], bounds.upper[coordinate.axis]);
    else if (coordinate.type == "revolute")
      add_limit(added, 1.0, -std::numbers::pi / 2, std::numbers::pi / 2);
    else
      add_limit(added, 1.0, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
    parent = child;
  }
  return xml::print(document);
}

/// The positions of the new joints in a state of the SRDF.
std::vector<double> positions_in_state(const MultiDofJoint& joint, const XMLElement& in_state) {
  std::istringstream text(in_state.Attribute("value") ? in_state.Attribute("value") : "");
  text.imbue(std::locale::classic());
  const std::vector<double> v{std::istream_iterator<double>(text), {}};
  const auto fail = [&](const std::string& what) {
    throw FileError("a state of the SRDF gives " + what + " of joint '" + joint.name + "', which is " +
                    joint.type.name + "; it takes " + joint.type.value_names);
  };
  if (v.size() != joint.type.values) fail(std::to_string(v.size()) + " values");
  if (joint.type.type == UrdfJointType::planar) return v;
  if (Eigen::Map<const Eigen::Vector4d>(&v[3]).isZero()) fail("a quaternion of zeros");
  const auto positions = floating_positions(Pose::from_list(v));
  return {positions.begin(), positions.end()};
}

/// Puts the new joints in place of the old one below `parent`; where it is not there, adds them if `always`.
void expand_in(XMLElement& parent, const MultiDofJoint& joint, bool always, bool with_values) {
  XMLElement* old = parent.FirstChildElement("joint");
  while (old && !has(*old, "name", joint.name)) old = old->NextSiblingElement("joint");
  if (!old && !always) return;
  std::vector<double> values(joint.type.coordinates.size());
  if (old && with_values) values = positions_in_state(joint, *old);
  if (old) parent.DeleteChild(old);
  for (std::size_t i = 0; i < values.size(); ++i) {
    XMLElement& added = xml::add_named(parent, "joint", joint.name + joint.type.coordinates[i].joint);
    if (with_values) added.SetAttribute("value", to_text(values[i]).c_str());
  }
}

/// `group` is planned.
std::string expanded_srdf(const std::string& srdf_text, const Srdf& srdf, const MultiDofJoint& joint,
                          const std::string& group) {
  const auto is_of_gripper = [&](const XMLElement& state) {
    return std::any_of(srdf.end_effectors.begin(), srdf.end_effectors.end(),
                       [&](const SrdfEndEffector& each) { return has(state, "group", each.group); });
  };
  XMLDocument document;
  XMLElement& robot = xml::parse_robot(document, srdf_text, "SRDF");
  for (auto e = robot.FirstChildElement("group"); e; e = e->NextSiblingElement("group"))
    expand_in(*e, joint, !group.empty() && has(*e, "name", group), false);
  for (auto e = robot.FirstChildElement("group_state"); e; e = e->NextSiblingElement("group_state"))
    expand_in(*e, joint, !is_of_gripper(*e), true);
  for (auto e = robot.FirstChildElement("virtual_joint"); e;) {
    XMLElement* next = e->NextSiblingElement("virtual_joint");
    if (has(*e, "name", joint.name)) robot.DeleteChild(e);
    e = next;
  }
  return xml::print(document);
}

/// Puts the new joints in front of the planned joints that are given by name, unless some of them are among these.
void expand_names(std::vector<std::string>& names, const MultiDofJoint& joint) {
  std::vector<std::string> added;
  for (const Coordinate& coordinate : joint.type.coordinates) added.push_back(joint.name + coordinate.joint);
  const auto is_added = [&](const std::string& name) {
    return std::find(added.begin(), added.end(), name) != added.end();
  };
  if (names.empty() || std::any_of(names.begin(), names.end(), is_added)) return;
  std::erase(names, joint.name);
  names.insert(names.begin(), added.begin(), added.end());
}

/// The columns of the joints that `joint` was replaced by, if it was of this type; otherwise none.
std::vector<Eigen::Index> columns_of(const RobotModel& robot, const std::string& joint, const MultiDofType& type) {
  std::vector<Eigen::Index> columns;
  for (const Coordinate& coordinate : type.coordinates) {
    const Joint* planned = find_joint(robot.joints(), joint + coordinate.joint);
    if (!planned) return {};
    columns.push_back(planned - robot.joints().data());
  }
  return columns;
}

/// x, y [m] and theta [rad] of a transform. The axes are those of the robot's joints, since the URDF's are gone.
std::array<double, 3> planar_positions(const RobotModel& robot, const std::string& joint,
                                       const std::vector<Eigen::Index>& columns, const Pose& transform) {
  constexpr double rounding = 1e-4;  // [m, rad]: files hold rounded numbers
  const auto placed_at = [&](std::size_t coordinate, double value) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot.joints().size()));
    q[columns[coordinate]] = value;
    return robot.compute_fk(q, joint + "/at_xy");
  };
  const Pose origin = placed_at(0, 0.0);
  const Eigen::Vector3d along_x = origin.q.conjugate() * (placed_at(0, 1.0).p - origin.p);
  const Eigen::Vector3d along_y = origin.q.conjugate() * (placed_at(1, 1.0).p - origin.p);
  const Eigen::Vector3d normal = along_x.cross(along_y), turn = transform.q.vec();
  if (std::abs(normal.dot(transform.p)) > rounding || normal.cross(turn).norm() > rounding)
    throw InvalidArgument("joint '" + joint +
                          "' is planar, and its transform leaves the plane; it may move in the plane and turn about "
                          "its normal only");
  return {along_x.dot(transform.p), along_y.dot(transform.p),
          std::remainder(2.0 * std::atan2(normal.dot(turn), transform.q.w()), 2.0 * std::numbers::pi)};
}

}  // namespace

void expand_multi_dof_joint(RobotDescription& description, const Urdf& urdf, const Srdf* srdf) {
  const auto planar = std::exchange(description.planar_bounds, std::nullopt);
  const auto floating = std::exchange(description.floating_bounds, std::nullopt);
  if (!planar && !floating) return;
  if (planar && floating)
    throw InvalidArgument(
        "planar_bounds and floating_bounds are both given; a robot drives or flies: give one of them");
  const MultiDofType& type = planar ? kPlanar : kFloating;
  MultiDofBounds bounds;
  if (planar) bounds.lower.head<2>() = planar->lower, bounds.upper.head<2>() = planar->upper;
  if (floating) bounds.lower = floating->lower, bounds.upper = floating->upper;
  require_bounds(type, bounds);
  const MultiDofJoint joint = find_multi_dof_joint(type, urdf, srdf);
  require_new_names(urdf, joint);
  description.urdf_text = expanded_urdf(description.urdf_text, joint, bounds);
  const bool chosen = !description.joint_names.empty() || !description.end_effector.empty();
  const bool only_group = description.group.empty() && !chosen && srdf && srdf->groups.size() == 1;
  const std::string group = only_group ? srdf->groups[0].name : description.group;
  if (srdf) description.srdf_text = expanded_srdf(description.srdf_text, *srdf, joint, group);
  expand_names(description.joint_names, joint);
}

std::map<std::string, double> multi_dof_positions(const RobotModel& robot, const std::string& joint,
                                                  const Pose& transform) {
  std::map<std::string, double> positions;
  const auto name = [&](const MultiDofType& type, const auto& values) {
    for (std::size_t i = 0; i < values.size(); ++i) positions[joint + type.coordinates[i].joint] = values[i];
  };
  if (const auto columns = columns_of(robot, joint, kPlanar); !columns.empty())
    name(kPlanar, planar_positions(robot, joint, columns, transform));
  else if (!columns_of(robot, joint, kFloating).empty())
    name(kFloating, floating_positions(transform));
  return positions;
}

}  // namespace srmp
