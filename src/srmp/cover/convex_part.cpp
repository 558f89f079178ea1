#include "srmp/cover/convex_part.hpp"

#include <algorithm>
#include <utility>

namespace srmp {

PlacedSphere sphere_around(const ConvexPart& part) {
  PlacedSphere sphere;
  for (const Eigen::Vector3d& p : part) sphere.center += p / static_cast<double>(part.size());
  for (const Eigen::Vector3d& p : part) sphere.radius = std::max(sphere.radius, (p - sphere.center).norm());
  sphere.radius *= 1 + 1e-9;
  return sphere;
}

PartBlocks::PartBlocks(const std::vector<ConvexPart>& parts) : parts_(parts) {
  for (const ConvexPart& part : parts) around_.push_back(sphere_around(part));
  std::vector<std::size_t> order(parts.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  if (!order.empty()) split(order.data(), order.data() + order.size());
}

void PartBlocks::split(std::size_t* begin, std::size_t* end) {
  Eigen::AlignedBox3d box;
  for (const std::size_t* k = begin; k != end; ++k) box.extend(around_[*k].center);
  if (end - begin <= 24) {
    Block block{{box.center(), 0}, {begin, end}};
    for (const std::size_t k : block.parts)
      block.around.radius =
          std::max(block.around.radius, (around_[k].center - block.around.center).norm() + around_[k].radius);
    blocks_.push_back(std::move(block));
    return;
  }
  int axis;
  box.sizes().maxCoeff(&axis);
  std::size_t* middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::size_t a, std::size_t b) {
    return std::pair(around_[a].center[axis], a) < std::pair(around_[b].center[axis], b);
  });
  split(begin, middle);
  split(middle, end);
}

}  // namespace srmp
