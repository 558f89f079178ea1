#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace srmp {

/// A box in single precision, enlarged by more than it was rounded: for bounds of many distances. It contains the
/// original, and its edges are orthogonal to about 1e-7. Fourth components are 0; they fill the registers.
struct RoundedBox {
  std::array<Eigen::Vector4f, 3> rows;  ///< of the matrix whose columns are the directions of the edges
  Eigen::Vector4f center, half_extents;

  RoundedBox() = default;
  RoundedBox(const Eigen::Matrix3d& axes, const Eigen::Vector3d& center, const Eigen::Vector3d& half_extents);

  Eigen::Matrix3d axes() const;
  Eigen::Vector3d center3d() const { return center.head<3>().cast<double>(); }
  Eigen::Vector3d half_extents3d() const { return half_extents.head<3>().cast<double>(); }
  /// No point of the box is farther from the origin [m].
  float reach() const { return center.norm() + half_extents.norm(); }
};

/// The largest product of a point of the box with the direction.
double support_along(const Eigen::Vector3d& direction, const RoundedBox& box);
/// Of the point from the box; 0 inside.
double squared_distance(const Eigen::Vector3d& point, const RoundedBox& box);

/// Bounds of distances between the boxes of two frames.
class BoxDistanceBounds {
 public:
  /// `b_to_a`: from the frame of the second boxes to that of the first; `reach`: the largest of any box, in its own
  /// frame.
  BoxDistanceBounds(const Eigen::Isometry3d& b_to_a, float reach_of_a, float reach_of_b);

  /// The second box in the first one's frame.
  RoundedBox in_a(const RoundedBox& b) const;
  /// A lower bound of the squared distance [m^2], rounding included. Separating axes: the edges of b first; where they
  /// give more than `enough`, those of a are not tried.
  float squared_bound(const RoundedBox& a, const RoundedBox& b_in_a, float enough) const;

 private:
  std::array<Eigen::Vector4f, 3> rows_, columns_;  // of the rotation
  Eigen::Vector4f offset_;
  float rounding_;  // more than all that is rounded can change a distance [m]
};

namespace detail {

/// The sum of the vectors, each times a component.
inline Eigen::Vector4f linear_combination(const std::array<Eigen::Vector4f, 3>& vectors,
                                          const Eigen::Vector4f& factors) {
  return vectors[0] * factors[0] + vectors[1] * factors[1] + vectors[2] * factors[2];
}

inline float squared_length_outside(const Eigen::Vector4f& offset, const Eigen::Vector4f& extents, float rounding) {
  return (offset.cwiseAbs() - extents - Eigen::Vector4f::Constant(rounding)).cwiseMax(0.0f).squaredNorm();
}

}  // namespace detail

inline RoundedBox BoxDistanceBounds::in_a(const RoundedBox& b) const {
  RoundedBox box;
  for (std::size_t i = 0; i < 3; ++i) box.rows[i] = detail::linear_combination(b.rows, rows_[i]);
  box.center = detail::linear_combination(columns_, b.center) + offset_;
  box.half_extents = b.half_extents;
  return box;
}

inline float BoxDistanceBounds::squared_bound(const RoundedBox& a, const RoundedBox& b, float enough) const {
  const Eigen::Vector4f offset = b.center - a.center;
  // Column i: the edges of b along edge i of a. No products of matrices: they use fused multiply-adds where there are.
  Eigen::Matrix4f cosines = Eigen::Matrix4f::Zero();
  for (int i = 0; i < 3; ++i)
    cosines.col(i) = (b.rows[0] * a.rows[0][i] + b.rows[1] * a.rows[1][i] + b.rows[2] * a.rows[2][i]).cwiseAbs();
  const auto along = [&](const Eigen::Vector4f& half_extents) -> Eigen::Vector4f {
    return cosines.col(0) * half_extents[0] + cosines.col(1) * half_extents[1] + cosines.col(2) * half_extents[2];
  };
  const float along_b = detail::squared_length_outside(detail::linear_combination(b.rows, offset),
                                                       b.half_extents + along(a.half_extents), rounding_);
  if (along_b > enough) return along_b;
  cosines.transposeInPlace();
  return std::max(along_b, detail::squared_length_outside(detail::linear_combination(a.rows, offset),
                                                          a.half_extents + along(b.half_extents), rounding_));
}

}  // namespace srmp
