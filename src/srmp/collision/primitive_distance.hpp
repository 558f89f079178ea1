#pragma once

#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "srmp/collision/distance_query.hpp"
#include "srmp/collision/gjk.hpp"

namespace srmp::detail {

/// The axes that separated primitives in the last runs of GJK. Neighbours of these primitives are often separated by
/// one of them too, which two projections show.
class SeparatingAxes {
 public:
  struct Axis {
    Eigen::Vector3d in_a, in_b;  // the unit vector from b to a, in the frame of each
    double offset;               // the distance along the axis of what is projected, where both projections are 0
  };

  void clear() { count_ = 0; }
  /// In place of the oldest one.
  void add(const Axis& axis) { axes_[count_++ % axes_.size()] = axis; }
  /// Is the distance along one of them, by this function of an axis, more than `limit`?
  template <class Distance>
  bool separate(double limit, Distance&& distance_along) const {
    const auto end = axes_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, axes_.size()));
    return std::any_of(axes_.begin(), end, [&](const Axis& axis) { return distance_along(axis) > limit; });
  }

 private:
  std::array<Axis, 3> axes_;
  std::size_t count_{};
};

/// A primitive of a BVH at a pose; null: all of a solid.
struct PlacedPrimitive {
  const PrimitiveBvh* tree{};
  std::size_t primitive{};
  const Eigen::Isometry3d* pose{};
};

/// Distances of two geometries of which at least one is many primitives: branch and bound over hierarchies of boxes, at
/// the end of it GJK. Once warm, nothing is allocated.
class PrimitiveDistance {
 public:
  /// `gjk` outlives this.
  explicit PrimitiveDistance(Gjk& gjk);

  /// As NarrowPhase::primitives().
  double find(const Placed& a, const Placed& b, const PrimitiveQuery& query);

 private:
  class Found;
  class Shape;
  /// Two boxes; beside a solid, `b` is 0.
  struct Open {
    float squared_distance_bound;
    PrimitiveBvh::BoxNumber a, b;
  };
  /// What GJK found of a solid and a box around primitives, with which it begins at the next box.
  struct NearBox {
    explicit NearBox(const Eigen::Vector3d& guess) : ray(guess) {}
    Eigen::Vector3d ray;                                                      // in the solid's frame
    coal::support_func_guess_t vertices{coal::support_func_guess_t::Zero()};  // hints
    Eigen::Vector3d point;                                                    // of the solid, in the tree's frame
  };

  void add_axis_of_solid(const coal::details::GJK& separated, const Eigen::Isometry3d& to_tree);
  void add_axis(const Eigen::Isometry3d& to_a);
  double solid_to_primitive(const Placed& solid, const PrimitiveBvh& tree, std::size_t primitive,
                            const Eigen::Isometry3d& to_tree, Shape& shape, double margin);
  bool is_beyond(const Placed& solid, const RoundedBox& box, const Eigen::Isometry3d& to_tree, double limit);
  bool is_kept_separated(const Eigen::Isometry3d& pose, const PlacedPrimitive& a, const PlacedPrimitive& b,
                         const StaysSeparated& stays_separated);
  double solid_to_primitives(const Placed& solid, const Placed& other, const PrimitiveQuery& query);
  double primitives_to_primitives(const Placed& a, const Placed& b, const PrimitiveQuery& query);
  bool is_near_left(const Found& found);
  void count_visit(Found& found);
  template <class Entry>
  void open_near(const PrimitiveBvh& tree, std::uint32_t node, const Eigen::Array4f& squared_bounds, double limit,
                 Entry&& entry);

  Gjk& gjk_;
  coal::details::GJK short_gjk_;
  std::vector<Open> open_;
  SeparatingAxes axes_;              // in this query
  int separation_queries_{};         // in this query
  std::optional<NearBox> last_box_;  // in this query
  coal::Box box_{1, 1, 1};
};

}  // namespace srmp::detail
