#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "srmp/geometry/rounded_box.hpp"

namespace coal {
class BVHModelBase;
class CollisionGeometry;
}  // namespace coal

namespace srmp {

/// Bounding volume hierarchy over the convex primitives of a geometry that is not a convex solid: the triangles of a
/// mesh, or the cubes of a point cloud. In the geometry's frame [m]. Const once built.
class PrimitiveBvh {
 public:
  /// Three corners.
  using Triangle = std::array<Eigen::Vector3d, 3>;

  /// A box that contains primitives. Its left child is the next node.
  struct Node {
    RoundedBox box;
    std::uint32_t right{};          ///< right child
    std::uint32_t first{}, size{};  ///< primitives of a leaf; an inner node has size 0
  };

  /// The triangles of a mesh, in the boxes of Coal's hierarchy. Throws NotSupported unless that is of type OBBRSS.
  explicit PrimitiveBvh(const coal::BVHModelBase& mesh);
  /// Cubes of a grid: a key k stands for [k * edge, (k + 1) * edge] along each axis, with `edge` > 0. Duplicates count
  /// once. Throws InvalidArgument when there are none.
  PrimitiveBvh(std::vector<std::array<std::int32_t, 3>> keys, double edge);

  /// The root comes first.
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }  ///< empty for cubes
  const std::vector<Eigen::Vector3d>& cubes() const { return cubes_; }   ///< centres; empty for triangles
  double edge() const { return edge_; }                                  ///< edge length of a cube
  float reach() const { return reach_; }                                 ///< the largest of any node's box [m]
  /// Are the primitives cubes?
  bool of_cubes() const { return triangles_.empty(); }

 private:
  void set_box(std::uint32_t node, const RoundedBox& box);
  Eigen::AlignedBox3d build_cubes(std::span<const std::uint64_t> codes, std::size_t done);

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3d> cubes_;
  double edge_{};
  float reach_{};
};

/// The hierarchy of a mesh or an octree; nullptr for a convex solid. Throws NotSupported for other geometries.
std::shared_ptr<const PrimitiveBvh> make_primitive_bvh(const coal::CollisionGeometry& geometry);

}  // namespace srmp
