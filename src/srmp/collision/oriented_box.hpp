#pragma once

#include <Eigen/Geometry>
#include <algorithm>

#include "srmp/geometry/primitive_bvh.hpp"

namespace srmp::detail {

/// A box, its edges along the columns of `axes`.
struct OrientedBox {
  Eigen::Matrix3d axes;
  Eigen::Vector3d center, half;
};

inline OrientedBox transformed(const Eigen::Isometry3d& by, const PrimitiveBvh::Node& node) {
  return {by.linear() * node.axes, by * node.center, node.half};
}

/// A lower bound of the squared distance of two boxes: along the axes of either.
template <class A, class B>
double squared_distance_bound(const A& a, const B& b) {
  const Eigen::Vector3d offset = b.center - a.center;
  const Eigen::Matrix3d rotation = a.axes.transpose() * b.axes, absolute = rotation.cwiseAbs();
  const Eigen::Vector3d along_a = a.axes.transpose() * offset, along_b = b.axes.transpose() * offset;
  const Eigen::Vector3d of_a = (along_a.cwiseAbs() - a.half - absolute * b.half).cwiseMax(0.0);
  const Eigen::Vector3d of_b = (along_b.cwiseAbs() - b.half - absolute.transpose() * a.half).cwiseMax(0.0);
  return std::max(of_a.squaredNorm(), of_b.squaredNorm());
}

/// Of the point from the box; 0 inside.
inline double squared_distance(const Eigen::Vector3d& point, const PrimitiveBvh::Node& node) {
  const Eigen::Vector3d off = node.axes.transpose() * (point - node.center);
  return (off.cwiseAbs() - node.half).cwiseMax(0.0).squaredNorm();
}

/// The largest product of a point of the box with the direction.
inline double support_along(const Eigen::Vector3d& direction, const PrimitiveBvh::Node& node) {
  return direction.dot(node.center) + (node.axes.transpose() * direction).cwiseAbs().dot(node.half);
}

}  // namespace srmp::detail
