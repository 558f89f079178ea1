#include "srmp/robot/joined_robots.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/robot/mesh_path.hpp"
#include "srmp/robot/urdf.hpp"
#include "srmp/robot/xml_edit.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;
using xml::add_named;
using xml::children;

XMLElement& add_root(XMLDocument& document, const std::string& name) {
  XMLElement& root = *document.NewElement("robot");
  document.InsertEndChild(&root);
  root.SetAttribute("name", name.c_str());
  return root;
}

/// Copies of what one robot's URDF and SRDF say, under joined names.
class Copy {
 public:
  explicit Copy(const RobotToJoin& robot) : robot_(robot) {}

  void urdf_into(XMLElement& root) const {
    XMLDocument document;
    const std::string& text = robot_.model.self_contained_description().urdf_text;
    for (const XMLElement* e = xml::parse_robot(document, text, "URDF").FirstChildElement(); e;
         e = e->NextSiblingElement()) {
      const std::string tag = e->Name();
      if (tag == "link") {
        take_link(*e, root);
      } else if (tag == "joint") {
        take_joint(*e, root);
      }
    }
  }

  void srdf_into(XMLElement& root) const {
    const std::string& text = robot_.model.self_contained_description().srdf_text;
    if (text.empty()) return;
    XMLDocument document;
    for (const XMLElement* e = xml::parse_robot(document, text, "SRDF").FirstChildElement(); e;
         e = e->NextSiblingElement()) {
      const std::string tag = e->Name();
      if (tag != "group" && tag != "group_state" && tag != "end_effector") continue;
      XMLElement& copy = taken(*e, root);
      if (tag != "group_state") rename(copy, "name");
      for (const char* attribute : {"group", "parent_group", "parent_link"}) rename(copy, attribute);
      for (XMLElement* part = copy.FirstChildElement(); part; part = part->NextSiblingElement())
        for (const char* attribute : {"name", "base_link", "tip_link"}) rename(*part, attribute);
    }
  }

 private:
  static XMLElement& taken(const XMLElement& from, XMLElement& root) {
    return *root.InsertEndChild(from.DeepClone(root.GetDocument()))->ToElement();
  }

  void rename(XMLElement& element, const char* attribute) const {
    if (const char* name = element.Attribute(attribute))
      element.SetAttribute(attribute, joined_name(robot_.name, name).c_str());
  }

  void take_link(const XMLElement& from, XMLElement& root) const {
    XMLElement& link = taken(from, root);
    rename(link, "name");
    while (XMLElement* visual = link.FirstChildElement("visual")) link.DeleteChild(visual);
    for (XMLElement* collision : children(link, "collision"))
      for (XMLElement* geometry : children(*collision, "geometry"))
        for (XMLElement* mesh : children(*geometry, "mesh")) make_absolute(*mesh);
  }

  void make_absolute(XMLElement& mesh) const {
    const RobotDescription& files = robot_.model.self_contained_description();
    if (const char* file = mesh.Attribute("filename"))
      mesh.SetAttribute(
          "filename",
          find_mesh(file, files.urdf_directory, files.package_dirs, "robot '" + robot_.name + "': ").c_str());
  }

  void take_joint(const XMLElement& from, XMLElement& root) const {
    XMLElement& joint = taken(from, root);
    rename(joint, "name");
    for (const char* end : {"parent", "child"})
      for (XMLElement* element : children(joint, end)) rename(*element, "link");
    for (XMLElement* element : children(joint, "mimic")) rename(*element, "joint");
  }

  const RobotToJoin& robot_;
};

/// Throws InvalidArgument for two of one kind, such as links, that would have one name.
void require_distinct(XMLElement& root, const char* tag) {
  std::set<std::string> names;
  for (const XMLElement* e : children(root, tag)) {
    const char* name = e->Attribute("name");
    if (name && !names.insert(name).second)
      throw InvalidArgument(std::string("join_robots: two elements <") + tag + "> of the robots would be called '" +
                            name + "'; give one of the robots another name");
  }
}

std::string root_link_of(const RobotModel& model) {
  const Urdf urdf = Urdf::parse(model.self_contained_description().urdf_text);
  return urdf.links[urdf.root].name;
}

std::string joined_urdf(const std::string& name, const std::vector<RobotToJoin>& robots) {
  XMLDocument document;
  XMLElement& root = add_root(document, name);
  const std::string origin = joined_name(name, "origin");
  add_named(root, "link", origin);
  for (const RobotToJoin& robot : robots) {
    Copy(robot).urdf_into(root);
    XMLElement& joint = add_named(root, "joint", joined_name(robot.name, "placed_in_" + name));
    joint.SetAttribute("type", "fixed");
    joint.InsertNewChildElement("parent")->SetAttribute("link", origin.c_str());
    joint.InsertNewChildElement("child")->SetAttribute("link",
                                                       joined_name(robot.name, root_link_of(robot.model)).c_str());
    XMLElement& place = *joint.InsertNewChildElement("origin");
    xml::set_vector(place, "xyz", robot.base.p);
    xml::set_vector(place, "rpy", robot.base.rpy());
  }
  for (const char* tag : {"link", "joint"}) require_distinct(root, tag);
  return xml::print(document);
}

/// The states that every robot has.
std::vector<std::string> common_states(const std::vector<RobotToJoin>& robots) {
  std::vector<std::string> names;
  for (const auto& [state, q] : robots.front().model.group_states())
    if (std::all_of(robots.begin(), robots.end(),
                    [&](const RobotToJoin& robot) { return robot.model.group_states().contains(state); }))
      names.push_back(state);
  return names;
}

void add_states(XMLElement& root, const std::string& group, const std::vector<RobotToJoin>& robots) {
  for (const std::string& name : common_states(robots)) {
    XMLElement& state = add_named(root, "group_state", name);
    state.SetAttribute("group", group.c_str());
    for (const RobotToJoin& robot : robots) {
      const Eigen::VectorXd& q = robot.model.group_states().at(name);
      for (std::size_t j = 0; j < robot.model.dof(); ++j)
        add_named(state, "joint", joined_name(robot.name, robot.model.joint_names()[j]))
            .SetAttribute("value", to_text(q[static_cast<Eigen::Index>(j)]).c_str());
    }
  }
}

void add_allowed(XMLElement& root, const RobotToJoin& robot) {
  const std::vector<std::string>& links = robot.model.link_names();
  for (std::size_t a = 0; a < links.size(); ++a)
    for (std::size_t b = a + 1; b < links.size(); ++b) {
      if (!robot.model.allowed(links[a], links[b])) continue;
      XMLElement& pair = *root.InsertNewChildElement("disable_collisions");
      pair.SetAttribute("link1", joined_name(robot.name, links[a]).c_str());
      pair.SetAttribute("link2", joined_name(robot.name, links[b]).c_str());
    }
}

bool has_group(XMLElement& root, const std::string& name) {
  const auto groups = children(root, "group");
  return std::any_of(groups.begin(), groups.end(), [&](const XMLElement* e) { return e->Attribute("name") == name; });
}

std::string joined_srdf(const std::string& name, const std::vector<RobotToJoin>& robots) {
  XMLDocument document;
  XMLElement& root = add_root(document, name);
  for (const RobotToJoin& robot : robots) Copy(robot).srdf_into(root);
  for (const char* tag : {"group", "end_effector"}) require_distinct(root, tag);
  std::string group_name = name;
  while (has_group(root, group_name)) group_name += "_joints";
  XMLElement& group = add_named(root, "group", group_name);
  for (const RobotToJoin& robot : robots)
    for (const std::string& joint : robot.model.joint_names())
      add_named(group, "joint", joined_name(robot.name, joint));
  add_states(root, group_name, robots);
  for (const RobotToJoin& robot : robots) add_allowed(root, robot);
  return xml::print(document);
}

}  // namespace

std::string joined_name(const std::string& robot, const std::string& name) { return robot + "_" + name; }

RobotDescription join_robots(const std::string& name, const std::vector<RobotToJoin>& robots) {
  RobotDescription joined;
  joined.name = name;
  joined.urdf_text = joined_urdf(name, robots);
  joined.srdf_text = joined_srdf(name, robots);
  for (const RobotToJoin& robot : robots) {
    for (const std::string& joint : robot.model.joint_names())
      joined.joint_names.push_back(joined_name(robot.name, joint));
    const std::vector<Joint>& others = robot.model.other_joints();
    for (std::size_t j = 0; j < others.size(); ++j)
      joined.fixed_joints[joined_name(robot.name, others[j].name)] =
          robot.other_positions[static_cast<Eigen::Index>(j)];
  }
  return joined;
}

}  // namespace srmp
