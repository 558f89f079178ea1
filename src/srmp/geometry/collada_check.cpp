#include "srmp/geometry/collada_check.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

using tinyxml2::XMLElement;

constexpr std::size_t max_nodes = 100'000;  // of the expanded scene
constexpr int max_depth = 300;              // nodes within nodes, instances included

const char* attribute_or_empty(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value ? value : "";
}

/// Counts what assimp makes of the nodes of a document. Instances are resolved as assimp does: by the id of a visual
/// scene or of a node at the top of a library, otherwise by the name or id of a node in a visual scene.
class NodeCounter {
 public:
  NodeCounter(const std::string& path, const XMLElement& root) : path_(path) {
    for (auto library = root.FirstChildElement(); library; library = library->NextSiblingElement()) {
      const std::string_view tag = library->Name();
      const char* entry = tag == "library_nodes" ? "node" : tag == "library_visual_scenes" ? "visual_scene" : nullptr;
      if (!entry) continue;
      for (auto e = library->FirstChildElement(entry); e; e = e->NextSiblingElement(entry)) {
        library_[attribute_or_empty(*e, "id")] = e;
        roots_.push_back(e);
        if (tag == "library_visual_scenes") list_names(*e);
      }
    }
  }

  void require_finite() {
    for (const XMLElement* root : roots_) count(*root, 1);
  }

 private:
  void list_names(const XMLElement& element) {
    for (const char* key : {"name", "id"}) named_.emplace(attribute_or_empty(element, key), &element);
    for (auto e = element.FirstChildElement("node"); e; e = e->NextSiblingElement("node")) list_names(*e);
  }

  const XMLElement* instanced_by(const XMLElement& instance) const {
    const std::string url = attribute_or_empty(instance, "url");
    if (!url.starts_with('#')) return nullptr;
    if (const auto it = library_.find(url.substr(1)); it != library_.end()) return it->second;
    const auto it = named_.find(url.substr(1));
    return it == named_.end() ? nullptr : it->second;
  }

  /// The number of nodes in the expanded node, itself included.
  std::size_t count(const XMLElement& node, int depth) {
    if (depth > max_depth)
      throw FileError("mesh file '" + path_ + "': its nodes contain themselves, or are more than " +
                      std::to_string(max_depth) + " deep (line " + std::to_string(node.GetLineNum()) + ")");
    Size& size = sizes_[&node];
    if (size.nodes > 0 && depth + size.height <= max_depth) return size.nodes;
    std::size_t nodes = 1;
    int height = 0;
    for (auto e = node.FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string_view tag = e->Name();
      const XMLElement* child = tag == "node" ? e : tag == "instance_node" ? instanced_by(*e) : nullptr;
      if (!child) continue;
      nodes += count(*child, depth + 1);
      height = std::max(height, sizes_[child].height + 1);
      if (nodes > max_nodes)
        throw FileError("mesh file '" + path_ + "': its scene has more than " + std::to_string(max_nodes) +
                        " nodes when instances are expanded (line " + std::to_string(node.GetLineNum()) + ")");
    }
    size = {nodes, height};
    return nodes;
  }

  struct Size {
    std::size_t nodes{};
    int height{};
  };
  const std::string& path_;
  std::vector<const XMLElement*> roots_;
  std::map<std::string, const XMLElement*> library_, named_;
  std::map<const XMLElement*, Size> sizes_;
};

bool is_number_list(std::string_view text) { return text.find_first_not_of("0123456789+- \t\r\n") == text.npos; }

/// Lists of indices hold numbers, of inputs that were named before, and numbers that sizes are computed from do not
/// overflow.
void require_numbers(const XMLElement& element, const std::string& path) {
  constexpr std::size_t max_digits = 9;
  const auto refuse = [&](const std::string& what) {
    throw FileError("mesh file '" + path + "': " + what + " of <" + element.Name() + "> (line " +
                    std::to_string(element.GetLineNum()) + ")");
  };
  const std::string_view tag = element.Name();
  if (tag == "p" || tag == "v" || tag == "vcount" || tag == "h")
    for (auto child = element.FirstChild(); child; child = child->NextSibling())
      if (!child->ToText() || !is_number_list(child->Value())) refuse("something that is no number is in the list");
  if (tag == "p" && !element.PreviousSiblingElement("input")) refuse("no <input> stands before the indices");
  for (const char* name : {"count", "offset", "stride"}) {
    const std::string_view value = attribute_or_empty(element, name);
    if (value.size() > max_digits || value.find_first_not_of("0123456789") != value.npos)
      refuse(std::string("'").append(value) + "' is no whole number below a billion, attribute '" + name + "'");
  }
  for (auto child = element.FirstChildElement(); child; child = child->NextSiblingElement())
    require_numbers(*child, path);
}

}  // namespace

void require_sound_collada(const std::string& path) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(path.c_str()) != tinyxml2::XML_SUCCESS || !document.RootElement())
    throw FileError("mesh file '" + path +
                    "' is not valid XML: " + (document.Error() ? document.ErrorStr() : "it holds no element"));
  require_numbers(*document.RootElement(), path);
  NodeCounter(path, *document.RootElement()).require_finite();
}

}  // namespace srmp
