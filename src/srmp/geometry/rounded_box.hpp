#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

namespace srmp {

/// A box in single precision, enlarged by more than it was rounded: for bounds of many distances. It contains the
/// original, and its edges are orthogonal to about 1e-7.
struct RoundedBox {
  Eigen::Matrix3f axes;  ///< columns: the directions of the edges
  Eigen::Vector3f center, half_extents;

  RoundedBox() = default;
  RoundedBox(const Eigen::Matrix3d& axes, const Eigen::Vector3d& center, const Eigen::Vector3d& half_extents);

  Eigen::Matrix3d axes3d() const { return axes.cast<double>(); }
  Eigen::Vector3d center3d() const { return center.cast<double>(); }
  Eigen::Vector3d half_extents3d() const { return half_extents.cast<double>(); }
  /// No point of the box is farther from the origin [m].
  float reach() const { return center.norm() + half_extents.norm(); }
  /// Of half its diagonal.
  float squared_size() const { return half_extents.squaredNorm(); }
};

/// Four boxes, component by component: what is computed for all of them takes as many instructions as for one.
struct RoundedBoxes {
  static constexpr int count = 4;

  std::array<std::array<Eigen::Array4f, 3>, 3> axes;  ///< [k][i]: component k of the direction of edge i
  std::array<Eigen::Array4f, 3> center, half_extents;

  RoundedBoxes() = default;
  explicit RoundedBoxes(const RoundedBox& box);  ///< four times the same
  RoundedBox operator[](int i) const;
  void set(int i, const RoundedBox& box);
  /// One of them, four times.
  RoundedBoxes repeated(int i) const;
};

/// The largest product of a point of the box with the direction.
double support_along(const Eigen::Vector3d& direction, const RoundedBox& box);
/// Of the point from the box; 0 inside.
double squared_distance(const Eigen::Vector3d& point, const RoundedBox& box);

/// Bounds of distances between the boxes of two frames.
class BoxDistanceBounds {
 public:
  /// `b_to_a`: from the frame of the second boxes to that of the first; `reach`: the largest of any box, in its own
  /// frame.
  BoxDistanceBounds(const Eigen::Isometry3d& b_to_a, float reach_of_a, float reach_of_b);

  /// The second boxes in the frame of the first ones.
  RoundedBoxes in_a(const RoundedBoxes& b) const;
  /// The first boxes in the frame of the second ones.
  RoundedBoxes in_b(const RoundedBoxes& a) const;
  /// Lower bounds of the squared distances [m^2] of each first box to the second one at the same place, given in one
  /// frame; rounding included. Separating axes: the edges of either box. Where none separates the two, the bound is
  /// negative, the less the further they overlap [m] along each: so the ones that are deepest in each other come first.
  Eigen::Array4f squared_bounds(const RoundedBoxes& a, const RoundedBoxes& b) const;

 private:
  Eigen::Matrix3f rotation_, inverse_;
  Eigen::Vector3f offset_;
  float rounding_;  // more than all that is rounded can change a distance [m]
};

inline RoundedBox RoundedBoxes::operator[](int i) const {
  RoundedBox box;
  for (int k = 0; k < 3; ++k) {
    const auto component = static_cast<std::size_t>(k);
    for (int edge = 0; edge < 3; ++edge) box.axes(k, edge) = axes[component][static_cast<std::size_t>(edge)][i];
    box.center[k] = center[component][i];
    box.half_extents[k] = half_extents[component][i];
  }
  return box;
}

inline void RoundedBoxes::set(int i, const RoundedBox& box) {
  for (int k = 0; k < 3; ++k) {
    const auto component = static_cast<std::size_t>(k);
    for (int edge = 0; edge < 3; ++edge) axes[component][static_cast<std::size_t>(edge)][i] = box.axes(k, edge);
    center[component][i] = box.center[k];
    half_extents[component][i] = box.half_extents[k];
  }
}

inline RoundedBoxes RoundedBoxes::repeated(int i) const {
  RoundedBoxes one;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t edge = 0; edge < 3; ++edge) one.axes[k][edge] = Eigen::Array4f::Constant(axes[k][edge][i]);
    one.center[k] = Eigen::Array4f::Constant(center[k][i]);
    one.half_extents[k] = Eigen::Array4f::Constant(half_extents[k][i]);
  }
  return one;
}

inline RoundedBoxes::RoundedBoxes(const RoundedBox& box) {
  set(0, box);
  *this = repeated(0);
}

namespace detail {

using Vectors = std::array<Eigen::Array4f, 3>;  // four, component by component

/// Turned, with other centres: `center` turned too. Not a product of matrices, which uses fused multiply-adds where
/// there are, so that the bits would differ.
inline RoundedBoxes turned(const RoundedBoxes& boxes, const Vectors& center, const Eigen::Matrix3f& rotation) {
  RoundedBoxes result;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const float x = rotation(row, 0), y = rotation(row, 1), z = rotation(row, 2);
    for (std::size_t i = 0; i < 3; ++i)
      result.axes[k][i] = x * boxes.axes[0][i] + y * boxes.axes[1][i] + z * boxes.axes[2][i];
    result.center[k] = x * center[0] + y * center[1] + z * center[2];
  }
  result.half_extents = boxes.half_extents;
  return result;
}

}  // namespace detail

inline RoundedBoxes BoxDistanceBounds::in_a(const RoundedBoxes& b) const {
  RoundedBoxes boxes = detail::turned(b, b.center, rotation_);
  for (std::size_t k = 0; k < 3; ++k) boxes.center[k] += offset_[static_cast<Eigen::Index>(k)];
  return boxes;
}

inline RoundedBoxes BoxDistanceBounds::in_b(const RoundedBoxes& a) const {
  return detail::turned(a, {a.center[0] - offset_[0], a.center[1] - offset_[1], a.center[2] - offset_[2]}, inverse_);
}

inline Eigen::Array4f BoxDistanceBounds::squared_bounds(const RoundedBoxes& a, const RoundedBoxes& b) const {
  using Eigen::Array4f;
  const Array4f rounding = Array4f::Constant(rounding_), zero = Array4f::Zero();
  const detail::Vectors offset{b.center[0] - a.center[0], b.center[1] - a.center[1], b.center[2] - a.center[2]};
  Array4f gap = Array4f::Constant(-std::numeric_limits<float>::max());  // the widest
  const auto outside = [&](const RoundedBoxes& boxes, std::size_t edge, const Array4f& reach) -> Array4f {
    const Array4f along =
        boxes.axes[0][edge] * offset[0] + boxes.axes[1][edge] * offset[1] + boxes.axes[2][edge] * offset[2];
    const Array4f left = along.abs() - (reach + rounding);
    gap = gap.max(left);
    return left.max(zero).square();
  };
  Array4f along_a = zero;                    // squared distances
  detail::Vectors reach_b = b.half_extents;  // how far either box reaches along an edge of b
  for (std::size_t i = 0; i < 3; ++i) {
    Array4f reach_a = a.half_extents[i];
    for (std::size_t j = 0; j < 3; ++j) {
      const Array4f cosine =
          (a.axes[0][i] * b.axes[0][j] + a.axes[1][i] * b.axes[1][j] + a.axes[2][i] * b.axes[2][j]).abs();
      reach_a += cosine * b.half_extents[j];
      reach_b[j] += cosine * a.half_extents[i];
    }
    along_a += outside(a, i, reach_a);
  }
  const Array4f along_b = outside(b, 0, reach_b[0]) + outside(b, 1, reach_b[1]) + outside(b, 2, reach_b[2]);
  return along_a.max(along_b) + gap.min(zero);
}

}  // namespace srmp
