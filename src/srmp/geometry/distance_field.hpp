#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "srmp/geometry/primitive_bvh.hpp"

namespace srmp {

/// Lower and upper bounds on the distance from any point to a geometry, interpolated from a grid over its bounding box.
/// Everything is in the geometry's frame. Const once built.
///
/// With v = squared() at the corners of a cell, t in [0, 1]^3 the position within the cell and h the cell's edge,
///   distance^2 >= (trilinear interpolation of v at t) - h^2 * sum_i t_i (1 - t_i):
/// distance^2 - |p|^2 is the minimum of functions that are affine in p, so it is concave, and its interpolation is
/// never above it. The same holds with distance^2 limited to reach()^2. Outside of the grid, the squared distance to
/// the grid's box adds to the bound at the nearest point of the box, since the box is convex and contains the geometry.
///
/// From above: distance <= sqrt(v) + error_bound() + (distance to the grid point), where v < reach()^2.
class DistanceField {
 public:
  /// Of the triangles or cubes. The cells are as small as construction within some milliseconds allows.
  explicit DistanceField(const PrimitiveBvh& primitives);
  /// Of the convex solid with this surface, whose triangles extend beyond the solid by at most `outside` [m].
  DistanceField(const PrimitiveBvh& surface, double outside);

  /// The distance to a point is within these, except for rounding.
  struct Bounds {
    double low{}, high{};  ///< [m]; high may be infinity
  };
  /// The bounds at a point, inside or outside of the grid.
  Bounds distance(const Eigen::Vector3d& point) const;

  const Eigen::Vector3d& corner() const { return corner_; }       ///< grid point (0, 0, 0)
  double cell() const { return cell_; }                           ///< edge of a cell [m]
  const std::array<int, 3>& size() const { return size_; }        ///< grid points along x, y, z; at least 2 each
  const std::vector<float>& squared() const { return squared_; }  ///< [m^2], x runs fastest; may be negative near 0
  double reach() const { return reach_; }                         ///< [m] distances above this are not stored
  double error_bound() const { return error_bound_; }             ///< [m] how far the stored distances may be too small

 private:
  struct Voxels;
  DistanceField(const PrimitiveBvh& primitives, bool solid, double outside);
  void measure(const Voxels& voxels);

  Eigen::Vector3d corner_;
  double cell_{};
  std::array<int, 3> size_{};
  std::vector<float> squared_;
  double reach_{}, error_bound_{};
};

/// The distance field of a geometry; nullptr for boxes, spheres, cylinders and capsules, whose distance is a formula.
/// `bvh` is make_primitive_bvh(geometry).
std::shared_ptr<const DistanceField> make_distance_field(const coal::CollisionGeometry& geometry,
                                                         const PrimitiveBvh* bvh);

}  // namespace srmp
