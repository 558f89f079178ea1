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

  /// What a box contains: the boxes of a node, or primitives.
  struct Part {
    std::uint32_t first{};  ///< number of the node, or of the first primitive
    std::uint32_t size{};   ///< primitives; 0: a node
    bool has_primitives() const { return size > 0; }
  };
  /// Up to four boxes, of which each contains primitives. Those beyond `size` are the last one again.
  struct Node {
    RoundedBoxes boxes;
    std::array<Part, RoundedBoxes::count> parts;
    std::array<float, RoundedBoxes::count> squared_sizes;  ///< of half the diagonal of each box
    int size{};
  };
  /// The box number RoundedBoxes::count * n + i is that of i in node n; box 0 contains all primitives.
  using BoxNumber = std::uint32_t;

  /// The triangles of a mesh, in the boxes of Coal's hierarchy. Throws NotSupported unless that is of type OBBRSS.
  explicit PrimitiveBvh(const coal::BVHModelBase& mesh);
  /// Cubes of a grid: a key k stands for [k * edge, (k + 1) * edge] along each axis, with `edge` > 0. Duplicates count
  /// once. Throws InvalidArgument when there are none.
  PrimitiveBvh(std::vector<std::array<std::int32_t, 3>> keys, double edge);

  const std::vector<Node>& nodes() const { return nodes_; }  ///< the first one's box is box 0
  RoundedBox box(BoxNumber number) const { return node_of(number).boxes[place_of(number)]; }
  RoundedBoxes repeated_box(BoxNumber number) const { return node_of(number).boxes.repeated(place_of(number)); }
  const Part& part(BoxNumber number) const { return node_of(number).parts[static_cast<std::size_t>(place_of(number))]; }
  float squared_size(BoxNumber number) const {
    return node_of(number).squared_sizes[static_cast<std::size_t>(place_of(number))];
  }
  const std::vector<Triangle>& triangles() const { return triangles_; }  ///< empty for cubes
  const std::vector<Eigen::Vector3d>& cubes() const { return cubes_; }   ///< centres; empty for triangles
  double edge() const { return edge_; }                                  ///< edge length of a cube
  float reach() const { return reach_; }                                 ///< the largest of any node's box [m]
  /// Are the primitives cubes?
  bool of_cubes() const { return triangles_.empty(); }

 private:
  struct BinaryNode;

  const Node& node_of(BoxNumber number) const { return nodes_[number / RoundedBoxes::count]; }
  static int place_of(BoxNumber number) { return static_cast<int>(number % RoundedBoxes::count); }
  Eigen::AlignedBox3d build_cubes(std::span<const std::uint64_t> codes, std::size_t done,
                                  std::vector<BinaryNode>& binary) const;
  void add_nodes(const std::vector<BinaryNode>& binary);
  void add_node(const std::vector<BinaryNode>& binary, std::span<const std::uint32_t> members);

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3d> cubes_;
  double edge_{};
  float reach_{};
};

/// The hierarchy of a mesh or an octree; nullptr for a convex solid. Throws NotSupported for other geometries.
std::shared_ptr<const PrimitiveBvh> make_primitive_bvh(const coal::CollisionGeometry& geometry);

}  // namespace srmp
