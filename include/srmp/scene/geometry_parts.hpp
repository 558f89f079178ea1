#pragma once

#include <memory>

namespace coal {
class CollisionGeometry;
}

namespace srmp {

class PrimitiveBvh;

/// Simpler geometries that a checker evaluates before a geometry, or instead of it. Opaque to users of the library.
struct GeometryParts {
  std::shared_ptr<const coal::CollisionGeometry> hull;  ///< outer_hull(geometry)
  std::shared_ptr<const PrimitiveBvh> bvh;              ///< make_primitive_bvh(geometry); nullptr for a convex solid
};

}  // namespace srmp
