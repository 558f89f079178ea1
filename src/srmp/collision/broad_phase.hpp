#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace srmp::detail {

/// A bounding-volume hierarchy of axis-aligned boxes, for bodies that do not move. Built once; const queries from any
/// number of threads.
class BoxBvh {
 public:
  void build(const std::vector<Eigen::AlignedBox3d>& boxes);

  /// Calls visit(index) → bool for every box within `radius` of `center`, in a fixed order, until one returns false.
  /// Returns false when stopped.
  template <class Visit>
  bool for_each_near(const Eigen::Vector3d& center, double radius, Visit&& visit) const {
    if (nodes_.empty()) return true;
    const double limit = radius * radius;
    std::array<std::int32_t, 64> stack;  // the tree is balanced: its depth is the logarithm of its size
    std::size_t size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const Node& node = nodes_[static_cast<std::size_t>(stack[--size])];
      if (node.box.squaredExteriorDistance(center) > limit) continue;
      if (node.body >= 0) {
        if (!visit(static_cast<std::size_t>(node.body))) return false;
        continue;
      }
      stack[size++] = node.right;
      stack[size++] = node.left;
    }
    return true;
  }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::int32_t left{-1}, right{-1};
    std::int32_t body{-1};  // of a leaf
  };
  /// A box to put into the tree.
  struct Leaf {
    Eigen::Vector3d center;
    std::int32_t body;
  };
  std::int32_t build(const std::vector<Eigen::AlignedBox3d>& boxes, std::span<Leaf> leaves);

  std::vector<Node> nodes_;
};

}  // namespace srmp::detail
