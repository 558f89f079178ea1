#include "srmp/cover/geometry_cover.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/cover/geometry_content.hpp"

namespace srmp {

namespace {

CoverSolid solid_of(const GeometryContent& content, double closing) {
  switch (content.kind) {
    case GeometryContent::Kind::sphere: return CoverSolid::sphere(content.size[0]);
    case GeometryContent::Kind::box: return CoverSolid::box(content.size);
    case GeometryContent::Kind::cylinder: return CoverSolid::cylinder(content.size[0], content.size[1]);
    case GeometryContent::Kind::capsule: return CoverSolid::capsule(content.size[0], content.size[1]);
    case GeometryContent::Kind::cone: return CoverSolid::cone(content.size[0], content.size[1]);
    case GeometryContent::Kind::convex: return CoverSolid::convex(content.vertices, content.triangles);
    case GeometryContent::Kind::mesh: break;
  }
  return CoverSolid::mesh(content.vertices, content.triangles, closing);
}

CoverSolid checked_solid(const coal::CollisionGeometry& shape, const CoverLevels& levels) {
  require_levels(levels);
  return solid_of(content_of(shape), levels.closing);
}

/// The levels for a geometry whose bounding sphere has this radius. See CoverLevels::full_size.
CoverLevels levels_for(double radius, CoverLevels levels) {
  if (radius <= levels.full_size) return levels;
  const double ratio = radius / levels.full_size, growth = std::min(std::pow(ratio, 6), 6 * ratio);
  levels.coarse *= growth;
  levels.fine *= growth;
  return levels;
}

}  // namespace

void require_levels(const CoverLevels& levels) {
  require_positive(levels.coarse, "cover: coarse inflation");
  require_positive(levels.fine, "cover: fine inflation");
  if (levels.fine > levels.coarse)
    throw InvalidArgument("cover: the fine inflation (" + to_text(levels.fine) +
                          " m) must not exceed the coarse one (" + to_text(levels.coarse) + " m)");
  require_positive(levels.full_size, "cover: full_size");
  if (!(levels.closing >= 0) || !std::isfinite(levels.closing))
    throw InvalidArgument("cover: closing must be finite and not negative, got " + to_text(levels.closing));
}

void add_content(Sha256& hash, const coal::CollisionGeometry& shape) {
  const GeometryContent content = content_of(shape);
  hash.add(static_cast<std::uint8_t>(content.kind));
  hash.add(content.size.data(), 3 * sizeof(double));
  hash.add(static_cast<std::uint64_t>(content.vertices.size()));
  hash.add(content.vertices.data(), content.vertices.size() * sizeof(Eigen::Vector3d));
  hash.add(static_cast<std::uint64_t>(content.triangles.size()));
  hash.add(content.triangles.data(), content.triangles.size() * sizeof(content.triangles[0]));
}

GeometryCoverBuilder::GeometryCoverBuilder(const coal::CollisionGeometry& shape, const CoverLevels& levels)
    : solid_(checked_solid(shape, levels)) {
  cover_.bound = solid_.bounding_sphere();
  levels_ = levels_for(cover_.bound.radius, levels);
  cover_.exact = dynamic_cast<const coal::Sphere*>(&shape) != nullptr;
  cover_.hollow = dynamic_cast<const coal::BVHModelBase*>(&shape) != nullptr;
  cover_coarsely(levels_.coarse);
}

void GeometryCoverBuilder::cover_coarsely(double inflation) {
  coarse_target_ = inflation;
  if (cover_.exact) {
    cover_.coarse = {cover_.bound};
    return;
  }
  SphereCover coarse = cover_solid(solid_, {.max_inflation = inflation});
  cover_.coarse = std::move(coarse.spheres);
  cover_.coarse_inflation = {coarse.max_inflation, coarse.mean_inflation};
}

GeometryCover GeometryCoverBuilder::finish() {
  if (cover_.exact) return cover_;
  SphereCover fine = cover_solid(solid_, {.max_inflation = levels_.fine});
  cover_.fine = std::move(fine.spheres);
  cover_.fine_inflation = {fine.max_inflation, fine.mean_inflation};
  cover_.children = cover_children(solid_, cover_.coarse, cover_.fine);
  cover_.inner = pack_solid(solid_, levels_.inner);
  return cover_;
}

GeometryCover cover_geometry(const coal::CollisionGeometry& shape, const CoverLevels& levels) {
  return GeometryCoverBuilder(shape, levels).finish();
}

}  // namespace srmp
