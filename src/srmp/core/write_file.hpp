#pragma once

#include <filesystem>
#include <string_view>

namespace srmp {

/// Replaces a file atomically: writes a temporary file in the same directory, waits until it is on the disk, and
/// renames it, so that readers see either the old file or the new one. Throws FileError with the reason when that is
/// impossible; an old file is then unchanged. The directory must exist.
///
/// The new file has the permissions of the old one, and its owner where that is allowed. A symbolic link stays; what it
/// leads to is replaced. A pipe, a device and an open file of the process (/dev/stdout) are written to and stay.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace srmp
