#pragma once

#include <filesystem>
#include <string_view>

namespace srmp {

/// Replaces a file atomically: writes a temporary file in the same directory, waits until it is on the disk, and
/// renames it, so that readers see either the old file or the new one. Throws FileError with the reason when that is
/// impossible; an old file is then unchanged. The directory must exist. The new file has the permissions of the old
/// one, and its owner where that is allowed; a symbolic link stays, what it leads to is replaced. What is not a file,
/// such as /dev/stdout or a pipe, is written to and stays, too.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace srmp
