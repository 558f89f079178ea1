#include "srmp/collision/broad_phase.hpp"

#include <algorithm>
#include <numeric>

namespace srmp::detail {

void BoxBvh::build(const std::vector<Eigen::AlignedBox3d>& boxes) {
  nodes_.clear();
  if (boxes.empty()) return;
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  nodes_.reserve(2 * boxes.size());
  build(boxes, order, {0, boxes.size()});
}

std::int32_t BoxBvh::build(const std::vector<Eigen::AlignedBox3d>& boxes, std::vector<std::size_t>& order,
                           Range range) {
  const auto [first, last] = range;
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d all, centers;
  for (std::size_t i = first; i < last; ++i) {
    all.extend(boxes[order[i]]);
    centers.extend(boxes[order[i]].center());
  }
  nodes_[static_cast<std::size_t>(id)].box = all;
  if (last - first == 1) {
    nodes_[static_cast<std::size_t>(id)].body = static_cast<std::int32_t>(order[first]);
    return id;
  }
  Eigen::Index axis = 0;
  centers.sizes().maxCoeff(&axis);
  const std::size_t middle = (first + last) / 2;
  const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  std::sort(at(first), at(last), [&](std::size_t a, std::size_t b) {
    const double x = boxes[a].center()[axis], y = boxes[b].center()[axis];
    return x != y ? x < y : a < b;
  });
  const std::int32_t left = build(boxes, order, {first, middle});
  const std::int32_t right = build(boxes, order, {middle, last});
  nodes_[static_cast<std::size_t>(id)].left = left;
  nodes_[static_cast<std::size_t>(id)].right = right;
  return id;
}

}  // namespace srmp::detail
