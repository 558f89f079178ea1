#pragma once

#include <functional>
#include <vector>

#include "srmp/core/placed_sphere.hpp"
#include "srmp/cover/convex_part.hpp"
#include "srmp/cover/solid_geometry.hpp"

namespace srmp {

/// Subdivides a solid until each part is inside of one sphere or smaller than `resolution` [m]. Triangles of a surface
/// are bisected; the interior, and convex solids, are divided into cubic cells. Nothing is sampled, so spheres for
/// which no part is reported uncovered contain the solid.
class ContainmentProof {
 public:
  /// The solid and the spheres must outlive this.
  ContainmentProof(const SolidGeometry& solid, const std::vector<PlacedSphere>& spheres, double resolution)
      : solid_(solid), spheres_(spheres), resolution_(resolution) {}

  /// Called for each part that is in no single sphere and cannot be subdivided further; returns false to stop.
  /// Triangles have three points and cells eight. May be empty.
  std::function<bool(const ConvexPart&)> on_uncovered;
  /// Called for each part that is inside of the sphere with this index. May be empty.
  std::function<void(const ConvexPart&, int sphere)> on_covered;

  void run();

 private:
  using Indices = std::vector<int>;
  void triangle(const Triangle& t, const Indices& near);
  void cell(const Eigen::Vector3d& center, double half, const Indices& near, const Indices& planes);
  bool may_overlap_solid(const Eigen::Vector3d& center, double half, const Indices& planes, Indices& cutting) const;
  void covered(const ConvexPart& part, int sphere);
  void uncovered(const ConvexPart& part);

  const SolidGeometry& solid_;
  const std::vector<PlacedSphere>& spheres_;
  const double resolution_;
  bool running_{true};
};

}  // namespace srmp
