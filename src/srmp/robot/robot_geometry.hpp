#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "srmp/robot/robot_description.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

/// A collision geometry and its pose in the frame of its link.
struct PlacedGeometry {
  LinkGeometry geometry;  ///< without its joint support
  Eigen::Isometry3d in_link;
};

/// Loads the collision geometries of a URDF, in the order of the file. Meshes are searched in `urdf_directory` first,
/// unless that is "". Throws FileError with the line of the geometry.
std::vector<PlacedGeometry> load_geometries(const Urdf& urdf, const std::string& urdf_directory,
                                            const std::vector<std::string>& package_dirs);

}  // namespace srmp
