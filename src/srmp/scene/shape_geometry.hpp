#pragma once

#include <memory>
#include <string>

#include "srmp/geometry/primitive_bvh.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// Checks the shape and builds its Coal geometry, local bounding box included. Throws InvalidArgument naming `object`
/// (non-positive or non-finite sizes, empty cloud, triangle index out of range, …).
std::shared_ptr<const coal::CollisionGeometry> make_geometry(const Shape& shape, const std::string& object);

/// The convex hull of a mesh: farther away than the hull means farther away than the mesh, and the hull is far cheaper
/// to ask. Any other geometry, and a mesh that is flat, is returned as it is.
std::shared_ptr<const coal::CollisionGeometry> outer_hull(std::shared_ptr<const coal::CollisionGeometry> geometry);

GeometryParts parts_of(const std::shared_ptr<const coal::CollisionGeometry>& geometry);

}  // namespace srmp
