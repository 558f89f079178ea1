#pragma once

#include <tinyxml2.h>

#include <Eigen/Core>
#include <string>
#include <vector>

// Changing the texts of URDFs and SRDFs; reading them is xml.hpp.

namespace srmp::xml {

/// The <robot> of a text that `document` then holds. Throws FileError, which names the `kind` of text, for others.
tinyxml2::XMLElement& parse_robot(tinyxml2::XMLDocument& document, const std::string& text, const std::string& kind);

std::string print(const tinyxml2::XMLDocument& document);

/// The children with this tag.
std::vector<tinyxml2::XMLElement*> children(tinyxml2::XMLElement& parent, const char* tag);

/// A new last child with this tag and attribute `name`.
tinyxml2::XMLElement& add_named(tinyxml2::XMLElement& parent, const char* tag, const std::string& name);

/// Sets an attribute to three numbers.
void set_vector(tinyxml2::XMLElement& element, const char* attribute, const Eigen::Vector3d& v);

}  // namespace srmp::xml
