#pragma once

#include "srmp/robot/sphere_cover.hpp"

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// A collision geometry under balls, in the geometry's frame: one around it, coarse ones, fine ones, and some inside.
struct GeometryCover {
  Ball bound;
  std::vector<Ball> coarse, fine, inner;
  std::vector<std::vector<std::uint32_t>> children;  ///< cover_children(coarse, fine); both empty when exact
  bool exact{false};                                 ///< the one coarse ball is the geometry
  bool hollow{false};                                ///< a surface, not a solid
  double coarse_inflation{}, fine_inflation{};       ///< [m] largest; of a mesh covered by its hull: of the hull
};

struct CoverLevels {
  double coarse{0.015};   ///< [m] largest inflation
  double fine{0.004};     ///< [m] largest inflation
  std::size_t inner{12};  ///< balls inside, at most
};

/// Covers boxes, spheres, cylinders, capsules, cones, convex hulls and triangle meshes; a mesh that is not closed by
/// its `hull` where that is given. Inner balls are given for convex solids only: a mesh is a surface to Coal, and what
/// is inside without touching it is no contact. Throws NotSupported for other geometries (octrees, planes).
GeometryCover cover_geometry(const coal::CollisionGeometry& shape, const coal::CollisionGeometry* hull,
                             const CoverLevels& levels = {});

}  // namespace srmp
