#include "srmp/trajectory/path_constraint.hpp"

#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"

namespace srmp {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// A frame whose z axis has the direction.
Eigen::Quaterniond along(const Eigen::Vector3d& direction) {
  if (!direction.allFinite() || direction.norm() < 1e-9) return {0.0, 0.0, 0.0, 0.0};  // validate refuses it
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction);
}

/// Of unit length, so that normalising it again, as who reads it from a file does, changes no bit.
Eigen::Quaterniond normalised(Eigen::Quaterniond q) {
  if (!(q.norm() > 1e-9)) return q;  // validate refuses it
  for (int i = 0; i < 4; ++i) q.normalize();
  return q;
}

PathConstraint of_type(PathConstraintType type, const Pose& target) {
  PathConstraint constraint;
  constraint.type = type;
  constraint.target = {target.p, normalised(target.q)};
  return constraint;
}

void require_above_zero(const char* what, double value, double most) {
  if (value > 0.0 && value < most) return;
  throw InvalidArgument(std::string(what) + " is " + to_text(value) + "; it must be above 0 and " +
                        (std::isinf(most) ? "finite" : "below " + to_text(most)));
}

}  // namespace

std::string_view to_string(PathConstraintType type) {
  switch (type) {
    case PathConstraintType::cone: return "cone";
    case PathConstraintType::orientation: return "orientation";
    case PathConstraintType::pose: return "pose";
    case PathConstraintType::box: return "box";
    case PathConstraintType::plane: return "plane";
    case PathConstraintType::line: return "line";
    case PathConstraintType::distance: return "distance";
  }
  return "unknown";
}

PathConstraint PathConstraint::cone(const Eigen::Vector3d& axis, const Eigen::Vector3d& direction, double tolerance) {
  PathConstraint result = of_type(PathConstraintType::cone, {Eigen::Vector3d::Zero(), along(direction)});
  result.axis = axis.norm() > 1e-9 ? Eigen::Vector3d(axis.normalized()) : Eigen::Vector3d::Zero();
  result.tolerance = tolerance;
  return result;
}

PathConstraint PathConstraint::orientation(const Eigen::Quaterniond& target, const AxisTolerance& tolerance) {
  PathConstraint result = of_type(PathConstraintType::orientation, {Eigen::Vector3d::Zero(), target});
  result.rotation_tolerance = tolerance;
  return result;
}

PathConstraint PathConstraint::pose(const Pose& target, const AxisTolerance& position_tolerance,
                                    const AxisTolerance& rotation_tolerance) {
  PathConstraint result = of_type(PathConstraintType::pose, target);
  result.position_tolerance = position_tolerance;
  result.rotation_tolerance = rotation_tolerance;
  return result;
}

PathConstraint PathConstraint::box(const Eigen::Vector3d& size, const Pose& pose) {
  PathConstraint result = of_type(PathConstraintType::box, pose);
  result.position_tolerance = AxisTolerance(0.5 * size);
  return result;
}

PathConstraint PathConstraint::plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double tolerance) {
  PathConstraint result = of_type(PathConstraintType::plane, {point, along(normal)});
  result.tolerance = tolerance;
  return result;
}

PathConstraint PathConstraint::line(const Eigen::Vector3d& point, const Eigen::Vector3d& direction, double tolerance) {
  PathConstraint result = of_type(PathConstraintType::line, {point, along(direction)});
  result.tolerance = tolerance;
  return result;
}

PathConstraint PathConstraint::distance(const Eigen::Vector3d& centre, double min_distance, double max_distance) {
  PathConstraint result = of_type(PathConstraintType::distance, {centre, Eigen::Quaterniond::Identity()});
  result.min_distance = min_distance;
  result.max_distance = max_distance;
  return result;
}

void PathConstraint::validate() const {
  const std::string name = std::string(to_string(type));
  if (!target.p.allFinite() || !target.q.coeffs().allFinite() || !axis.allFinite() || !point.allFinite())
    throw InvalidArgument("a path constraint of type '" + name + "' has numbers that are not finite");
  if (target.q.norm() < 1e-9 || (type == PathConstraintType::cone && axis.norm() < 1e-9))
    throw InvalidArgument("a path constraint of type '" + name +
                          "' has a direction, an axis or a quaternion of length 0; it must point somewhere");
  const bool all_positions_free = position_tolerance.axes.array().isInf().all();
  const bool all_rotations_free = rotation_tolerance.axes.array().isInf().all();
  switch (type) {
    case PathConstraintType::cone: return require_above_zero("the tolerance of a cone [rad]", tolerance, M_PI);
    case PathConstraintType::plane: return require_above_zero("the tolerance of a plane [m]", tolerance, unbounded);
    case PathConstraintType::line: return require_above_zero("the tolerance of a line [m]", tolerance, unbounded);
    case PathConstraintType::distance:
      if (min_distance >= 0.0 && max_distance > min_distance && max_distance < unbounded) return;
      throw InvalidArgument("a distance is to stay between " + to_text(min_distance) + " m and " +
                            to_text(max_distance) + " m; the first must be 0 or above, the second above it and finite");
    case PathConstraintType::box: position_tolerance.validate("half the size of a box"); break;
    case PathConstraintType::orientation: rotation_tolerance.validate("rotation_tolerance"); break;
    case PathConstraintType::pose:
      position_tolerance.validate("position_tolerance");
      rotation_tolerance.validate("rotation_tolerance");
  }
  if ((type == PathConstraintType::orientation || all_positions_free) &&
      (type == PathConstraintType::box || all_rotations_free))
    throw InvalidArgument("a path constraint of type '" + name +
                          "' leaves every axis free; at least one must be bounded");
}

}  // namespace srmp
