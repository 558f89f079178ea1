#pragma once

#include <string>

namespace srmp {

/// Throws FileError unless assimp 6.0 will come to an end with the Collada file: its scene is a finite tree of nodes of
/// reasonable size, where a file of 1 kB may stand for 10^8 nodes, or for endlessly many, since nodes may instance
/// others; and what it takes for numbers, unchecked, are numbers.
void require_sound_collada(const std::string& path);

}  // namespace srmp
