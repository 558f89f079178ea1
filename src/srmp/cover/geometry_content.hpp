#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "srmp/cover/cover_solid.hpp"

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// What a cover is made for: the numbers of a primitive, or a mesh. Lengths in metres.
struct GeometryContent {
  /// What the geometry is.
  enum class Kind : std::uint8_t { sphere, box, cylinder, capsule, cone, convex, mesh };
  Kind kind{};
  Eigen::Vector3d size{Eigen::Vector3d::Zero()};  ///< radius; edges; radius and length
  CoverSolid::Vertices vertices;                  ///< of hulls and meshes
  CoverSolid::Triangles triangles;                ///< of hulls and meshes
};

/// The content of a geometry. Throws NotSupported for geometries that cannot be covered (octrees, planes, shapes swept
/// by a sphere).
GeometryContent content_of(const coal::CollisionGeometry& shape);

}  // namespace srmp
