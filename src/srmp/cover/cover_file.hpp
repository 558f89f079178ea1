#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "srmp/cover/geometry_cover.hpp"

namespace srmp {

/// The covers of one file, such as those of all geometries of a robot.
using CoverSet = std::vector<GeometryCover>;

/// The directory that keeps covers between runs: $SRMP_CACHE_DIR/covers, else $XDG_CACHE_HOME/srmp/covers, else
/// ~/.cache/srmp/covers. Empty (no files are kept) when SRMP_CACHE_DIR is set but empty, or none of them is set.
std::filesystem::path default_cover_directory();

/// The covers that the directory keeps under the key, bit for bit as written; nullopt when the file is missing,
/// damaged, truncated or of another version.
std::optional<CoverSet> read_covers(const std::filesystem::path& directory, const Sha256::Digest& key);

/// Writes the covers as write_cached does. False when that is impossible.
bool write_covers(const std::filesystem::path& directory, const Sha256::Digest& key, const CoverSet& covers);

/// A hash that begins with the versions of the file format, of the algorithm and of the compiler. `what` distinguishes
/// kinds of keys.
Sha256 cover_key(std::string_view what);
/// Adds the levels to the hash.
void add_levels(Sha256& hash, const CoverLevels& levels);

}  // namespace srmp
