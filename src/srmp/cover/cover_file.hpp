#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "srmp/cover/geometry_cover.hpp"

namespace srmp {

using CoverSet = std::vector<GeometryCover>;

/// Where covers are kept between runs: $SRMP_CACHE_DIR/covers, else $XDG_CACHE_HOME/srmp/covers, else
/// ~/.cache/srmp/covers. Empty (keep none) when SRMP_CACHE_DIR is set but empty, or nothing names a directory.
std::filesystem::path default_cover_directory();

/// What the directory holds under the key, bit for bit as written. Nothing when the file is missing, damaged, cut short
/// or of another version.
std::optional<CoverSet> read_covers(const std::filesystem::path& directory, const Sha256::Digest& key);

/// Writes to a temporary file and renames it, so that readers never see half a file. False when that was impossible.
bool write_covers(const std::filesystem::path& directory, const Sha256::Digest& key, const CoverSet& covers);

/// A hash that begins with all that a cover depends on beside geometry and levels: what computed it.
/// `what` tells kinds of keys apart.
Sha256 cover_key(std::string_view what);
void add_levels(Sha256& hash, const CoverLevels& levels);

}  // namespace srmp
