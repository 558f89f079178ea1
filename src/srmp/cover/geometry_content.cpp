#include "srmp/cover/geometry_content.hpp"

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
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    triangles.push_back({static_cast<int>(faces[i][0]), static_cast<int>(faces[i][1]), static_cast<int>(faces[i][2])});
  return triangles;
}

std::optional<GeometryContent> primitive_content(const coal::CollisionGeometry& shape) {
  using enum GeometryContent::Kind;
  if (const auto* s = as<coal::Sphere>(shape)) return GeometryContent{sphere, {s->radius, 0, 0}, {}, {}};
  if (const auto* s = as<coal::Box>(shape)) return GeometryContent{box, 2 * s->halfSide, {}, {}};
  if (const auto* s = as<coal::Cylinder>(shape))
    return GeometryContent{cylinder, {s->radius, 2 * s->halfLength, 0}, {}, {}};
  if (const auto* s = as<coal::Capsule>(shape))
    return GeometryContent{capsule, {s->radius, 2 * s->halfLength, 0}, {}, {}};
  if (const auto* s = as<coal::Cone>(shape)) return GeometryContent{cone, {s->radius, 2 * s->halfLength, 0}, {}, {}};
  return std::nullopt;
}

}  // namespace

GeometryContent content_of(const coal::CollisionGeometry& shape) {
  if (const auto* s = as<coal::ShapeBase>(shape); s && s->getSweptSphereRadius() != 0)
    throw NotSupported("sphere covers do not support shapes swept by a sphere; use padding instead");
  if (auto primitive = primitive_content(shape)) return *primitive;
  if (const auto* s = as<coal::Convex<coal::Triangle>>(shape))
    return {GeometryContent::Kind::convex,
            Eigen::Vector3d::Zero(),
            {s->points->begin(), s->points->begin() + s->num_points},
            triangles_of(*s->polygons, s->num_polygons)};
  if (const auto* mesh = as<coal::BVHModelBase>(shape); mesh && mesh->num_tris > 0)
    return {GeometryContent::Kind::mesh,
            Eigen::Vector3d::Zero(),
            {mesh->vertices->begin(), mesh->vertices->begin() + mesh->num_vertices},
            triangles_of(*mesh->tri_indices, mesh->num_tris)};
  throw NotSupported("sphere covers exist for solids and meshes, not for this kind of geometry");
}

}  // namespace srmp
