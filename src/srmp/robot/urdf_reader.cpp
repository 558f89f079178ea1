#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <locale>
#include <numbers>
#include <sstream>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/core/spelling.hpp"
#include "srmp/robot/urdf.hpp"
#include "srmp/robot/xml.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLElement;
using Names = std::vector<std::string>;

constexpr double kTurn = 2 * std::numbers::pi;

/// Could a number that is too large for an angle in radians be one in degrees?
bool may_be_degrees(double angle, double max_radians) {
  return std::abs(angle) > max_radians + 1e-3 && std::abs(angle) <= 2 * 360.0;
}

/// Reads one URDF document; errors give the line.
class UrdfReader {
 public:
  explicit UrdfReader(xml::Document& document) : xml_(document) { urdf_.label = document.label(); }

  Urdf read() {
    const XMLElement& robot = xml_.root();
    xml_.check_spelling(robot, Names{"link", "joint", "material"}, Names{"name", "version"},
                        Names{"gazebo", "transmission", "sensor", "ros2_control", "loop_joint", "plugin", "group",
                              "self_collision_checking", "kinematics", "mujoco", "include", "constant", "frame"});
    urdf_.name = xml_.attribute(robot, "name").value_or("");
    if (urdf_.name.empty()) {
      urdf_.name = "robot";
      xml_.warn(robot, "<robot> has no attribute 'name'; it is called 'robot'");
    }
    for (auto e = robot.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) read_link(*e);
    if (urdf_.links.empty()) xml_.fail(robot, "robot '" + urdf_.name + "' has no <link>");
    link_names_ = urdf_.link_names();
    for (auto e = robot.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) read_joint(*e);
    resolve_mimics();
    order_tree();
    urdf_.warnings = xml_.warnings();
    return std::move(urdf_);
  }

 private:
  // --- links

  void read_link(const XMLElement& element) {
    UrdfLink link;
    link.name = xml_.required(element, "name");
    link.line = element.GetLineNum();
    if (const auto first = urdf_.find_link(link.name))
      xml_.fail(element,
                "link '" + link.name + "' is already defined in line " + std::to_string(urdf_.links[*first].line));
    xml_.check_spelling(element, Names{"inertial", "visual", "collision"}, Names{"name", "type"},
                        Names{"contact", "sphere_velocity", "sensor", "origin", "self_collision_checking", "gazebo",
                              "collision_checking", "capsule", "audio", "light", "projector", "material"});
    for (auto e = element.FirstChildElement("collision"); e; e = e->NextSiblingElement("collision"))
      link.collisions.push_back(read_collision(*e, link.name));
    link.inertia = read_inertia(element);
    urdf_.links.push_back(std::move(link));
  }

  /// nullopt where there is none that can be used: not all numbers, or not above 0.
  static std::optional<UrdfInertia> read_inertia(const XMLElement& link) {
    const XMLElement* inertial = link.FirstChildElement("inertial");
    const XMLElement* mass = inertial ? inertial->FirstChildElement("mass") : nullptr;
    UrdfInertia result;
    if (!mass || mass->QueryDoubleAttribute("value", &result.mass) != tinyxml2::XML_SUCCESS) return std::nullopt;
    if (const XMLElement* inertia = inertial->FirstChildElement("inertia")) {
      const auto entry = [&](const char* name, int i, int j) {
        inertia->QueryDoubleAttribute(name, &result.inertia(i, j));
        result.inertia(j, i) = result.inertia(i, j);
      };
      for (int i = 0; i < 3; ++i) {
        constexpr const char* names[3][3] = {{"ixx", "ixy", "ixz"}, {"", "iyy", "iyz"}, {"", "", "izz"}};
        for (int j = i; j < 3; ++j) entry(names[i][j], i, j);
      }
    }
    if (const XMLElement* origin = inertial->FirstChildElement("origin")) {
      const Eigen::Vector3d xyz = numbers(*origin, "xyz"), rpy = numbers(*origin, "rpy");
      result.origin = Eigen::Translation3d(xyz) * Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                      Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX());
    }
    const bool usable = result.mass > 0.0 && std::isfinite(result.mass) && result.inertia.allFinite() &&
                        result.origin.matrix().allFinite();
    return usable ? std::optional(result) : std::nullopt;
  }

  /// Three numbers of an attribute; NaN where they cannot be read, 0 where there is none.
  static Eigen::Vector3d numbers(const XMLElement& element, const char* name) {
    const char* text = element.Attribute(name);
    if (!text) return Eigen::Vector3d::Zero();
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    Eigen::Vector3d result;
    return in >> result[0] >> result[1] >> result[2] ? result : Eigen::Vector3d::Constant(std::nan(""));
  }

  UrdfGeometry read_collision(const XMLElement& element, const std::string& link) {
    xml_.check_spelling(element, Names{"origin", "geometry"}, Names{"name", "group"},
                        Names{"material", "verbose", "contact_coefficients", "collision_checking", "tag", "friction",
                              "surface", "contact"});
    const XMLElement* geometry = element.FirstChildElement("geometry");
    if (!geometry) xml_.fail(element, "a <collision> of link '" + link + "' has no <geometry>");
    xml_.check_spelling(*geometry, Names{"box", "sphere", "cylinder", "capsule", "mesh"}, Names{});
    const XMLElement* shape = geometry->FirstChildElement();
    if (!shape) xml_.fail(*geometry, "the <geometry> of a <collision> of link '" + link + "' is empty");
    UrdfGeometry result = read_shape(*shape);
    read_origin(element, &result.origin, nullptr, nullptr);
    return result;
  }

  UrdfGeometry read_shape(const XMLElement& shape) {
    using Kind = UrdfGeometry::Kind;
    const std::string tag = shape.Name();
    UrdfGeometry g;
    g.line = shape.GetLineNum();
    if (tag == "box") {
      g.kind = Kind::box;
      xml_.check_spelling(shape, Names{}, Names{"size"});
      xml_.required(shape, "size");
      g.size = *xml_.vector3(shape, "size");
      for (const double edge : g.size) require_length(shape, "size", edge);
    } else if (tag == "sphere") {
      g.kind = Kind::sphere;
      xml_.check_spelling(shape, Names{}, Names{"radius"});
      g.radius = length_of(shape, "radius");
    } else if (tag == "cylinder" || tag == "capsule") {
      g.kind = tag == "cylinder" ? Kind::cylinder : Kind::capsule;
      xml_.check_spelling(shape, Names{}, Names{"radius", "length"});
      g.radius = length_of(shape, "radius");
      g.length = length_of(shape, "length");
    } else if (tag == "mesh") {
      g.kind = Kind::mesh;
      xml_.check_spelling(shape, Names{}, Names{"filename", "scale"});
      g.filename = xml_.required(shape, "filename");
      g.scale = xml_.vector3(shape, "scale").value_or(Eigen::Vector3d::Ones());
      if (g.scale.cwiseAbs().minCoeff() == 0.0) xml_.fail(shape, "no component of the scale of a <mesh> may be 0");
    } else {
      xml_.fail(shape, "unknown geometry <" + tag + ">; known are box, sphere, cylinder, capsule and mesh");
    }
    return g;
  }

  double length_of(const XMLElement& element, const char* name) {
    const double value = xml_.required_number(element, name);
    require_length(element, name, value);
    return value;
  }

  void require_length(const XMLElement& element, const char* name, double value) {
    if (value <= 0.0)
      xml_.fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is " + to_text(value) +
                             "; it must be above 0");
    require_not_absurd(element, name, value);
  }

  void require_not_absurd(const XMLElement& element, const char* name, double length) {
    if (std::abs(length) > max_length)
      xml_.fail(element, "attribute '" + std::string(name) + "' of <" + element.Name() + "> is " + to_text(length) +
                             " m" + length_rule());
  }

  void read_origin(const XMLElement& owner, Eigen::Isometry3d* transform, Eigen::Vector3d* xyz, Eigen::Vector3d* rpy) {
    const XMLElement* element = owner.FirstChildElement("origin");
    if (!element) return;
    xml_.check_spelling(*element, Names{}, Names{"xyz", "rpy"});
    const Eigen::Vector3d p = xml_.vector3(*element, "xyz").value_or(Eigen::Vector3d::Zero());
    const Eigen::Vector3d r = xml_.vector3(*element, "rpy").value_or(Eigen::Vector3d::Zero());
    for (const double x : p) require_not_absurd(*element, "xyz", x);
    if (transform) *transform = Pose::from_rpy(p, r).isometry();
    for (const double angle : r)
      if (may_be_degrees(angle, kTurn))
        xml_.note(*element, "rpy has an angle of " + to_text(angle) + " rad, more than a turn; is it in degrees?");
    if (xyz) *xyz = p;
    if (rpy) *rpy = r;
  }

  // --- joints

  void read_joint(const XMLElement& element) {
    UrdfJoint joint;
    joint.name = xml_.required(element, "name");
    joint.line = element.GetLineNum();
    if (const auto first = urdf_.find_joint(joint.name))
      xml_.fail(element,
                "joint '" + joint.name + "' is already defined in line " + std::to_string(urdf_.joints[*first].line));
    xml_.check_spelling(element, Names{"origin", "parent", "child", "axis", "limit", "mimic"}, Names{"name", "type"},
                        Names{"dynamics", "safety_controller", "calibration", "gazebo", "hardwareInterface", "damping",
                              "friction", "joint_properties", "implicitSpringDamper", "actuator", "sensor", "plugin"});
    joint.type = read_type(element, joint.name);
    joint.parent = read_end(element, joint.name, "parent");
    joint.child = read_end(element, joint.name, "child");
    read_origin(element, nullptr, &joint.xyz, &joint.rpy);
    if (joint.scalar() || joint.type == UrdfJointType::planar) read_axis(element, joint);
    if (joint.scalar()) read_limit(element, joint);
    if (joint.type == UrdfJointType::planar || joint.type == UrdfJointType::floating)
      read_multi_dof_limit(element, joint);
    mimics_.push_back(joint.scalar() ? element.FirstChildElement("mimic") : nullptr);
    connect(element, std::move(joint));
  }

  UrdfJointType read_type(const XMLElement& element, const std::string& joint) {
    static constexpr std::array types{
        std::pair{"fixed", UrdfJointType::fixed},           std::pair{"revolute", UrdfJointType::revolute},
        std::pair{"continuous", UrdfJointType::continuous}, std::pair{"prismatic", UrdfJointType::prismatic},
        std::pair{"floating", UrdfJointType::floating},     std::pair{"planar", UrdfJointType::planar}};
    const std::string text = xml_.required(element, "type");
    Names known;
    for (const auto& [name, type] : types) {
      if (text == name) return type;
      known.emplace_back(name);
    }
    const std::string hint = did_you_mean(text, known);
    xml_.fail(element, "joint '" + joint + "' has the unknown type '" + text + "'" +
                           (hint.empty() ? "; known are " + quoted_list(known) : hint));
  }

  std::size_t read_end(const XMLElement& element, const std::string& joint, const char* end) {
    const XMLElement* e = element.FirstChildElement(end);
    if (!e) xml_.fail(element, "joint '" + joint + "' has no <" + end + ">");
    xml_.check_spelling(*e, Names{}, Names{"link"});
    const std::string link = xml_.required(*e, "link");
    const auto index = urdf_.find_link(link);
    if (!index)
      xml_.fail(*e,
                "joint '" + joint + "': there is no " + end + " link '" + link + "'" + did_you_mean(link, link_names_));
    return *index;
  }

  void read_axis(const XMLElement& element, UrdfJoint& joint) {
    const XMLElement* e = element.FirstChildElement("axis");
    if (!e) return;
    xml_.check_spelling(*e, Names{}, Names{"xyz"});
    joint.axis = xml_.vector3(*e, "xyz").value_or(joint.axis);
    if (joint.axis.norm() < 1e-9) xml_.fail(*e, "the axis of joint '" + joint.name + "' is zero");
    if (std::abs(joint.axis.norm() - 1.0) > 1e-12) joint.axis.normalize();
  }

  void read_limit(const XMLElement& element, UrdfJoint& joint) {
    const bool continuous = joint.type == UrdfJointType::continuous;
    joint.lower = -std::numeric_limits<double>::infinity();
    joint.upper = std::numeric_limits<double>::infinity();
    const XMLElement* e = element.FirstChildElement("limit");
    if (!e) {
      if (continuous) return;
      xml_.fail(element, "joint '" + joint.name + "' is " +
                             (joint.type == UrdfJointType::revolute ? "revolute" : "prismatic") +
                             " and has no <limit>");
    }
    xml_.check_spelling(
        *e, Names{},
        Names{"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk", "stiffness", "damping"});
    joint.velocity = xml_.number(*e, "velocity");
    if (double effort{}; e->QueryDoubleAttribute("effort", &effort) == tinyxml2::XML_SUCCESS && effort > 0.0)
      joint.effort = effort;
    if (joint.velocity && *joint.velocity < 0.0)
      xml_.fail(*e, "joint '" + joint.name + "': the velocity limit " + to_text(*joint.velocity) + " is negative");
    const double lower = xml_.number(*e, "lower").value_or(0.0), upper = xml_.number(*e, "upper").value_or(0.0);
    if (continuous) return;
    if (lower > upper)
      xml_.fail(*e, "joint '" + joint.name + "': the lower limit " + to_text(lower) + " is above the upper limit " +
                        to_text(upper));
    if (const double most = std::max(std::abs(lower), std::abs(upper));
        joint.type == UrdfJointType::revolute && may_be_degrees(most, 2 * kTurn))
      xml_.note(*e, "joint '" + joint.name + "' has the limits " + to_text(lower) + " to " + to_text(upper) +
                        " rad, more than two turns; are they in degrees?");
    joint.lower = lower;
    joint.upper = upper;
    if (joint.type != UrdfJointType::prismatic || std::max(std::abs(lower), std::abs(upper)) <= max_length) return;
    joint.lower = std::clamp(lower, -max_length, max_length);
    joint.upper = std::clamp(upper, -max_length, max_length);
    xml_.note(*e, "joint '" + joint.name + "' has the limits " + to_text(lower) + " to " + to_text(upper) +
                      " m; it is planned within " + to_text(max_length) + " m of 0");
  }

  /// The positions of planar and floating joints have no limits in a URDF.
  void read_multi_dof_limit(const XMLElement& element, UrdfJoint& joint) {
    if (const XMLElement* e = element.FirstChildElement("limit")) joint.velocity = xml_.number(*e, "velocity");
  }

  void connect(const XMLElement& element, UrdfJoint joint) {
    UrdfLink& child = urdf_.links[joint.child];
    if (child.parent_joint)
      xml_.fail(element, "link '" + child.name + "' is the child of both joint '" +
                             urdf_.joints[*child.parent_joint].name + "' and joint '" + joint.name +
                             "'; a robot is a tree");
    child.parent_joint = urdf_.joints.size();
    urdf_.links[joint.parent].child_joints.push_back(urdf_.joints.size());
    urdf_.joints.push_back(std::move(joint));
  }

  // --- the tree

  void resolve_mimics() {
    const Names joint_names = urdf_.joint_names();
    for (std::size_t i = 0; i < mimics_.size(); ++i) {
      if (!mimics_[i]) continue;
      const XMLElement& e = *mimics_[i];
      xml_.check_spelling(e, Names{}, Names{"joint", "multiplier", "offset"});
      const std::string source = xml_.required(e, "joint");
      const auto index = urdf_.find_joint(source);
      if (!index) {
        const std::string text =
            "joint '" + urdf_.joints[i].name + "' mimics joint '" + source + "', which does not exist";
        const std::string* nearest = nearest_name(source, joint_names);
        if (nearest && is_typo(source, *nearest)) xml_.fail(e, text + did_you_mean(source, joint_names));
        xml_.warn(e, text + "; it is taken for a joint of its own");
        mimics_[i] = nullptr;
        continue;
      }
      if (!urdf_.joints[*index].scalar())
        xml_.fail(e, "joint '" + urdf_.joints[i].name + "' mimics joint '" + source + "', which does not move");
      urdf_.joints[i].mimic =
          UrdfMimic{*index, xml_.number(e, "multiplier").value_or(1.0), xml_.number(e, "offset").value_or(0.0)};
    }
    for (std::size_t i = 0; i < mimics_.size(); ++i)
      if (mimics_[i]) multiply_out(i);
  }

  /// Replaces a source that is a mimic joint itself by the source of that one.
  void multiply_out(std::size_t i) {
    UrdfMimic& mimic = *urdf_.joints[i].mimic;
    for (std::size_t steps = 0; urdf_.joints[mimic.source].mimic; ++steps) {
      if (mimic.source == i || steps > urdf_.joints.size())
        xml_.fail(*mimics_[i], "joint '" + urdf_.joints[i].name + "' mimics itself");
      const UrdfMimic next = *urdf_.joints[mimic.source].mimic;
      mimic.offset += mimic.multiplier * next.offset;
      mimic.multiplier *= next.multiplier;
      mimic.source = next.source;
    }
  }

  void order_tree() {
    Names roots;
    for (std::size_t i = 0; i < urdf_.links.size(); ++i) {
      if (urdf_.links[i].parent_joint) continue;
      roots.push_back(urdf_.links[i].name);
      urdf_.root = i;
    }
    if (roots.empty())
      xml_.fail(xml_.root(), "the joints of robot '" + urdf_.name + "' form a loop: no link is the root");
    if (roots.size() > 1)
      xml_.fail(xml_.root(),
                "links " + quoted_list(roots) + " have no parent joint; a robot is one tree with one root");
    std::vector<std::size_t> stack(1, urdf_.root);
    while (!stack.empty()) {
      const UrdfLink& link = urdf_.links[stack.back()];
      stack.pop_back();
      if (link.parent_joint) urdf_.joint_order.push_back(*link.parent_joint);
      for (auto it = link.child_joints.rbegin(); it != link.child_joints.rend(); ++it)
        stack.push_back(urdf_.joints[*it].child);
    }
    if (urdf_.joint_order.size() != urdf_.joints.size())
      xml_.fail(xml_.root(),
                "some joints of robot '" + urdf_.name + "' form a loop apart from the root '" + roots[0] + "'");
  }

  xml::Document& xml_;
  Urdf urdf_;
  Names link_names_;
  std::vector<const XMLElement*> mimics_;  // by joint; nullptr: none
};

}  // namespace

Urdf Urdf::read_file(const std::string& path) {
  auto document = xml::Document::read_file(path, "URDF", "robot");
  return UrdfReader(document).read();
}

Urdf Urdf::parse(const std::string& text, const std::string& label, bool strict) {
  auto document = xml::Document::parse(text, label, "robot", strict);
  return UrdfReader(document).read();
}

}  // namespace srmp
