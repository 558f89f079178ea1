#pragma once

#include "srmp/core/sha256.hpp"
#include "srmp/cover/sphere_cover.hpp"

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// How far spheres of a cover stick out of what they cover [m].
struct Inflation {
  double max{}, mean{};
};

/// A collision geometry under spheres, in the geometry's frame: one around it, coarse ones, fine ones, and some inside.
struct GeometryCover {
  PlacedSphere bound;
  std::vector<PlacedSphere> coarse, fine, inner;
  std::vector<std::vector<std::uint32_t>> children;  ///< cover_children(coarse, fine); both empty when exact
  bool exact{false};                                 ///< the one coarse sphere is the geometry
  bool hollow{false};                                ///< a surface, not a solid
  Inflation coarse_inflation, fine_inflation;
};

struct CoverLevels {
  double coarse{0.015};   ///< [m] largest inflation, > 0
  double fine{0.004};     ///< [m] largest inflation, > 0 and at most coarse
  double closing{0.015};  ///< [m] cavities that a sphere of this radius cannot enter may be filled; 0: none
  std::size_t inner{12};  ///< spheres inside, at most

  bool operator==(const CoverLevels&) const = default;
};

/// Covers boxes, spheres, cylinders, capsules, cones, convex hulls and triangle meshes. The inner spheres of a mesh lie
/// where it is closed; see GeometryCover::hollow. Throws NotSupported for other geometries (octrees, planes) and
/// InvalidArgument for levels out of range.
GeometryCover cover_geometry(const coal::CollisionGeometry& shape, const CoverLevels& levels = {});

/// The same in steps: the coarse level is searched by itself, with the inflation that the spheres' number calls for.
class GeometryCoverBuilder {
 public:
  /// Throws as cover_geometry does.
  GeometryCoverBuilder(const coal::CollisionGeometry& shape, const CoverLevels& levels);

  std::size_t coarse_count() const { return cover_.coarse.size(); }
  double coarse_target() const { return coarse_target_; }
  void cover_coarsely(double inflation);
  GeometryCover finish();

 private:
  CoverSolid solid_;
  CoverLevels levels_;
  double coarse_target_{};
  GeometryCover cover_;
};

/// Throws InvalidArgument unless the levels are finite, positive and in order.
void require_levels(const CoverLevels& levels);

/// Adds all that a cover depends on: the geometry's kind and numbers. Throws NotSupported as cover_geometry does.
void add_content(Sha256& hash, const coal::CollisionGeometry& shape);

}  // namespace srmp
