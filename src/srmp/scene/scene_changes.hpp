#pragma once

#include <set>
#include <string>

#include "srmp/scene/scene.hpp"

namespace srmp {

/// How one scene differs from another, as far as collisions depend on it.
struct SceneChanges {
  std::set<std::string> objects;  ///< that no robot holds: added, removed, replaced or moved
  std::set<std::string> robots;   ///< whose planned joints stand elsewhere
  bool anything_else{};           ///< is different; the two above may be incomplete then
};

/// Are an object and a body, or two objects, the same wherever they stand? Then so are its pairs with other bodies, as
/// long as no setting that names it has changed.
template <class Body>
bool is_same_body(const Body& a, const Object& b) {
  return a.geometry == b.geometry && a.padding == b.padding;
}

SceneChanges changes_between(const Scene& before, const Scene& after);

}  // namespace srmp
