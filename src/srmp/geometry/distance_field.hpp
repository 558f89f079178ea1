#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "srmp/geometry/primitive_bvh.hpp"

namespace srmp {

/// What is known of the distance to a geometry everywhere, from a grid of points over its bounding box; in its frame.
///
/// With v = squared() at the corners of a cell, t in [0, 1]^3 the place in the cell and h the cell's edge,
///   distance^2 >= (trilinear interpolation of v at t) - h^2 * sum_i t_i (1 - t_i):
/// distance^2 - |p|^2 is the smallest of functions that are affine in p, so it is concave, and its interpolation is
/// never above it. The same holds with distance^2 cut off at reach()^2. Outside of the grid, the squared distance to
/// the grid's box adds to the bound at the nearest point of the box, since the box is convex and holds the geometry.
///
/// From above: distance <= sqrt(v) + excess() + (distance to the grid point), where v < reach()^2.
class DistanceField {
 public:
  /// The smallest cells that keep the making of it to some milliseconds.
  explicit DistanceField(const PrimitiveBvh& pieces);
  /// Of the convex solid with this surface; its triangles may stick out by `outside` [m].
  DistanceField(const PrimitiveBvh& surface, double outside);

  /// The distance to a point is within these, but for rounding.
  struct Bounds {
    double low{}, high{};  ///< [m]; high may be infinity
  };
  Bounds distance(const Eigen::Vector3d& point) const;

  const Eigen::Vector3d& corner() const { return corner_; }       ///< grid point (0, 0, 0)
  double cell() const { return cell_; }                           ///< edge of a cell [m]
  const std::array<int, 3>& size() const { return size_; }        ///< grid points along x, y, z; at least 2 each
  const std::vector<float>& squared() const { return squared_; }  ///< [m^2], x runs fastest; may be negative near 0
  double reach() const { return reach_; }                         ///< [m]
  double excess() const { return excess_; }                       ///< [m]

 private:
  struct Sites;
  DistanceField(const PrimitiveBvh& pieces, bool solid, double outside);
  void measure(const Sites& sites);

  Eigen::Vector3d corner_;
  double cell_{};
  std::array<int, 3> size_{};
  std::vector<float> squared_;
  double reach_{}, excess_{};
};

/// nullptr for boxes, spheres, cylinders and capsules, whose distance is a formula. `pieces`:
/// make_primitive_bvh(geometry).
std::shared_ptr<const DistanceField> make_distance_field(const coal::CollisionGeometry& geometry,
                                                         const PrimitiveBvh* pieces);

}  // namespace srmp
