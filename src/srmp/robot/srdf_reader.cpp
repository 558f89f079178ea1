#include <tinyxml2.h>

#include <algorithm>
#include <optional>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/robot/srdf.hpp"
#include "srmp/robot/xml.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLElement;
using Names = std::vector<std::string>;

/// A file that names at least this many different unknown links was written for another variant of the robot.
constexpr std::size_t kVariantLinks = 3;

/// Reads one SRDF document; errors give the line.
class SrdfReader {
 public:
  SrdfReader(xml::Document& document, const Urdf& urdf)
      : xml_(document), urdf_(urdf), link_names_(urdf.link_names()), joint_names_(urdf.joint_names()) {
    srdf_.label = document.label();
  }

  Srdf read() {
    const XMLElement& robot = xml_.root();
    xml_.check_spelling(robot,
                        Names{"group", "group_state", "end_effector", "virtual_joint", "passive_joint",
                              "disable_collisions", "enable_collisions", "disable_default_collisions"},
                        Names{"name", "version"},
                        Names{"link_sphere_approximation", "joint_property", "kinematics", "chain", "link", "joint"});
    if (const auto name = xml_.attribute(robot, "name"); name && *name != urdf_.name)
      srdf_.warnings.push_back(xml_.label() + " is of robot '" + *name + "', the URDF of robot '" + urdf_.name + "'");
    read_virtual_joints(robot);
    for (auto e = robot.FirstChildElement("group"); e; e = e->NextSiblingElement("group")) read_group(*e);
    check_subgroups();
    for (auto e = robot.FirstChildElement("group_state"); e; e = e->NextSiblingElement("group_state")) read_state(*e);
    for (auto e = robot.FirstChildElement("end_effector"); e; e = e->NextSiblingElement("end_effector"))
      read_end_effector(*e);
    for (auto e = robot.FirstChildElement("passive_joint"); e; e = e->NextSiblingElement("passive_joint"))
      find_joint(*e, "name");
    read_disabled(robot);
    read_other_rules(robot);
    for (const std::string& warning : xml_.warnings()) srdf_.warnings.push_back(warning);
    return std::move(srdf_);
  }

 private:
  static std::string unknown(const XMLElement& element, const char* kind, const std::string& name, const Names& known) {
    std::string text("<");
    text.append(element.Name()).append("> names the unknown ").append(kind).append(" '").append(name).append("'");
    return text + did_you_mean(name, known);
  }

  static bool contains(const Names& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }

  static std::string missing(const XMLElement& element, const char* attribute) {
    std::string text("<");
    return text.append(element.Name()).append("> has no attribute '").append(attribute).append("'");
  }

  /// The name in an attribute; nullopt, with a warning, when it is missing or not known.
  std::optional<std::string> find_name(const XMLElement& element, const char* attribute, const char* kind,
                                       const Names& known) {
    const auto name = xml_.attribute(element, attribute);
    if (name && contains(known, *name)) return name;
    xml_.warn(element, name ? unknown(element, kind, *name, known) : missing(element, attribute));
    return std::nullopt;
  }
  std::optional<std::string> find_link(const XMLElement& element, const char* attribute) {
    return find_name(element, attribute, "link", link_names_);
  }
  std::optional<std::string> find_joint(const XMLElement& element, const char* attribute) {
    return find_name(element, attribute, "joint", joint_names_);
  }
  std::optional<std::string> find_group(const XMLElement& element, const char* attribute) {
    return find_name(element, attribute, "group", srdf_.group_names());
  }

  std::string require_link(const XMLElement& element, const char* attribute) {
    const std::string link = xml_.required(element, attribute);
    if (!urdf_.find_link(link)) xml_.fail(element, unknown(element, "link", link, link_names_));
    return link;
  }

  // --- groups

  void read_virtual_joints(const XMLElement& robot) {
    for (auto e = robot.FirstChildElement("virtual_joint"); e; e = e->NextSiblingElement("virtual_joint")) {
      xml_.check_spelling(*e, Names{}, Names{"name", "type", "parent_frame", "child_link"});
      const auto child = find_link(*e, "child_link");
      const std::string name = xml_.required(*e, "name");
      joint_names_.push_back(name);
      if (child == urdf_.links[urdf_.root].name && !srdf_.virtual_joint)
        srdf_.virtual_joint = VirtualJoint{name, xml_.attribute(*e, "type").value_or("fixed"),
                                           xml_.attribute(*e, "parent_frame").value_or("")};
    }
  }

  /// Says once why a group cannot be used.
  void refuse_group(const XMLElement& at, SrdfGroup& group, const std::string& why) {
    if (!group.fault.empty()) return;
    xml_.warn(at, "group '" + group.name + "' cannot be used: " + why);
    group.fault = xml_.label() + ":" + std::to_string(at.GetLineNum()) + ": " + why;
  }

  /// The name in a part of a group, which gets a fault when there is no such link or joint.
  std::string member(const XMLElement& element, const char* attribute, const char* kind, const Names& known,
                     SrdfGroup& group) {
    const std::string name = xml_.required(element, attribute);
    if (!contains(known, name)) refuse_group(element, group, unknown(element, kind, name, known));
    return name;
  }

  void read_group(const XMLElement& element) {
    SrdfGroup group;
    group.name = xml_.required(element, "name");
    if (srdf_.find_group(group.name)) xml_.fail(element, "group '" + group.name + "' is defined twice");
    xml_.check_spelling(element, Names{"chain", "joint", "link", "group", "passive_joint"}, Names{"name"});
    for (auto e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string tag = e->Name();
      if (tag == "chain") read_chain(*e, group);
      if (tag == "joint") group.joints.push_back(member(*e, "name", "joint", joint_names_, group));
      if (tag == "link") group.links.push_back(member(*e, "name", "link", link_names_, group));
      if (tag == "passive_joint") find_joint(*e, "name");
      if (tag == "group") {
        group.subgroups.push_back(xml_.required(*e, "name"));
        subgroup_uses_.push_back({e, group.name});
      }
    }
    srdf_.groups.push_back(std::move(group));
  }

  void read_chain(const XMLElement& element, SrdfGroup& group) {
    xml_.check_spelling(element, Names{}, Names{"base_link", "tip_link"});
    const std::string base = member(element, "base_link", "link", link_names_, group);
    const std::string last = member(element, "tip_link", "link", link_names_, group);
    if (group.fault.empty()) group.chains.emplace_back(base, last);
  }

  SrdfGroup& group_named(const std::string& name) {
    return *std::find_if(srdf_.groups.begin(), srdf_.groups.end(), [&](const SrdfGroup& g) { return g.name == name; });
  }

  /// A group has a fault when one of its subgroups is missing or has one. Fails when a group contains itself.
  void check_subgroups() {
    for (const auto& [element, group] : subgroup_uses_) {
      const Names known = srdf_.group_names();
      Names open{xml_.required(*element, "name")};
      std::set<std::string> seen;
      while (!open.empty()) {
        const std::string name = open.back();
        open.pop_back();
        if (name == group) xml_.fail(*element, "group '" + group + "' contains itself");
        const SrdfGroup* subgroup = srdf_.find_group(name);
        if (!subgroup)
          refuse_group(*element, group_named(group), unknown(*element, "group", name, known));
        else if (!subgroup->fault.empty())
          refuse_group(*element, group_named(group), "its subgroup '" + name + "' cannot be used");
        if (!subgroup || !seen.insert(name).second) continue;
        open.insert(open.end(), subgroup->subgroups.begin(), subgroup->subgroups.end());
      }
    }
  }

  // --- states and end effectors

  void read_state(const XMLElement& element) {
    xml_.check_spelling(element, Names{"joint"}, Names{"name", "group"});
    SrdfState state;
    state.name = xml_.required(element, "name");
    state.group = find_group(element, "group").value_or("");
    for (auto e = element.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
      xml_.check_spelling(*e, Names{}, Names{"name", "value"});
      const auto values = xml_.numbers(*e, "value", xml_.required(*e, "value"));
      const auto joint = find_joint(*e, "name");
      if (!joint || !moves_by_one_value(*joint)) continue;
      if (values.size() != 1)
        xml_.fail(*e, "joint '" + *joint + "' takes one value, not " + std::to_string(values.size()));
      state.positions[*joint] = values[0];
    }
    srdf_.states.push_back(std::move(state));
  }

  bool moves_by_one_value(const std::string& joint) const {
    const auto index = urdf_.find_joint(joint);
    return index && urdf_.joints[*index].scalar();
  }

  void read_end_effector(const XMLElement& element) {
    xml_.check_spelling(element, Names{}, Names{"name", "parent_link", "group", "parent_group"});
    SrdfEndEffector effector;
    effector.name = xml_.required(element, "name");
    const auto parent_link = find_link(element, "parent_link");
    if (!parent_link) return;
    effector.parent_link = *parent_link;
    effector.group = find_group(element, "group").value_or("");
    if (element.Attribute("parent_group")) effector.parent_group = find_group(element, "parent_group").value_or("");
    srdf_.end_effectors.push_back(std::move(effector));
  }

  // --- collision rules

  /// The names, or the first of many.
  static std::string some_of(Names names) {
    constexpr std::size_t max_count = 6;
    if (names.size() <= max_count) return quoted_list(names);
    const std::size_t left_out = names.size() - max_count;
    names.resize(max_count);
    return quoted_list(names) + " (and " + std::to_string(left_out) + " more)";
  }

  void read_disabled(const XMLElement& robot) {
    std::set<std::string> unknown_links;
    std::size_t ignored = 0;
    const XMLElement* first = nullptr;
    for (auto e = robot.FirstChildElement("disable_collisions"); e; e = e->NextSiblingElement("disable_collisions")) {
      xml_.check_spelling(*e, Names{}, Names{"link1", "link2", "reason"});
      const std::string a = xml_.required(*e, "link1"), b = xml_.required(*e, "link2");
      std::set<std::string> missing;
      for (const std::string& link : {a, b})
        if (!urdf_.find_link(link)) missing.insert(link);
      if (missing.empty()) {
        srdf_.disabled.emplace_back(a, b);
        continue;
      }
      ++ignored;
      if (!first) first = e;
      unknown_links.merge(missing);
    }
    if (unknown_links.size() >= kVariantLinks)
      srdf_.warnings.push_back(xml_.label() + ": " + std::to_string(ignored) + " <disable_collisions> ignored; links " +
                               some_of(Names(unknown_links.begin(), unknown_links.end())) + " are not in the URDF");
    else if (first)
      for (const std::string& link : unknown_links) xml_.warn(*first, unknown(*first, "link", link, link_names_));
  }

  void read_other_rules(const XMLElement& robot) {
    for (auto e = robot.FirstChildElement("enable_collisions"); e; e = e->NextSiblingElement("enable_collisions")) {
      xml_.check_spelling(*e, Names{}, Names{"link1", "link2", "reason"});
      srdf_.enabled.emplace_back(require_link(*e, "link1"), require_link(*e, "link2"));
    }
    for (auto e = robot.FirstChildElement("disable_default_collisions"); e;
         e = e->NextSiblingElement("disable_default_collisions"))
      if (const auto link = find_link(*e, "link")) srdf_.disabled_by_default.push_back(*link);
  }

  xml::Document& xml_;
  const Urdf& urdf_;
  Srdf srdf_;
  Names link_names_, joint_names_;  // joints of the URDF and virtual joints of the SRDF
  std::vector<std::pair<const XMLElement*, std::string>> subgroup_uses_;
};

}  // namespace

Srdf Srdf::parse(const std::string& text, const Urdf& urdf, const std::string& label, bool strict) {
  auto document = xml::Document::parse(text, label, "robot", strict);
  return SrdfReader(document, urdf).read();
}

}  // namespace srmp
