#include "srmp/core/pose.hpp"

#include <cmath>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

Pose checked(const Eigen::Vector3d& p, double x, double y, double z, double w) {
  require_finite({p.data(), 3}, "pose position");
  const std::array<double, 4> xyzw{x, y, z, w};
  require_finite(xyzw, "pose quaternion");
  const Eigen::Quaterniond q(w, x, y, z);
  const double largest = q.coeffs().cwiseAbs().maxCoeff();  // squares of larger ones may be out of range
  if (const double length = largest > 1e-9 ? 1.0 : q.coeffs().stableNorm(); length < 1e-9)
    throw InvalidArgument("pose quaternion is " + std::string(length == 0.0 ? "zero" : "of length " + to_text(length)) +
                          "; a rotation needs a non-zero [x, y, z, w], e.g. [0, 0, 0, 1]");
  return {p, largest < 1e100 ? q.normalized() : Eigen::Quaterniond(q.coeffs() / largest).normalized()};
}

}  // namespace

Pose Pose::from_xyzw(const Eigen::Vector3d& p, const std::array<double, 4>& v) {
  return checked(p, v[0], v[1], v[2], v[3]);
}

Pose Pose::from_wxyz(const Eigen::Vector3d& p, const std::array<double, 4>& v) {
  return checked(p, v[1], v[2], v[3], v[0]);
}

Pose Pose::from_rpy(const Eigen::Vector3d& p, const Eigen::Vector3d& rpy) {
  require_finite({rpy.data(), 3}, "roll, pitch, yaw");
  const Eigen::Quaterniond q = Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX());
  return checked(p, q.x(), q.y(), q.z(), q.w());
}

Pose Pose::from_matrix(const Eigen::Matrix4d& matrix) {
  require_finite({matrix.data(), 16}, "pose matrix");
  const Eigen::Matrix3d r = matrix.topLeftCorner<3, 3>();
  if (!(r * r.transpose()).isIdentity(1e-6) || r.determinant() < 0 ||
      !matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1)))
    throw InvalidArgument(
        "pose matrix is not a rigid transform: the rotation must be orthonormal, the last row [0, 0, 0, 1]");
  const Eigen::Quaterniond q(r);
  return checked(matrix.topRightCorner<3, 1>(), q.x(), q.y(), q.z(), q.w());
}

Pose Pose::from_list(std::span<const double> v) {
  if (v.size() != 7)
    throw InvalidArgument("a pose is 7 numbers, x, y, z, qx, qy, qz, qw, but got " + std::to_string(v.size()));
  return checked({v[0], v[1], v[2]}, v[3], v[4], v[5], v[6]);
}

std::array<double, 7> Pose::to_list() const { return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}; }

Eigen::Vector3d Pose::rpy() const {
  const Eigen::Matrix3d r = q.toRotationMatrix();
  const double yaw = std::atan2(r(1, 0), r(0, 0)), pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
  const double sine = std::sin(yaw), cosine = std::cos(yaw);
  return {std::atan2(sine * r(0, 2) - cosine * r(1, 2), cosine * r(1, 1) - sine * r(0, 1)), pitch, yaw};
}

Eigen::Matrix4d Pose::matrix() const { return isometry().matrix(); }

Eigen::Isometry3d Pose::isometry() const {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = q.toRotationMatrix();
  transform.translation() = p;
  return transform;
}

Pose Pose::from_isometry(const Eigen::Isometry3d& transform) {
  return {transform.translation(), Eigen::Quaterniond(transform.linear()).normalized()};
}

Pose Pose::inverse() const { return {q.conjugate() * -p, q.conjugate()}; }

Pose Pose::operator*(const Pose& child) const { return {q * child.p + p, (q * child.q).normalized()}; }

}  // namespace srmp
