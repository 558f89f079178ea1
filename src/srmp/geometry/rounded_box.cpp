#include "srmp/geometry/rounded_box.hpp"

#include <limits>

namespace srmp {

namespace {

constexpr float epsilon = std::numeric_limits<float>::epsilon();
/// [m] Boxes that reach farther count as being everywhere: squares would overflow.
constexpr double farthest = 1e15;
constexpr float everywhere = 1e18f;

Eigen::Vector4f rounded(const Eigen::Vector3d& v) { return {float(v.x()), float(v.y()), float(v.z()), 0.0f}; }

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

}  // namespace srmp
