#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "srmp/core/placed_sphere.hpp"

namespace srmp {

struct SolidGeometry;

/// A solid that spheres can cover, in its own frame; curved solids lie along z, centred, as in scene/shape.hpp. Lengths
/// in metres. Immutable and cheap to copy. The factories throw InvalidArgument for lengths that are not positive and
/// finite, vertices that are not finite, and triangles that do not exist or name missing vertices.
class CoverSolid {
 public:
  using Vertices = std::vector<Eigen::Vector3d>;
  using Triangles = std::vector<std::array<int, 3>>;  ///< indices into the vertices

  static CoverSolid sphere(double radius);
  static CoverSolid box(const Eigen::Vector3d& size);  ///< full edge lengths
  static CoverSolid cylinder(double radius, double length);
  static CoverSolid capsule(double radius, double length);  ///< `length` is without the half spheres
  static CoverSolid cone(double radius, double length);
  /// The convex hull of the vertices. The triangles are its faces, or nearly so: only the quality of covers depends on
  /// them.
  static CoverSolid convex(const Vertices& vertices, const Triangles& triangles);
  /// A triangle surface with everything that it encloses. Holes, doubled faces and wrong orientations are allowed:
  /// enclosed is what cannot be reached from outside on a voxel grid (1/128 of the size). Inflation is measured from
  /// that and from the cavities that a sphere of radius `closing` [m] cannot enter; a cover need not contain those. A
  /// mesh that is convex but for rounding is treated as its hull.
  static CoverSolid mesh(const Vertices& vertices, const Triangles& triangles, double closing = 0);

  bool is_convex() const;
  bool is_closed() const;  ///< convex, or a mesh whose every edge has an even number of triangles
  /// The smallest sphere found (not minimal) that contains the solid.
  PlacedSphere bounding_sphere() const;
  /// Depth of a point [m]: > 0 inside (a sphere of that radius is inside the solid), < 0 outside. Exact for convex
  /// solids inside, a lower bound elsewhere.
  double depth(const Eigen::Vector3d& point) const;

  const SolidGeometry& geometry() const { return *geometry_; }  ///< for the algorithms of this directory

 private:
  explicit CoverSolid(std::shared_ptr<const SolidGeometry> geometry) : geometry_(std::move(geometry)) {}
  std::shared_ptr<const SolidGeometry> geometry_;
};

}  // namespace srmp
