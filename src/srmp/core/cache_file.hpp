#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "srmp/core/sha256.hpp"

namespace srmp {

// A cache of results that take long to compute: a directory of files, each named by the SHA-256 of the inputs. Files
// that are damaged, truncated or foreign count as missing.

/// The content that was written under the key, bit for bit; nullopt when there is no such file or `directory` is empty.
/// `extension` begins with a dot.
std::optional<std::string> read_cached(const std::filesystem::path& directory, std::string_view extension,
                                       const Sha256::Digest& key);

/// Creates the directory where it is missing, and writes the file with write_file. False when that is impossible, or
/// `directory` is empty.
bool write_cached(const std::filesystem::path& directory, std::string_view extension, const Sha256::Digest& key,
                  std::string_view content);

}  // namespace srmp
