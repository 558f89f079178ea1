#pragma once

#include <string>
#include <vector>

namespace srmp {

/// The file that a URDF's mesh filename means, as an absolute path:
///  - package://X/rest: D/X/rest, or D/rest where D itself is called X, for D = the URDF's directory, its parents,
///    `package_dirs`, and the entries of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH (with /share);
///  - a relative path: from the URDF's directory, then from `package_dirs`;
///  - file:// and absolute paths: as they are.
/// `urdf_directory` is "" for a URDF given as text. Throws FileError, starting with `where`, that lists every place
/// tried.
std::string find_mesh(const std::string& filename, const std::string& urdf_directory,
                      const std::vector<std::string>& package_dirs, const std::string& where);

}  // namespace srmp
