#pragma once

#include "srmp/core/sha256.hpp"
#include "srmp/cover/sphere_cover.hpp"

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// How far the spheres of a cover extend beyond the covered solid [m]: the largest, and the mean over spheres.
struct Inflation {
  double max{}, mean{};
};

/// The spheres of a collision geometry, in the geometry's frame [m].
struct GeometryCover {
  PlacedSphere bound{};                ///< contains the geometry
  std::vector<PlacedSphere> coarse{};  ///< together they contain the geometry
  std::vector<PlacedSphere> fine{};    ///< the same, more closely; empty when exact
  std::vector<PlacedSphere> inner{};   ///< inside of the geometry; empty when exact
  /// cover_children(coarse, fine), by coarse sphere; empty when exact.
  std::vector<std::vector<std::uint32_t>> children{};
  bool exact{false};   ///< the geometry is a sphere, and the only coarse sphere equals it
  bool quick{false};   ///< made by quick_cover
  bool hollow{false};  ///< a surface: bodies wholly inside do not collide with it
  Inflation coarse_inflation{}, fine_inflation{};
};

/// How closely spheres cover a geometry.
struct CoverLevels {
  double coarse{0.015};   ///< [m] largest inflation, > 0
  double fine{0.004};     ///< [m] largest inflation, > 0 and at most coarse
  double closing{0.015};  ///< [m] >= 0: a cover may fill cavities that a sphere of this radius cannot enter
  std::size_t inner{12};  ///< largest number of inner spheres
  /// [m] > 0: a geometry whose bounding sphere has a larger radius, r, is covered less closely, so that a table takes
  /// no longer than a link: with x = r / full_size, both inflations grow by min(x⁶, 6 x).
  double full_size{0.5};

  bool operator==(const CoverLevels&) const = default;
};

/// Covers boxes, spheres, cylinders, capsules, cones, convex hulls and triangle meshes. The inner spheres of a mesh lie
/// where it is closed; see GeometryCover::hollow. Throws NotSupported for other geometries (octrees, planes) and
/// InvalidArgument for levels out of range.
GeometryCover cover_geometry(const coal::CollisionGeometry& shape, const CoverLevels& levels = {});

/// cover_geometry in steps, so that the coarse level can be repeated with a larger inflation until its spheres are few
/// enough.
class GeometryCoverBuilder {
 public:
  /// Computes the coarse level with levels.coarse. Throws as cover_geometry does.
  GeometryCoverBuilder(const coal::CollisionGeometry& shape, const CoverLevels& levels);

  /// The number of coarse spheres.
  std::size_t coarse_count() const { return cover_.coarse.size(); }
  /// The inflation of the last cover_coarsely [m].
  double coarse_target() const { return coarse_target_; }
  /// Replaces the coarse level by one with this largest inflation [m] > 0.
  void cover_coarsely(double inflation);
  /// Computes the other levels and returns all.
  GeometryCover finish();

 private:
  CoverSolid solid_;
  CoverLevels levels_;
  double coarse_target_{};
  GeometryCover cover_;
};

/// Throws InvalidArgument unless the levels are as CoverLevels requires.
void require_levels(const CoverLevels& levels);

/// Adds the geometry's kind and numbers to the hash; with the levels, a cover depends on nothing else. Throws
/// NotSupported as cover_geometry does.
void add_content(Sha256& hash, const coal::CollisionGeometry& shape);

}  // namespace srmp
