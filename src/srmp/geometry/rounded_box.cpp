#include "srmp/geometry/rounded_box.hpp"

#include <algorithm>
#include <limits>

namespace srmp {

namespace {

constexpr float unit = std::numeric_limits<float>::epsilon();
/// [m] Boxes that reach farther count as being everywhere: squares would overflow.
constexpr double farthest = 1e15;
constexpr float everywhere = 1e18f;

Eigen::Vector4f rounded(const Eigen::Vector3d& v) { return {float(v.x()), float(v.y()), float(v.z()), 0.0f}; }

/// The sum of the vectors, each times a component.
Eigen::Vector4f combined(const std::array<Eigen::Vector4f, 3>& vectors, const Eigen::Vector4f& factors) {
  return vectors[0] * factors[0] + vectors[1] * factors[1] + vectors[2] * factors[2];
}

float squared_length_outside(const Eigen::Vector4f& offset, const Eigen::Vector4f& reach, float rounding) {
  return (offset.cwiseAbs() - reach - Eigen::Vector4f::Constant(rounding)).cwiseMax(0.0f).squaredNorm();
}

}  // namespace

RoundedBox::RoundedBox(const Eigen::Matrix3d& axes, const Eigen::Vector3d& middle, const Eigen::Vector3d& half_edges)
    : rows{rounded(axes.row(0)), rounded(axes.row(1)), rounded(axes.row(2))}, center(rounded(middle)) {
  const double rounding = 4.0 * unit * (middle.lpNorm<1>() + half_edges.lpNorm<1>());
  half = rounded(half_edges + Eigen::Vector3d::Constant(rounding));
  if (middle.lpNorm<1>() + half_edges.lpNorm<1>() < farthest) return;
  center.setZero();
  half = {everywhere, everywhere, everywhere, 0.0f};
}

Eigen::Matrix3d RoundedBox::axes() const {
  Eigen::Matrix3d all;
  for (int i = 0; i < 3; ++i) all.row(i) = rows[static_cast<std::size_t>(i)].head<3>().cast<double>();
  return all;
}

double support_along(const Eigen::Vector3d& direction, const RoundedBox& box) {
  return direction.dot(box.middle()) + (box.axes().transpose() * direction).cwiseAbs().dot(box.half_edges());
}

double squared_distance(const Eigen::Vector3d& point, const RoundedBox& box) {
  const Eigen::Vector3d off = box.axes().transpose() * (point - box.middle());
  return (off.cwiseAbs() - box.half_edges()).cwiseMax(0.0).squaredNorm();
}

BoxDistances::BoxDistances(const Eigen::Isometry3d& b_in_a, float reach_of_a, float reach_of_b)
    : offset_(rounded(b_in_a.translation())) {
  for (int i = 0; i < 3; ++i) {
    rows_[static_cast<std::size_t>(i)] = rounded(b_in_a.linear().row(i));
    columns_[static_cast<std::size_t>(i)] = rounded(b_in_a.linear().col(i));
  }
  rounding_ = 32.0f * unit * (reach_of_a + reach_of_b + offset_.norm());
  if (b_in_a.translation().lpNorm<1>() < farthest) return;
  offset_.setZero();
  rounding_ = everywhere;
}

RoundedBox BoxDistances::in_a(const RoundedBox& b) const {
  RoundedBox box;
  for (std::size_t i = 0; i < 3; ++i) box.rows[i] = combined(b.rows, rows_[i]);
  box.center = combined(columns_, b.center) + offset_;
  box.half = b.half;
  return box;
}

float BoxDistances::squared_bound(const RoundedBox& a, const RoundedBox& b, float enough) const {
  const Eigen::Vector4f offset = b.center - a.center;
  Eigen::Matrix4f turned = Eigen::Matrix4f::Zero();  // column i: the edges of b along edge i of a
  for (int i = 0; i < 3; ++i)
    turned.col(i) = b.rows[0] * a.rows[0][i] + b.rows[1] * a.rows[1][i] + b.rows[2] * a.rows[2][i];
  turned = turned.cwiseAbs().eval();
  const float along_b = squared_length_outside(combined(b.rows, offset), b.half + turned * a.half, rounding_);
  if (along_b > enough) return along_b;
  turned.transposeInPlace();
  return std::max(along_b, squared_length_outside(combined(a.rows, offset), a.half + turned * b.half, rounding_));
}

}  // namespace srmp
