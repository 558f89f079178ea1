#include <tinyxml2.h>

#include <algorithm>
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
  SrdfReader(const xml::Document& document, const Urdf& urdf)
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
      require_joint(*e, "name");
    read_collisions(robot);
    return std::move(srdf_);
  }

 private:
  [[noreturn]] void refuse_unknown(const XMLElement& element, const char* kind, const std::string& name,
                                   const Names& known) {
    std::string text("<");
    text.append(element.Name()).append("> names the unknown ").append(kind).append(" '").append(name).append("'");
    xml_.fail(element, text + did_you_mean(name, known));
  }

  std::string require_link(const XMLElement& element, const char* attribute) {
    const std::string link = xml_.required(element, attribute);
    if (!urdf_.find_link(link)) refuse_unknown(element, "link", link, link_names_);
    return link;
  }

  std::string require_joint(const XMLElement& element, const char* attribute) {
    const std::string joint = xml_.required(element, attribute);
    if (std::find(joint_names_.begin(), joint_names_.end(), joint) == joint_names_.end())
      refuse_unknown(element, "joint", joint, joint_names_);
    return joint;
  }

  std::string require_group(const XMLElement& element, const char* attribute) {
    const std::string group = xml_.required(element, attribute);
    if (!srdf_.find_group(group)) refuse_unknown(element, "group", group, srdf_.group_names());
    return group;
  }

  void read_virtual_joints(const XMLElement& robot) {
    for (auto e = robot.FirstChildElement("virtual_joint"); e; e = e->NextSiblingElement("virtual_joint")) {
      xml_.check_spelling(*e, Names{}, Names{"name", "type", "parent_frame", "child_link"});
      const std::string child = require_link(*e, "child_link"), name = xml_.required(*e, "name");
      virtual_joints_.insert(name);
      joint_names_.push_back(name);
      if (child == urdf_.links[urdf_.root].name && !srdf_.virtual_joint)
        srdf_.virtual_joint = VirtualJoint{name, xml_.attribute(*e, "type").value_or("fixed"),
                                           xml_.attribute(*e, "parent_frame").value_or("")};
    }
  }

  void read_group(const XMLElement& element) {
    SrdfGroup group;
    group.name = xml_.required(element, "name");
    if (srdf_.find_group(group.name)) xml_.fail(element, "group '" + group.name + "' is defined twice");
    xml_.check_spelling(element, Names{"chain", "joint", "link", "group", "passive_joint"}, Names{"name"});
    for (auto e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string tag = e->Name();
      if (tag == "chain") group.chains.push_back(read_chain(*e));
      if (tag == "joint") group.joints.push_back(require_joint(*e, "name"));
      if (tag == "link") group.links.push_back(require_link(*e, "name"));
      if (tag == "passive_joint") require_joint(*e, "name");
      if (tag == "group") {
        group.subgroups.push_back(xml_.required(*e, "name"));
        subgroup_uses_.push_back({e, group.name});
      }
    }
    srdf_.groups.push_back(std::move(group));
  }

  std::pair<std::string, std::string> read_chain(const XMLElement& element) {
    xml_.check_spelling(element, Names{}, Names{"base_link", "tip_link"});
    const std::string base = require_link(element, "base_link"), last = require_link(element, "tip_link");
    std::size_t link = *urdf_.find_link(last);
    while (urdf_.links[link].name != base) {
      if (!urdf_.links[link].parent_joint)
        xml_.fail(element, "link '" + base + "' is not an ancestor of link '" + last + "', so there is no such chain");
      link = urdf_.joints[*urdf_.links[link].parent_joint].parent;
    }
    return {base, last};
  }

  /// Fails unless every subgroup exists and no group contains itself.
  void check_subgroups() {
    for (const auto& [element, group] : subgroup_uses_) {
      Names open{require_group(*element, "name")};
      std::set<std::string> seen;
      while (!open.empty()) {
        const std::string name = open.back();
        open.pop_back();
        if (name == group) xml_.fail(*element, "group '" + group + "' contains itself");
        const SrdfGroup* subgroup = srdf_.find_group(name);
        if (!subgroup || !seen.insert(name).second) continue;
        open.insert(open.end(), subgroup->subgroups.begin(), subgroup->subgroups.end());
      }
    }
  }

  void read_state(const XMLElement& element) {
    xml_.check_spelling(element, Names{"joint"}, Names{"name", "group"});
    SrdfState state;
    state.name = xml_.required(element, "name");
    state.group = require_group(element, "group");
    for (auto e = element.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
      xml_.check_spelling(*e, Names{}, Names{"name", "value"});
      const std::string joint = require_joint(*e, "name");
      const auto values = xml_.numbers(*e, "value", xml_.required(*e, "value"));
      if (virtual_joints_.contains(joint)) continue;
      if (values.size() != 1)
        xml_.fail(*e, "joint '" + joint + "' takes one value, not " + std::to_string(values.size()));
      state.positions[joint] = values[0];
    }
    srdf_.states.push_back(std::move(state));
  }

  void read_end_effector(const XMLElement& element) {
    xml_.check_spelling(element, Names{}, Names{"name", "parent_link", "group", "parent_group"});
    SrdfEndEffector effector;
    effector.name = xml_.required(element, "name");
    effector.parent_link = require_link(element, "parent_link");
    effector.group = require_group(element, "group");
    if (element.Attribute("parent_group")) effector.parent_group = require_group(element, "parent_group");
    srdf_.end_effectors.push_back(std::move(effector));
  }

  // --- collision rules

  void read_collisions(const XMLElement& robot) {
    std::set<std::string> unknown;
    std::size_t ignored = 0;
    for (const char* attribute : {"link1", "link2"})
      for (auto e = robot.FirstChildElement("disable_collisions"); e; e = e->NextSiblingElement("disable_collisions"))
        if (const auto link = xml_.attribute(*e, attribute); link && !urdf_.find_link(*link)) unknown.insert(*link);
    const bool variant = unknown.size() >= kVariantLinks;

    for (auto e = robot.FirstChildElement("disable_collisions"); e; e = e->NextSiblingElement("disable_collisions")) {
      xml_.check_spelling(*e, Names{}, Names{"link1", "link2", "reason"});
      if (variant && (unknown.contains(xml_.required(*e, "link1")) || unknown.contains(xml_.required(*e, "link2"))))
        ++ignored;
      else
        srdf_.disabled.emplace_back(require_link(*e, "link1"), require_link(*e, "link2"));
    }
    for (auto e = robot.FirstChildElement("enable_collisions"); e; e = e->NextSiblingElement("enable_collisions")) {
      xml_.check_spelling(*e, Names{}, Names{"link1", "link2", "reason"});
      srdf_.enabled.emplace_back(require_link(*e, "link1"), require_link(*e, "link2"));
    }
    for (auto e = robot.FirstChildElement("disable_default_collisions"); e;
         e = e->NextSiblingElement("disable_default_collisions"))
      srdf_.disabled_by_default.push_back(require_link(*e, "link"));
    if (ignored > 0)
      srdf_.warnings.push_back(xml_.label() + ": " + std::to_string(ignored) + " <disable_collisions> ignored; links " +
                               quoted_list(Names(unknown.begin(), unknown.end())) + " are not in the URDF");
  }

  const xml::Document& xml_;
  const Urdf& urdf_;
  Srdf srdf_;
  Names link_names_, joint_names_;  // joints of the URDF and virtual joints of the SRDF
  std::set<std::string> virtual_joints_;
  std::vector<std::pair<const XMLElement*, std::string>> subgroup_uses_;
};

}  // namespace

Srdf Srdf::parse(const std::string& text, const Urdf& urdf, const std::string& label) {
  const auto document = xml::Document::parse(text, label, "robot");
  return SrdfReader(document, urdf).read();
}

}  // namespace srmp
