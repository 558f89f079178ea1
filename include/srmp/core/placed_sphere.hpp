#pragma once

#include <Eigen/Core>

namespace srmp {

/// A sphere in the frame of the geometry that it belongs to.
struct PlacedSphere {
  Eigen::Vector3d center{Eigen::Vector3d::Zero()};  ///< [m]
  double radius{};                                  ///< [m]
};

}  // namespace srmp
