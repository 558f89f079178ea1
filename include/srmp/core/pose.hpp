#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>

namespace srmp {

/// A rigid transform in SE(3): position `p` [m] and orientation `q` (unit quaternion) of a frame in its parent frame,
/// which is the world frame unless stated otherwise.
///
/// Quaternions are written [x, y, z, w] everywhere in this library. Build one with the named constructors, which refuse
/// NaN, infinity and zero quaternions with InvalidArgument, and normalise the rest.
struct Pose {
  Eigen::Vector3d p{Eigen::Vector3d::Zero()};            ///< [m]
  Eigen::Quaterniond q{Eigen::Quaterniond::Identity()};  ///< unit length

  /// Position [m] and quaternion [x, y, z, w].
  static Pose from_xyzw(const Eigen::Vector3d& p, const std::array<double, 4>& xyzw);
  /// Position [m] and quaternion [w, x, y, z].
  static Pose from_wxyz(const Eigen::Vector3d& p, const std::array<double, 4>& wxyz);
  /// Position [m] and fixed-axis roll, pitch, yaw [rad] as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll).
  static Pose from_rpy(const Eigen::Vector3d& p, const Eigen::Vector3d& rpy);
  /// A homogeneous matrix. Throws InvalidArgument unless the rotation is orthonormal to 1e-6 and right-handed.
  static Pose from_matrix(const Eigen::Matrix4d& matrix);
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  /// Seven numbers: x, y, z [m], qx, qy, qz, qw. Throws InvalidArgument for another count.
  static Pose from_list(std::span<const double> xyz_xyzw);
#endif

  std::array<double, 7> to_list() const;  ///< the numbers of from_list
  /// The roll, pitch, yaw [rad] of from_rpy, with pitch within ±pi/2. At its ends, where roll and yaw turn about one
  /// axis, the two together give the orientation.
  Eigen::Vector3d rpy() const;
  Eigen::Matrix4d matrix() const;  ///< homogeneous
  /// The pose as an Eigen transform.
  Eigen::Isometry3d isometry() const;
  /// Nothing is checked; the quaternion is normalised.
  static Pose from_isometry(const Eigen::Isometry3d& transform);

  Pose inverse() const;  ///< of the parent in this frame
  /// The pose of `child`, given in this frame, in the parent of this frame.
  Pose operator*(const Pose& child) const;
  /// The point [m], given in this frame, in the parent frame.
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return q * point + p; }
  /// Are all seven numbers equal? q and -q are not, though they are the same rotation.
  bool operator==(const Pose& other) const { return p == other.p && q.coeffs() == other.q.coeffs(); }
};

}  // namespace srmp
