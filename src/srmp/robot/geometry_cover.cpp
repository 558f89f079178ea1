#include "srmp/robot/geometry_cover.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

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
  for (std::size_t i = 0; i < count; ++i)
    triangles.push_back({static_cast<int>(faces[i][0]), static_cast<int>(faces[i][1]), static_cast<int>(faces[i][2])});
  return triangles;
}

std::optional<CoverSolid> convex_solid(const coal::CollisionGeometry& shape) {
  if (const auto* s = as<coal::Sphere>(shape)) return CoverSolid::sphere(s->radius);
  if (const auto* s = as<coal::Box>(shape)) return CoverSolid::box(2 * s->halfSide);
  if (const auto* s = as<coal::Cylinder>(shape)) return CoverSolid::cylinder(s->radius, 2 * s->halfLength);
  if (const auto* s = as<coal::Capsule>(shape)) return CoverSolid::capsule(s->radius, 2 * s->halfLength);
  if (const auto* s = as<coal::Cone>(shape)) return CoverSolid::cone(s->radius, 2 * s->halfLength);
  if (const auto* s = as<coal::Convex<coal::Triangle>>(shape))
    return CoverSolid::convex({s->points->begin(), s->points->begin() + s->num_points},
                              triangles_of(*s->polygons, s->num_polygons));
  return std::nullopt;
}

CoverSolid solid_of(const coal::CollisionGeometry& shape, const coal::CollisionGeometry* hull) {
  if (auto solid = convex_solid(shape)) return *solid;
  const auto* mesh = as<coal::BVHModelBase>(shape);
  if (mesh == nullptr)
    throw NotSupported("sphere covers are made for solids and meshes, not for this kind of geometry");
  const CoverSolid solid = CoverSolid::mesh({mesh->vertices->begin(), mesh->vertices->begin() + mesh->num_vertices},
                                            triangles_of(*mesh->tri_indices, mesh->num_tris));
  if (solid.is_closed() || hull == nullptr) return solid;
  return convex_solid(*hull).value_or(solid);
}

}  // namespace

GeometryCover cover_geometry(const coal::CollisionGeometry& shape, const coal::CollisionGeometry* hull,
                             const CoverLevels& levels) {
  const CoverSolid solid = solid_of(shape, hull);
  GeometryCover cover;
  cover.bound = solid.bounding_ball();
  if (as<coal::Sphere>(shape)) {
    cover.coarse = {cover.bound};
    cover.exact = true;
    return cover;
  }
  const SphereCover coarse = cover_solid(solid, {.max_inflation = levels.coarse});
  const SphereCover fine = cover_solid(solid, {.max_inflation = levels.fine});
  cover.coarse = coarse.balls;
  cover.coarse_inflation = coarse.max_inflation;
  cover.fine_inflation = fine.max_inflation;
  cover.fine = fine.balls;
  cover.children = cover_children(solid, cover.coarse, cover.fine);
  cover.inner = pack_solid(solid_of(shape, nullptr), levels.inner);
  cover.hollow = !convex_solid(shape);
  return cover;
}

}  // namespace srmp
