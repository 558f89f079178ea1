#pragma once

#include <string>

namespace srmp {

/// Throws FileError unless the file's header is whole and the file is long enough for the elements that it counts.
/// assimp 6.0 makes room and loops for as many as are named, however short the file is, and waits for the end of a
/// header.
void require_sound_ply_header(const std::string& path);
void require_sound_off_header(const std::string& path);

/// Throws FileError unless the file begins like glTF: assimp would read it as whatever else it looks like.
void require_gltf(const std::string& path);

}  // namespace srmp
