#include "srmp/geometry/rounded_box.hpp"

#include <algorithm>
#include <limits>

namespace srmp {

namespace {

constexpr float epsilon = std::numeric_limits<float>::epsilon();
/// [m] Boxes that reach farther count as being everywhere: squares would overflow.
constexpr double farthest = 1e15;
constexpr float everywhere = 1e18f;

Eigen::Vector4f rounded(const Eigen::Vector3d& v) { return {float(v.x()), float(v.y()), float(v.z()), 0.0f}; }

/// The sum of the vectors, each times a component.
Eigen::Vector4f linear_combination(const std::array<Eigen::Vector4f, 3>& vectors, const Eigen::Vector4f& factors) {
  return vectors[0] * factors[0] + vectors[1] * factors[1] + vectors[2] * factors[2];
}

float squared_length_outside(const Eigen::Vector4f& offset, const Eigen::Vector4f& extents, float rounding) {
  return (offset.cwiseAbs() - extents - Eigen::Vector4f::Constant(rounding)).cwiseMax(0.0f).squaredNorm();
}

}  // namespace

/// Rounding moves a corner by 1.4 epsilon times the sum of the lengths at most.
RoundedBox::RoundedBox(const Eigen::Matrix3d& axes, const Eigen::Vector3d& middle, const Eigen::Vector3d& half)
    : rows{rounded(axes.row(0)), rounded(axes.row(1)), rounded(axes.row(2))}, center(rounded(middle)) {
  const double lengths = middle.lpNorm<1>() + half.lpNorm<1>();
  half_extents = rounded(half + Eigen::Vector3d::Constant(4.0 * epsilon * lengths));
  if (lengths < farthest) return;
  center.setZero();
  half_extents = {everywhere, everywhere, everywhere, 0.0f};
}

Eigen::Matrix3d RoundedBox::axes() const {
  Eigen::Matrix3d all;
  for (int i = 0; i < 3; ++i) all.row(i) = rows[static_cast<std::size_t>(i)].head<3>().cast<double>();
  return all;
}

double support_along(const Eigen::Vector3d& direction, const RoundedBox& box) {
  return direction.dot(box.center3d()) + (box.axes().transpose() * direction).cwiseAbs().dot(box.half_extents3d());
}

double squared_distance(const Eigen::Vector3d& point, const RoundedBox& box) {
  const Eigen::Vector3d off = box.axes().transpose() * (point - box.center3d());
  return (off.cwiseAbs() - box.half_extents3d()).cwiseMax(0.0).squaredNorm();
}

BoxDistanceBounds::BoxDistanceBounds(const Eigen::Isometry3d& b_to_a, float reach_of_a, float reach_of_b)
    : offset_(rounded(b_to_a.translation())) {
  for (int i = 0; i < 3; ++i) {
    rows_[static_cast<std::size_t>(i)] = rounded(b_to_a.linear().row(i));
    columns_[static_cast<std::size_t>(i)] = rounded(b_to_a.linear().col(i));
  }
  // All that is rounded adds up to 14 epsilon times the sum of the lengths at most.
  rounding_ = 32.0f * epsilon * (reach_of_a + reach_of_b + offset_.norm());
  if (b_to_a.translation().lpNorm<1>() < farthest) return;
  offset_.setZero();
  rounding_ = everywhere;
}

RoundedBox BoxDistanceBounds::in_a(const RoundedBox& b) const {
  RoundedBox box;
  for (std::size_t i = 0; i < 3; ++i) box.rows[i] = linear_combination(b.rows, rows_[i]);
  box.center = linear_combination(columns_, b.center) + offset_;
  box.half_extents = b.half_extents;
  return box;
}

float BoxDistanceBounds::squared_bound(const RoundedBox& a, const RoundedBox& b, float enough) const {
  const Eigen::Vector4f offset = b.center - a.center;
  // Column i: the edges of b along edge i of a. No products of matrices: they use fused multiply-adds where there are.
  Eigen::Matrix4f cosines = Eigen::Matrix4f::Zero();
  for (int i = 0; i < 3; ++i)
    cosines.col(i) = (b.rows[0] * a.rows[0][i] + b.rows[1] * a.rows[1][i] + b.rows[2] * a.rows[2][i]).cwiseAbs();
  const auto along = [&](const Eigen::Vector4f& half_extents) -> Eigen::Vector4f {
    return cosines.col(0) * half_extents[0] + cosines.col(1) * half_extents[1] + cosines.col(2) * half_extents[2];
  };
  const float along_b =
      squared_length_outside(linear_combination(b.rows, offset), b.half_extents + along(a.half_extents), rounding_);
  if (along_b > enough) return along_b;
  cosines.transposeInPlace();
  return std::max(along_b, squared_length_outside(linear_combination(a.rows, offset),
                                                  a.half_extents + along(b.half_extents), rounding_));
}

}  // namespace srmp
