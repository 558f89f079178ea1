#pragma once

#include <coal/narrowphase/gjk.h>
#include <coal/narrowphase/minkowski_difference.h>

#include <Eigen/Geometry>
#include <functional>

namespace srmp::detail {

inline coal::Transform3s coal_transform(const Eigen::Isometry3d& pose) { return {pose.linear(), pose.translation()}; }

/// A direction for GJK.
inline Eigen::Vector3d nonzero(const Eigen::Vector3d& guess) {
  return guess.squaredNorm() > 1e-12 ? guess : Eigen::Vector3d(1, 0, 0);
}

/// GJK of two convex solids as Coal's functors run it, without their allocations: set `difference`, then run().
struct Gjk {
  coal::details::MinkowskiDiff difference;
  coal::details::GJK search{coal::GJK_DEFAULT_MAX_ITERATIONS, coal::GJK_DEFAULT_TOLERANCE};
  std::function<void()> poll = [] {};  ///< called now and then
  unsigned steps{};

  Gjk();
  /// Counts a distance of solids, or of bounding boxes.
  void count_step() {
    constexpr unsigned steps_per_poll = 64;
    if (++steps % steps_per_poll == 0) poll();
  }
  /// The distance, 0 in contact; infinity when it exceeds `margin` + contact_distance.
  double run(const Eigen::Vector3d& guess, double margin,
             const coal::support_func_guess_t& hint = coal::support_func_guess_t::Zero());
  /// The distance of two planes across the direction that separate the solids; 0 where it separates none.
  double gap_across(const Eigen::Vector3d& direction) const;
  /// The least product of a point of the first solid with a direction, less the largest of one of the second with
  /// another; in the frame of the first.
  double gap_along(const Eigen::Vector3d& of_a, const Eigen::Vector3d& of_b) const;
};

}  // namespace srmp::detail
