#pragma once

// The geometry behind sphere_cover.hpp; internal.

#include <Eigen/Geometry>
#include <functional>
#include <limits>

#include "srmp/cover/sphere_cover.hpp"

namespace srmp {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Bounding-box tree over triangles: nearest point, and crossings of a ray.
class TriangleTree {
 public:
  TriangleTree() = default;
  explicit TriangleTree(std::vector<Triangle> triangles);

  bool empty() const { return triangles_.empty(); }
  struct Nearest {
    Eigen::Vector3d point;
    double distance{std::numeric_limits<double>::infinity()};
  };
  /// Nearest point of any triangle; gives up on triangles farther than `limit`.
  Nearest nearest(const Eigen::Vector3d& point, double limit = std::numeric_limits<double>::infinity()) const;
  /// How many triangles the ray from `point` along `direction` crosses.
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

/// Which part of space cannot be reached from outside without crossing a triangle, on a voxel grid.
class EnclosedSpace {
 public:
  EnclosedSpace() = default;
  /// Holes that a sphere of radius `closing` [m] cannot pass count as shut.
  EnclosedSpace(const std::vector<Triangle>& triangles, double voxel, double closing = 0);

  bool encloses(const Eigen::Vector3d& point) const;  ///< in a voxel that is neither reachable nor cut
  bool cut(const Eigen::Vector3d& point) const;       ///< in a voxel that holds a piece of a triangle
  double voxel() const { return voxel_; }
  bool reachable_near(const Triangle& piece) const;  ///< is a reachable voxel next to it?
  /// The faces between reachable and enclosed voxels: where holes are shut.
  std::vector<Triangle> plugs() const;

 private:
  enum : char { unknown, surface, outside };
  std::size_t flat(const Eigen::Array3i& i) const {
    return (static_cast<std::size_t>(i[2]) * size_[1] + i[1]) * size_[0] + i[0];
  }
  void flood(const std::vector<char>& barred);
  void spread(std::vector<std::size_t> frontier, const std::vector<char>& barred, int steps);
  /// Squared distance in voxels to the nearest voxel that is `in`.
  std::vector<float> squared_distance(const std::function<bool(std::size_t)>& in) const;
  Eigen::Array3i index(const Eigen::Vector3d& point) const;
  char at(const Eigen::Array3i& i) const;

  Eigen::Vector3d origin_{Eigen::Vector3d::Zero()};
  double voxel_{1.0};
  Eigen::Array3i size_{0, 0, 0};
  std::vector<char> state_;
};

struct CoverSolid::Impl {
  // Convex solids: contained in { n_i . x <= h_i } for unit n_i; inner offsets for rounding in nearly convex meshes.
  bool convex{false};
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> normals;
  Eigen::VectorXd offsets;        // outer: the solid's support, so the polytope contains the solid
  Eigen::VectorXd inner_offsets;  // inner: the polytope of these is contained in the solid
  /// Exact depth of curved convex solids (cylinder, cone); polytopes need none.
  std::function<double(const Eigen::Vector3d&)> curved_depth;

  std::vector<Triangle> triangles;  // the surface; of curved solids a polygonal stand-in that candidates start from
  Vertices vertices;                // corners; of curved solids those of the stand-in
  Eigen::AlignedBox3d box;

  // Meshes.
  bool closed{false};       // every edge has an even number of triangles: a ray's crossings tell inside from outside
  TriangleTree all, outer;  // outer: with the plugs of holes
  EnclosedSpace enclosed;   // what a cover must hold
  EnclosedSpace filled;     // what a cover may hold: that and what lies behind holes

  // Exact answers.
  enum class Kind { general, sphere, capsule } kind{Kind::general};
  double radius{}, length{};

  bool is_odd(const Eigen::Vector3d& point) const;         // surely between walls of a closed mesh
  double depth(const Eigen::Vector3d& point) const;        // may be slightly too large for nearly convex meshes
  double inner_depth(const Eigen::Vector3d& point) const;  // never too large; -inf when not surely inside
};

/// Calls `emit` for pieces of the triangle whose longest edge is at most `edge`.
void split_triangle(const Triangle& triangle, double edge, const std::function<void(const Triangle&)>& emit);

}  // namespace srmp
