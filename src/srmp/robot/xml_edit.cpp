#include "srmp/robot/xml_edit.hpp"

#include "srmp/core/error.hpp"

namespace srmp::xml {

using tinyxml2::XMLElement;

XMLElement& parse_robot(tinyxml2::XMLDocument& document, const std::string& text, const std::string& kind) {
  document.Parse(text.c_str(), text.size());
  XMLElement* root = document.Error() ? nullptr : document.FirstChildElement("robot");
  if (!root) throw FileError("the " + kind + " text is not XML with a <robot>");
  return *root;
}

std::string print(const tinyxml2::XMLDocument& document) {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

std::vector<XMLElement*> children(XMLElement& parent, const char* tag) {
  std::vector<XMLElement*> found;
  for (XMLElement* e = parent.FirstChildElement(tag); e; e = e->NextSiblingElement(tag)) found.push_back(e);
  return found;
}

XMLElement& add_named(XMLElement& parent, const char* tag, const std::string& name) {
  XMLElement& element = *parent.InsertNewChildElement(tag);
  element.SetAttribute("name", name.c_str());
  return element;
}

void set_vector(XMLElement& element, const char* attribute, const Eigen::Vector3d& v) {
  element.SetAttribute(attribute, (to_text(v.x()) + " " + to_text(v.y()) + " " + to_text(v.z())).c_str());
}

}  // namespace srmp::xml
