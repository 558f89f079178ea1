#pragma once

#include <string>

#include "srmp/trajectory/trajectory.hpp"

namespace srmp::io {

/// Writes the trajectory with its certificate atomically (JSON, docs/files.md). Numbers read back bit for
/// bit. Throws FileError when the file cannot be written, InvalidArgument for arrays that do not fit together.
void save_trajectory(const Trajectory& trajectory, const std::string& path);

/// The trajectory of a trajectory file, of a problem file, or of what `srmp plan -o` writes. Throws FileError, with
/// file and line, for anything missing, misspelt or of the wrong type, arrays that do not fit together, a file of
/// another format or of a newer version, and one that holds no trajectory.
Trajectory load_trajectory(const std::string& path);

/// The certificate as JSON, as in these files.
std::string to_json(const Certificate& certificate);

}  // namespace srmp::io
