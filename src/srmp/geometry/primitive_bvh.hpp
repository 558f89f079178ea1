#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace coal {
class BVHModelBase;
class CollisionGeometry;
}  // namespace coal

namespace srmp {

/// A geometry that is no convex solid, as convex pieces in a tree of boxes: the triangles of a mesh, or the cubes of a
/// cloud. In the geometry's frame. Const once built.
class PrimitiveBvh {
 public:
  using Triangle = std::array<Eigen::Vector3d, 3>;

  /// A box around pieces, its edges along the columns of `axes`. Its left child is the next node.
  struct Node {
    Eigen::Matrix3d axes{Eigen::Matrix3d::Identity()};
    Eigen::Vector3d center, half;
    std::uint32_t right{};          ///< right child
    std::uint32_t first{}, size{};  ///< pieces of a leaf; size 0: has children
  };

  /// The triangles of a mesh, in the boxes that Coal made for it. Throws NotSupported for another kind of tree.
  explicit PrimitiveBvh(const coal::BVHModelBase& mesh);
  /// `keys`: cells of a grid of cubes, [k * edge, (k + 1) * edge] along each axis; doubles count once.
  PrimitiveBvh(std::vector<std::array<std::int32_t, 3>> keys, double edge);

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }  ///< empty for cubes
  const std::vector<Eigen::Vector3d>& cubes() const { return cubes_; }   ///< middles; empty for triangles
  double edge() const { return edge_; }                                  ///< of the cubes
  bool of_cubes() const { return triangles_.empty(); }

 private:
  std::uint32_t build_cubes(std::span<const std::uint64_t> codes, std::size_t done);

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3d> cubes_;
  double edge_{};
};

/// The pieces of a mesh; nullptr for a convex solid. Throws NotSupported for other geometries.
std::shared_ptr<const PrimitiveBvh> make_primitive_bvh(const coal::CollisionGeometry& geometry);

}  // namespace srmp
