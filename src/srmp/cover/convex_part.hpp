#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "srmp/core/placed_sphere.hpp"

namespace srmp {

/// A part of a solid that is to be covered: the convex hull of a few points [m], in the solid's frame. A sphere
/// contains it if and only if it contains the points.
using ConvexPart = std::vector<Eigen::Vector3d>;

inline bool contains(const PlacedSphere& sphere, const ConvexPart& part) {
  for (const Eigen::Vector3d& p : part)
    if ((p - sphere.center).squaredNorm() > sphere.radius * sphere.radius) return false;
  return true;
}

/// The smallest sphere around the mean of the part's points that contains the part.
PlacedSphere sphere_around(const ConvexPart& part);

/// Parts in blocks of neighbours. Most parts are inside of a sphere, or out of its reach, together with their block.
class PartBlocks {
 public:
  /// `parts` must outlive this.
  explicit PartBlocks(const std::vector<ConvexPart>& parts);

  /// Calls visit(k) for each part k that the sphere contains.
  template <class Visit>
  void for_each_contained(const PlacedSphere& sphere, Visit&& visit) const {
    for (const Block& block : blocks_) {
      const double distance = (block.around.center - sphere.center).norm();
      if (distance > sphere.radius + block.around.radius) continue;
      const bool all = distance + block.around.radius < sphere.radius * (1 - 1e-12);
      for (const std::size_t k : block.parts)
        if (all || contains(sphere, parts_[k])) visit(k);
    }
  }

 private:
  struct Block {
    PlacedSphere around;
    std::vector<std::size_t> parts;
  };
  void split(std::size_t* begin, std::size_t* end);

  const std::vector<ConvexPart>& parts_;
  std::vector<PlacedSphere> around_;  // by part
  std::vector<Block> blocks_;
};

}  // namespace srmp
