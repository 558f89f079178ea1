#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace srmp::detail {

/// A box, its edges along the columns of `axes`: for single bounds, for which a RoundedBox would take longer.
struct OrientedBox {
  Eigen::Matrix3d axes;
  Eigen::Vector3d center, half;
};

/// A lower bound of the squared distance of two boxes: along the axes of either.
inline double squared_distance_bound(const OrientedBox& a, const OrientedBox& b) {
  const Eigen::Vector3d offset = b.center - a.center;
  const Eigen::Matrix3d rotation = a.axes.transpose() * b.axes, absolute = rotation.cwiseAbs();
  const Eigen::Vector3d along_a = a.axes.transpose() * offset, along_b = b.axes.transpose() * offset;
  const Eigen::Vector3d of_a = (along_a.cwiseAbs() - a.half - absolute * b.half).cwiseMax(0.0);
  const Eigen::Vector3d of_b = (along_b.cwiseAbs() - b.half - absolute.transpose() * a.half).cwiseMax(0.0);
  return std::max(of_a.squaredNorm(), of_b.squaredNorm());
}

}  // namespace srmp::detail
