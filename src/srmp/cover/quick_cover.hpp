#pragma once

#include "srmp/cover/geometry_cover.hpp"

namespace srmp {

/// A cover of a geometry in milliseconds: spheres around the cells of a box, or around patches of a mesh. Looser than
/// that of cover_geometry, without inner spheres, and marked as `quick`. Throws NotSupported as cover_geometry does.
GeometryCover quick_cover(const coal::CollisionGeometry& shape);

/// Spheres around the cells of a box with this centre and these half edges [m], on two levels; `hollow`.
GeometryCover box_cells_cover(const Eigen::Vector3d& center, const Eigen::Vector3d& half);

}  // namespace srmp
