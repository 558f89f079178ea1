#pragma once

#include <cstdint>

#include "srmp/cover/geometry_cover.hpp"

namespace srmp {

/// Changes whenever quick_cover computes something else: files keep what it computed.
constexpr std::uint64_t quick_cover_version = 2;

/// A cover of a geometry in milliseconds: spheres around parts of a box, slabs of something long and round, or patches
/// of a mesh. Looser than that of cover_geometry, and marked as `quick`; boxes, cylinders and capsules have inner
/// spheres. Throws NotSupported as cover_geometry does.
GeometryCover quick_cover(const coal::CollisionGeometry& shape);

/// Spheres around parts of a box with this centre and these half edges [m], on two levels; `hollow`, without inner
/// spheres: what is in the box is not known.
GeometryCover box_cover(const Eigen::Vector3d& center, const Eigen::Vector3d& half);

}  // namespace srmp
