#pragma once

#include <memory>
#include <string>

#include "srmp/geometry/primitive_bvh.hpp"
#include "srmp/scene/geometry_parts.hpp"
#include "srmp/scene/shape.hpp"

namespace srmp {

/// Checks the shape and returns its Coal geometry, with its local bounding box. Throws InvalidArgument, which names
/// `object`, for sizes that are not positive and finite, empty clouds, triangle indices out of range, and the like.
std::shared_ptr<const coal::CollisionGeometry> make_geometry(const Shape& shape, const std::string& object);

/// The convex hull of a mesh. Its distance is a lower bound on the distance of the mesh, and much cheaper. Other
/// geometries, and meshes without volume, are returned unchanged.
std::shared_ptr<const coal::CollisionGeometry> outer_hull(std::shared_ptr<const coal::CollisionGeometry> geometry);

/// The simpler geometries that stand for a geometry, which must not be null.
GeometryParts parts_of(const std::shared_ptr<const coal::CollisionGeometry>& geometry);

}  // namespace srmp
