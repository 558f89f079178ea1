#pragma once

#include <string>
#include <vector>

#include "srmp/scene/scene.hpp"

namespace srmp::io {

/// Writes the whole scene atomically (JSON, docs/files.md): robots with the texts of their URDF and SRDF,
/// objects with their vertices and points. Numbers read back bit for bit. Throws FileError when it cannot be written.
void save_scene(const Scene& scene, const std::string& path);

/// The scene of a scene file or of a problem file. Only the meshes of robots are separate files: they are looked for
/// where they were, and in `package_dirs`. Throws FileError, with file and line, for anything missing, misspelt, of the
/// wrong type or refused by the scene, and for a file of another format or of a newer version.
Scene load_scene(const std::string& path, const std::vector<std::string>& package_dirs = {});

}  // namespace srmp::io
