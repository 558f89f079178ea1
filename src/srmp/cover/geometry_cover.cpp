#include "srmp/cover/geometry_cover.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <cmath>
#include <optional>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

template <class T>
const T* as(const coal::CollisionGeometry& geometry) {
  return dynamic_cast<const T*>(&geometry);
}

template <class Faces>
CoverSolid::Triangles triangles_of(const Faces& faces, std::size_t count) {
  CoverSolid::Triangles triangles;
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    triangles.push_back({static_cast<int>(faces[i][0]), static_cast<int>(faces[i][1]), static_cast<int>(faces[i][2])});
  return triangles;
}

/// The input of a cover: the numbers of a primitive, or a mesh.
struct Content {
  enum class Kind : std::uint8_t { sphere, box, cylinder, capsule, cone, convex, mesh } kind{};
  Eigen::Vector3d size{Eigen::Vector3d::Zero()};  // radius; edges; radius, length
  CoverSolid::Vertices vertices;
  CoverSolid::Triangles triangles;
};

std::optional<Content> primitive_content(const coal::CollisionGeometry& shape) {
  using enum Content::Kind;
  if (const auto* s = as<coal::Sphere>(shape)) return Content{sphere, {s->radius, 0, 0}, {}, {}};
  if (const auto* s = as<coal::Box>(shape)) return Content{box, 2 * s->halfSide, {}, {}};
  if (const auto* s = as<coal::Cylinder>(shape)) return Content{cylinder, {s->radius, 2 * s->halfLength, 0}, {}, {}};
  if (const auto* s = as<coal::Capsule>(shape)) return Content{capsule, {s->radius, 2 * s->halfLength, 0}, {}, {}};
  if (const auto* s = as<coal::Cone>(shape)) return Content{cone, {s->radius, 2 * s->halfLength, 0}, {}, {}};
  return std::nullopt;
}

Content content_of(const coal::CollisionGeometry& shape) {
  if (const auto* s = as<coal::ShapeBase>(shape); s && s->getSweptSphereRadius() != 0)
    throw NotSupported("sphere covers do not support shapes swept by a sphere; use padding instead");
  if (auto primitive = primitive_content(shape)) return *primitive;
  if (const auto* s = as<coal::Convex<coal::Triangle>>(shape))
    return {Content::Kind::convex,
            Eigen::Vector3d::Zero(),
            {s->points->begin(), s->points->begin() + s->num_points},
            triangles_of(*s->polygons, s->num_polygons)};
  if (const auto* mesh = as<coal::BVHModelBase>(shape); mesh && mesh->num_tris > 0)
    return {Content::Kind::mesh,
            Eigen::Vector3d::Zero(),
            {mesh->vertices->begin(), mesh->vertices->begin() + mesh->num_vertices},
            triangles_of(*mesh->tri_indices, mesh->num_tris)};
  throw NotSupported("sphere covers exist for solids and meshes, not for this kind of geometry");
}

CoverSolid solid_of(const Content& content, double closing) {
  switch (content.kind) {
    case Content::Kind::sphere: return CoverSolid::sphere(content.size[0]);
    case Content::Kind::box: return CoverSolid::box(content.size);
    case Content::Kind::cylinder: return CoverSolid::cylinder(content.size[0], content.size[1]);
    case Content::Kind::capsule: return CoverSolid::capsule(content.size[0], content.size[1]);
    case Content::Kind::cone: return CoverSolid::cone(content.size[0], content.size[1]);
    case Content::Kind::convex: return CoverSolid::convex(content.vertices, content.triangles);
    case Content::Kind::mesh: break;
  }
  return CoverSolid::mesh(content.vertices, content.triangles, closing);
}

CoverSolid checked_solid(const coal::CollisionGeometry& shape, const CoverLevels& levels) {
  require_levels(levels);
  return solid_of(content_of(shape), levels.closing);
}

}  // namespace

void require_levels(const CoverLevels& levels) {
  require_positive(levels.coarse, "cover: coarse inflation");
  require_positive(levels.fine, "cover: fine inflation");
  if (levels.fine > levels.coarse)
    throw InvalidArgument("cover: the fine inflation (" + to_text(levels.fine) +
                          " m) must not exceed the coarse one (" + to_text(levels.coarse) + " m)");
  if (!(levels.closing >= 0) || !std::isfinite(levels.closing))
    throw InvalidArgument("cover: closing must be finite and not negative, got " + to_text(levels.closing));
}

void add_content(Sha256& hash, const coal::CollisionGeometry& shape) {
  const Content content = content_of(shape);
  hash.add(static_cast<std::uint8_t>(content.kind));
  hash.add(content.size.data(), 3 * sizeof(double));
  hash.add(static_cast<std::uint64_t>(content.vertices.size()));
  hash.add(content.vertices.data(), content.vertices.size() * sizeof(Eigen::Vector3d));
  hash.add(static_cast<std::uint64_t>(content.triangles.size()));
  hash.add(content.triangles.data(), content.triangles.size() * sizeof(content.triangles[0]));
}

GeometryCoverBuilder::GeometryCoverBuilder(const coal::CollisionGeometry& shape, const CoverLevels& levels)
    : solid_(checked_solid(shape, levels)), levels_(levels) {
  cover_.bound = solid_.bounding_sphere();
  cover_.exact = as<coal::Sphere>(shape) != nullptr;
  cover_.hollow = as<coal::BVHModelBase>(shape) != nullptr;
  cover_coarsely(levels.coarse);
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
