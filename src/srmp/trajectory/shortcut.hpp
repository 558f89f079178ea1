#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Is the straight motion from one configuration to another free? (Continuous joints go the short way.)
using MotionFree = std::function<bool(const Eigen::VectorXd& from, const Eigen::VectorXd& to)>;

struct ShortcutOptions {
  double min_gain{2e-3};         ///< > 0: an attempt that cannot save this fraction of the path's length is not made
  int max_rounds{10};            ///< >= 0 passes over the corners; 0 = only skip waypoints
  int halvings{4};               ///< >= 1: how finely a corner's new position is searched (attempts a direction)
  double pull_gain{5e-3};        ///< > 0: the same as min_gain for pulling corners, which takes two checks an attempt
  double cut_gain{2e-2};         ///< > 0: fraction of the length that must be saved for a corner to become two
  std::vector<bool> continuous;  ///< joints that wrap round; empty = none
};

struct ShortcutResult {
  RowMatrix waypoints;     ///< continuous joints unwrapped, from the first row on
  double length_before{};  ///< path_length [rad, prismatic joints m]
  double length_after{};
  std::size_t checks{};  ///< calls of MotionFree
  bool finished{true};   ///< false: the deadline ended it early
};

/// Makes a path shorter by moving along straight lines wherever MotionFree allows, without any randomness: the straight
/// line from start to goal; then from each kept waypoint to the farthest visible one; then, round after round,
/// every corner is removed, slid along its segments or cut; when that no longer helps, pulled towards its chord.
/// Paths of several robots, which also depend on when each is where, have moves of their own (joint_shortcut.hpp); what
/// both do first is in skip_waypoints.hpp.
///
/// The result starts and ends where the path did and is never longer. Each of its segments is either one of the input
/// or was called free itself: nothing is inferred from longer or shorter motions. Stops at the deadline with the best
/// path so far. Input segments are taken to be free. Throws InvalidArgument for an empty path, NaN, options out of
/// range, or a continuous joint that does not go the short way.
ShortcutResult shortcut(ConstRows waypoints, const MotionFree& is_free, const Deadline& deadline = {},
                        const ShortcutOptions& options = {});

}  // namespace srmp
