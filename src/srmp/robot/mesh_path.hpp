#pragma once

#include <string>
#include <vector>

namespace srmp {

/// The file that a URDF's mesh filename means, as an absolute path:
///  - package://X/rest: D/X/rest, or D/rest where D itself is called X, for D = the URDF's folder, its parents,
///    `package_dirs`, and the entries of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH (with /share);
///  - a relative path: from the URDF's folder, then from `package_dirs`;
///  - file:// and absolute paths: as they are.
/// `urdf_folder` is "" for a URDF given as text. Throws FileError, starting with `where`, that lists every place tried.
std::string find_mesh(const std::string& filename, const std::string& urdf_folder,
                      const std::vector<std::string>& package_dirs, const std::string& where);

}  // namespace srmp
