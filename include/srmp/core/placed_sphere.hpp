#pragma once

#include <Eigen/Core>

namespace srmp {

/// A sphere: centre [m] in the frame of the geometry it belongs to, radius [m].
struct PlacedSphere {
  Eigen::Vector3d center{Eigen::Vector3d::Zero()};
  double radius{};
};

}  // namespace srmp
