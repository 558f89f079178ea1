#include "srmp/collision/broad_phase.hpp"

#include <algorithm>

namespace srmp::detail {

void BoxBvh::build(const std::vector<Eigen::AlignedBox3d>& boxes) {
  nodes_.clear();
  if (boxes.empty()) return;
  std::vector<Leaf> leaves;
  leaves.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) leaves.push_back({boxes[i].center(), static_cast<std::int32_t>(i)});
  nodes_.reserve(2 * boxes.size());
  build(boxes, leaves);
}

std::int32_t BoxBvh::build(const std::vector<Eigen::AlignedBox3d>& boxes, std::span<Leaf> leaves) {
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  if (leaves.size() == 1) {
    nodes_.back().body = leaves[0].body;
    nodes_.back().box = boxes[static_cast<std::size_t>(leaves[0].body)];
    return id;
  }
  Eigen::AlignedBox3d middles;
  for (const Leaf& leaf : leaves) middles.extend(leaf.center);
  Eigen::Index axis = 0;
  middles.sizes().maxCoeff(&axis);
  const std::size_t half = leaves.size() / 2;
  std::nth_element(leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(half), leaves.end(),
                   [axis](const Leaf& a, const Leaf& b) {
                     const double x = a.center[axis], y = b.center[axis];
                     return x != y ? x < y : a.body < b.body;
                   });
  const std::int32_t left = build(boxes, leaves.first(half));
  const std::int32_t right = build(boxes, leaves.subspan(half));
  Node& node = nodes_[static_cast<std::size_t>(id)];
  node.box = nodes_[static_cast<std::size_t>(left)].box.merged(nodes_[static_cast<std::size_t>(right)].box);
  node.left = left;
  node.right = right;
  return id;
}

}  // namespace srmp::detail
