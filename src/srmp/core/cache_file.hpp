#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "srmp/core/sha256.hpp"

namespace srmp {

// Files of what takes long to compute, named by what it was computed from. Damaged, cut or foreign ones count as
// missing.

/// What the directory holds under the key, bit for bit as written. Nothing where there is no such file, or no directory
/// ("").
std::optional<std::string> read_cached(const std::filesystem::path& directory, std::string_view extension,
                                       const Sha256::Digest& key);

/// As write_file. False when that was impossible.
bool write_cached(const std::filesystem::path& directory, std::string_view extension, const Sha256::Digest& key,
                  std::string_view content);

}  // namespace srmp
