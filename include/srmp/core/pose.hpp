#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>

namespace srmp {

/// A rigid transform: position `p` [m] and unit quaternion `q`, of a frame in its parent (the world, unless said
/// otherwise).
///
/// Quaternions are written [x, y, z, w] everywhere in this library. Build one with the named constructors, which refuse
/// NaN, infinity and zero quaternions with InvalidArgument, and normalise the rest.
struct Pose {
  Eigen::Vector3d p{Eigen::Vector3d::Zero()};
  Eigen::Quaterniond q{Eigen::Quaterniond::Identity()};

  static Pose from_xyzw(const Eigen::Vector3d& p, const std::array<double, 4>& xyzw);
  static Pose from_wxyz(const Eigen::Vector3d& p, const std::array<double, 4>& wxyz);
  /// Fixed-axis roll, pitch, yaw [rad] as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll).
  static Pose from_rpy(const Eigen::Vector3d& p, const Eigen::Vector3d& rpy);
  /// A homogeneous matrix; the rotation must be orthonormal to 1e-6.
  static Pose from_matrix(const Eigen::Matrix4d& matrix);
  /// Seven numbers: x, y, z, qx, qy, qz, qw.
  static Pose from_list(std::span<const double> xyz_xyzw);

  std::array<double, 7> to_list() const;
  Eigen::Matrix4d matrix() const;
  Eigen::Isometry3d isometry() const;
  static Pose from_isometry(const Eigen::Isometry3d& transform);

  Pose inverse() const;
  Pose operator*(const Pose& child) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return q * point + p; }
};

}  // namespace srmp
