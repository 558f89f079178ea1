#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <limits>
#include <vector>

namespace srmp {

/// Three corners [m], in the frame of the geometry that the triangle belongs to.
using Triangle = std::array<Eigen::Vector3d, 3>;

/// Bounding volume hierarchy (axis-aligned boxes) over triangles, for nearest points and ray crossings. Const once
/// built.
class TriangleBvh {
 public:
  /// Without triangles: nothing is near, and no ray crosses anything.
  TriangleBvh() = default;
  explicit TriangleBvh(std::vector<Triangle> triangles);

  bool empty() const { return triangles_.empty(); }
  struct Nearest {
    Eigen::Vector3d point;                                     ///< unset while the distance is infinite
    double distance{std::numeric_limits<double>::infinity()};  ///< [m]
  };
  /// The point of any triangle that is nearest to `point`. Triangles farther than `limit` [m] are ignored; the distance
  /// is infinite when no triangle is left.
  Nearest nearest(const Eigen::Vector3d& point, double limit = std::numeric_limits<double>::infinity()) const;
  /// The number of triangles that the ray from `point` along `direction` crosses. No component of `direction` may be 0.
  int crossings(const Eigen::Vector3d& point, const Eigen::Vector3d& direction) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int begin{}, end{};  // triangles, for leaves
    int left{-1}, right{-1};
  };
  int build(int begin, int end);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

/// Bisects the triangle at its longest edge until no edge is longer than `edge` [m], and calls `emit` for each part.
void split_triangle(const Triangle& triangle, double edge, const std::function<void(const Triangle&)>& emit);

}  // namespace srmp
