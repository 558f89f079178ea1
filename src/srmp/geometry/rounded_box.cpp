#include "srmp/geometry/rounded_box.hpp"

#include <limits>

namespace srmp {

namespace {

constexpr float epsilon = std::numeric_limits<float>::epsilon();
/// [m] Boxes that reach farther count as being everywhere: squares would overflow.
constexpr double farthest = 1e15;
constexpr float everywhere = 1e18f;

}  // namespace

/// Rounding moves a corner by 1.4 epsilon times the sum of the lengths at most.
RoundedBox::RoundedBox(const Eigen::Matrix3d& directions, const Eigen::Vector3d& middle, const Eigen::Vector3d& half)
    : axes(directions.cast<float>()), center(middle.cast<float>()) {
  const double lengths = middle.lpNorm<1>() + half.lpNorm<1>();
  half_extents = (half + Eigen::Vector3d::Constant(4.0 * epsilon * lengths)).cast<float>();
  if (lengths < farthest) return;
  center.setZero();
  half_extents.setConstant(everywhere);
}

double support_along(const Eigen::Vector3d& direction, const RoundedBox& box) {
  return direction.dot(box.center3d()) + (box.axes3d().transpose() * direction).cwiseAbs().dot(box.half_extents3d());
}

double squared_distance(const Eigen::Vector3d& point, const RoundedBox& box) {
  const Eigen::Vector3d off = box.axes3d().transpose() * (point - box.center3d());
  return (off.cwiseAbs() - box.half_extents3d()).cwiseMax(0.0).squaredNorm();
}

BoxDistanceBounds::BoxDistanceBounds(const Eigen::Isometry3d& b_to_a, float reach_of_a, float reach_of_b)
    : rotation_(b_to_a.linear().cast<float>()),
      inverse_(rotation_.transpose()),
      offset_(b_to_a.translation().cast<float>()) {
  // All that is rounded adds up to 14 epsilon times the sum of the lengths at most.
  rounding_ = 32.0f * epsilon * (reach_of_a + reach_of_b + offset_.norm());
  if (b_to_a.translation().lpNorm<1>() < farthest) return;
  offset_.setZero();
  rounding_ = everywhere;
}

}  // namespace srmp
