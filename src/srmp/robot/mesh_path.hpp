#pragma once

#include <string>
#include <vector>

namespace srmp {

/// The absolute path of the file that a mesh filename of a URDF refers to:
///  - package://X/path: D/X/path, or D/path where D itself is named X, for D = the URDF's directory, its parents,
///    `package_dirs`, and the entries of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH (with /share);
///  - a relative path: from the URDF's directory, then from `package_dirs`;
///  - file:// and absolute paths: unchanged.
/// `urdf_directory` is "" for a URDF without one. Throws FileError, whose text starts with `where` and lists every
/// place tried.
std::string find_mesh(const std::string& filename, const std::string& urdf_directory,
                      const std::vector<std::string>& package_dirs, const std::string& where);

}  // namespace srmp
