#pragma once

#include <Eigen/Geometry>
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

}  // namespace srmp
