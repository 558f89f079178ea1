#pragma once

#include <set>
#include <string>

#include "srmp/scene/scene.hpp"

namespace srmp {

/// How one scene differs from another, as far as collisions depend on it.
struct SceneChanges {
  std::set<std::string> objects;  ///< that no robot holds: added, removed, replaced or moved
  std::set<std::string> robots;   ///< whose planned joints stand elsewhere
  bool others{};                  ///< anything else is different
};

SceneChanges changes_between(const Scene& before, const Scene& after);

}  // namespace srmp
