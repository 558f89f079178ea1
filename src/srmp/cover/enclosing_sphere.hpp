#pragma once

#include <Eigen/Core>
#include <utility>

namespace srmp {

/// Moves a point towards the centre of the smallest sphere around others (Badoiu and Clarkson 2003: steps of decreasing
/// length towards the farthest one). `farthest(c)` returns the point that is farthest from c.
template <class Farthest>
Eigen::Vector3d approach_center(Eigen::Vector3d center, int steps, Farthest&& farthest) {
  for (int i = 1; i <= steps; ++i) center += (farthest(center) - center) / (i + 1);
  return center;
}

}  // namespace srmp
