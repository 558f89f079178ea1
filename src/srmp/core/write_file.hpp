#pragma once

#include <filesystem>
#include <string_view>

namespace srmp {

/// Writes a temporary file in the same directory, waits until it is on the disk, and renames it: readers see the old
/// file or the new one, never half of it. Throws FileError that says why it could not; what was there is then as it
/// was.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace srmp
