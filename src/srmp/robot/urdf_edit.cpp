#include "srmp/robot/urdf_edit.hpp"

#include <tinyxml2.h>

#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/robot/xml_edit.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLElement;
using xml::children;
using xml::print;

std::string attribute(const XMLElement* element, const char* name) {
  const char* value = element ? element->Attribute(name) : nullptr;
  return value ? value : "";
}

void set_limits(XMLElement& joint, const JointLimitEdit& edit) {
  XMLElement* limit = joint.FirstChildElement("limit");
  if (!limit) limit = joint.InsertNewChildElement("limit");
  // Text that reads back as the same number.
  if (edit.lower) limit->SetAttribute("lower", to_text(*edit.lower).c_str());
  if (edit.upper) limit->SetAttribute("upper", to_text(*edit.upper).c_str());
  if (edit.velocity) limit->SetAttribute("velocity", to_text(*edit.velocity).c_str());
  if (edit.lower && edit.upper && attribute(&joint, "type") == "continuous") joint.SetAttribute("type", "revolute");
}

}  // namespace

std::string with_limits(const std::string& urdf_text, const std::map<std::string, JointLimitEdit>& limits) {
  if (limits.empty()) return urdf_text;
  tinyxml2::XMLDocument document;
  for (XMLElement* joint : children(xml::parse_robot(document, urdf_text, "URDF"), "joint")) {
    const auto edit = limits.find(attribute(joint, "name"));
    if (edit != limits.end()) set_limits(*joint, edit->second);
  }
  return print(document);
}

std::string without_links(const std::string& urdf_text, const std::set<std::string>& links,
                          const std::set<std::string>& without_geometry) {
  tinyxml2::XMLDocument document;
  XMLElement& root = xml::parse_robot(document, urdf_text, "URDF");
  for (XMLElement* joint : children(root, "joint"))
    if (links.contains(attribute(joint->FirstChildElement("child"), "link"))) root.DeleteChild(joint);
  for (XMLElement* link : children(root, "link")) {
    const std::string name = attribute(link, "name");
    if (links.contains(name))
      root.DeleteChild(link);
    else if (without_geometry.contains(name))
      for (XMLElement* collision : children(*link, "collision")) link->DeleteChild(collision);
  }
  return print(document);
}

}  // namespace srmp
