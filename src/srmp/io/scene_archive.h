#pragma once

// Internal: scenes as maps in files.

#include "srmp/io/json_archive.h"
#include "srmp/scene/scene.hpp"

namespace srmp::io {

/// A scene with "robots", "objects" and "allowed_collisions".
struct SceneText {
  const Scene& scene;
};
void describe(JsonWriter& writer, const SceneText& text);
Scene read_scene(JsonReader reader, const std::vector<std::string>& package_dirs);

}  // namespace srmp::io
