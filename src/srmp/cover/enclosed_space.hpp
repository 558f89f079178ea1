#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "srmp/geometry/triangle_bvh.hpp"

namespace srmp {

/// The part of space that cannot be reached from outside without crossing a triangle, on a voxel grid. A voxel is
/// either reachable, or cut by a triangle, or enclosed. Points are in the triangles' frame [m].
class EnclosedSpace {
 public:
  /// Encloses nothing.
  EnclosedSpace() = default;
  /// `voxel` [m] > 0 is the edge of a voxel. Holes that a sphere of radius `closing` [m] cannot pass count as closed.
  EnclosedSpace(const std::vector<Triangle>& triangles, double voxel, double closing = 0);

  bool encloses(const Eigen::Vector3d& point) const;  ///< Is the point in an enclosed voxel?
  bool cut(const Eigen::Vector3d& point) const;       ///< Is the point in a voxel that a triangle cuts?
  double voxel() const { return voxel_; }             ///< edge of a voxel [m]
  /// Is a voxel that the triangle's bounding box cuts, or a neighbour of one, reachable?
  bool reachable_near(const Triangle& triangle) const;
  /// The faces between reachable and enclosed voxels, as triangles: they close the holes.
  std::vector<Triangle> plugs() const;

 private:
  enum : char { unknown, surface, outside };  // unknown voxels are enclosed once the flood has ended
  std::size_t flat(const Eigen::Array3i& i) const {
    return (static_cast<std::size_t>(i[2]) * size_[1] + i[1]) * size_[0] + i[0];
  }
  void mark_surface(const std::vector<Triangle>& triangles);
  void roll_sphere(double closing);
  void flood(const std::vector<char>& barred);
  void spread(std::vector<std::size_t> frontier, const std::vector<char>& barred, int steps);
  std::vector<float> squared_distance(const std::function<bool(std::size_t)>& in) const;
  Eigen::Array3i index(const Eigen::Vector3d& point) const;
  char at(const Eigen::Array3i& i) const;

  Eigen::Vector3d origin_{Eigen::Vector3d::Zero()};
  double voxel_{1.0};
  Eigen::Array3i size_{0, 0, 0};
  std::vector<char> state_;
};

}  // namespace srmp
