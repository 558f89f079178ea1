#pragma once

// Internal: the collision geometries of a URDF.

#include <Eigen/Geometry>

#include "srmp/robot/robot_model.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

struct PlacedGeometry {
  LinkGeometry geometry;  // but for its movers
  Eigen::Isometry3d in_link;
};

/// In the order of the file. `urdf_directory`: where meshes are searched first; "" = nowhere. Throws FileError that
/// says the line.
std::vector<PlacedGeometry> load_geometries(const Urdf& urdf, const std::string& urdf_directory,
                                            const std::vector<std::string>& package_dirs);

}  // namespace srmp
