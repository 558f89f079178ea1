#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "srmp/facade/moveit_goals.hpp"

namespace srmp {

namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr double kMaxAngle = 1.0;  // [rad] of tolerances that are bounded: the angles' bounds hold well below pi/2

/// A free axis of a constraint, and the axis of the end effector along it.
struct FreeAxis {
  Eigen::Index constraint{}, end_effector{};
};

/// Bounds of the intrinsic x, y, z angles of all rotation vectors with |components| <= v. With R = Rx(a) Ry(b) Rz(c):
/// sin b = R13, tan a = -R23 / R33, tan c = -R12 / R11, and Rodrigues' formula bounds the entries of R.
Eigen::Vector3d angle_bounds(const Eigen::Vector3d& v) {
  const double r13 = v.y() + 0.5 * v.x() * v.z(), r23 = v.x() + 0.5 * v.y() * v.z(), r12 = v.z() + 0.5 * v.x() * v.y();
  const double r33 = 1.0 - 0.5 * (v.x() * v.x() + v.y() * v.y()), r11 = 1.0 - 0.5 * (v.y() * v.y() + v.z() * v.z());
  const auto angle = [](double sine, double cosine) { return cosine > 0.0 ? std::atan(sine / cosine) : kNoLimit; };
  return {angle(r23, r33), r13 < 1.0 ? std::asin(r13) : kNoLimit, angle(r12, r11)};
}

/// `limit`, made smaller by a common factor until all rotation vectors within it have angles within `limit`.
Eigen::Vector3d within_angles(const Eigen::Vector3d& box, const Eigen::Vector3d& limit) {
  const auto fits = [&](double factor) { return (angle_bounds(factor * box).array() <= limit.array()).all(); };
  if (fits(1.0)) return box;
  double lower = 0.0, upper = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (lower + upper);
    (fits(middle) ? lower : upper) = middle;
  }
  return lower * box;
}

Eigen::Vector3d limits_of(const io::OrientationConstraint& constraint) {
  Eigen::Vector3d limit = constraint.tolerance;
  for (double& axis : limit)
    if (axis == 0.0) axis = least_rotation;
  return limit;
}

/// A free middle angle is none: it covers half of the turns about its axis only.
std::optional<FreeAxis> free_axis(const io::OrientationConstraint& constraint, const Eigen::Matrix3d& to_constraint,
                                  const Eigen::Vector3d& point) {
  for (const Eigen::Index axis : {2, 1, 0}) {
    if (constraint.tolerance[axis] < std::numbers::pi || (axis == 1 && !constraint.rotation_vector)) continue;
    for (Eigen::Index own = 0; own < 3; ++own) {
      const double beside = (point - point[own] * Eigen::Vector3d::Unit(own)).norm();
      if (std::abs(to_constraint(axis, own)) > 1.0 - 1e-9 && beside <= 1e-9) return FreeAxis{axis, own};
    }
  }
  return std::nullopt;
}

/// Half extents of the rotation vectors [rad] along the constraint's axes; of the free axis 1, a placeholder.
Eigen::Vector3d box_beside(const io::OrientationConstraint& constraint, Eigen::Index free) {
  const Eigen::Vector3d limit = limits_of(constraint);
  const Eigen::Index first = (free + 1) % 3, second = (free + 2) % 3;
  const double least = std::min({limit[first], limit[second], kMaxAngle}) / std::numbers::sqrt2;
  Eigen::Vector3d box = Eigen::Vector3d::Ones();
  if (constraint.rotation_vector) {
    // Beside a rotation by up to pi about the free axis, one by d across it turns the rotation vector by up to pi/2 d.
    box[first] = box[second] = least * 2.0 / std::numbers::pi;
  } else if (free == 0) {
    box[first] = box[second] = least;  // the angles after the free one are about axes that it has turned
  } else {
    const Eigen::Vector3d across(std::min(limit.x(), kMaxAngle), std::min(limit.y(), kMaxAngle), 0.0);
    box.head<2>() = within_angles(across, {limit.x(), limit.y(), kNoLimit}).head<2>();
  }
  return box;
}

}  // namespace

Eigen::Vector3d inner_box(const Eigen::Matrix3d& axes, const Eigen::Vector3d& half_extents) {
  const Eigen::Matrix3d reach = axes.cwiseAbs();
  const Eigen::Vector3d shadow = reach.transpose() * half_extents;
  return shadow * (half_extents.array() / (reach * shadow).array()).minCoeff();
}

bool allows_all(const io::OrientationConstraint& constraint) {
  const Eigen::Vector3d& tolerance = constraint.tolerance;
  const double middle = constraint.rotation_vector ? std::numbers::pi : std::numbers::pi / 2;
  return tolerance.x() >= std::numbers::pi && tolerance.y() >= middle && tolerance.z() >= std::numbers::pi;
}

Eigen::Vector3d rotation_tolerance(const io::OrientationConstraint& constraint, const Eigen::Matrix3d& to_constraint,
                                   const Eigen::Vector3d& point) {
  if (const auto free = free_axis(constraint, to_constraint, point)) {
    Eigen::Matrix3d axes = to_constraint;
    axes.row(free->constraint).setZero();
    axes.col(free->end_effector).setZero();
    axes(free->constraint, free->end_effector) = 1.0;
    Eigen::Vector3d tolerance = inner_box(axes, box_beside(constraint, free->constraint));
    tolerance[free->end_effector] = kNoLimit;
    return tolerance;
  }
  const Eigen::Vector3d limit = limits_of(constraint);
  if (constraint.rotation_vector) return inner_box(to_constraint, limit.cwiseMin(std::numbers::pi));
  return inner_box(to_constraint, within_angles(limit.cwiseMin(kMaxAngle), limit));
}

}  // namespace srmp
