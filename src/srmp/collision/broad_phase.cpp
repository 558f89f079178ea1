#include "srmp/collision/broad_phase.hpp"

#include <algorithm>
#include <numeric>

namespace srmp::detail {

void BoxBvh::build(const std::vector<Eigen::AlignedBox3d>& boxes) {
  nodes_.clear();
  if (boxes.empty()) return;
  std::vector<Eigen::Vector3d> centers;
  centers.reserve(boxes.size());
  for (const Eigen::AlignedBox3d& box : boxes) centers.push_back(box.center());
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  nodes_.reserve(2 * boxes.size());
  build(boxes, centers, order);
}

std::int32_t BoxBvh::build(const std::vector<Eigen::AlignedBox3d>& boxes, const std::vector<Eigen::Vector3d>& centers,
                           std::span<std::size_t> order) {
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  if (order.size() == 1) {
    nodes_.back().box = boxes[order[0]];
    nodes_.back().body = static_cast<std::int32_t>(order[0]);
    return id;
  }
  Eigen::AlignedBox3d middles;
  for (const std::size_t i : order) middles.extend(centers[i]);
  Eigen::Index axis = 0;
  middles.sizes().maxCoeff(&axis);
  const std::size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](std::size_t a, std::size_t b) {
                     const double x = centers[a][axis], y = centers[b][axis];
                     return x != y ? x < y : a < b;
                   });
  const std::int32_t left = build(boxes, centers, order.first(half));
  const std::int32_t right = build(boxes, centers, order.subspan(half));
  Node& node = nodes_[static_cast<std::size_t>(id)];
  node.box = nodes_[static_cast<std::size_t>(left)].box.merged(nodes_[static_cast<std::size_t>(right)].box);
  node.left = left;
  node.right = right;
  return id;
}

}  // namespace srmp::detail
