#pragma once

#include <cstddef>
#include <vector>

namespace srmp {

struct FarthestOptions {
  bool last_first{true};  ///< try the last waypoint before the others; false where little is gained by reaching it
};

/// The farthest waypoint of from + 1, ..., last for which can_reach(waypoint) is true, by bisection: what can be
/// reached along a path is nearly monotone, so few waypoints are tried, and one farther than the result may be missed.
/// from + 1 is taken to be reached without a check; from < last.
template <class CanReach>
std::size_t farthest_waypoint(std::size_t from, std::size_t last, CanReach&& can_reach,
                              const FarthestOptions& options = {}) {
  std::size_t reached = from + 1, blocked = last + 1;
  if (reached < last && options.last_first) (can_reach(last) ? reached : blocked) = last;
  while (reached + 1 < blocked) {
    const std::size_t middle = reached + (blocked - reached) / 2;
    (can_reach(middle) ? reached : blocked) = middle;
  }
  return reached;
}

/// From the first of the waypoints 0, ..., last on, from each to the farthest for which is_free(from, to) is true:
/// those where it stops, the first and the last among them.
template <class IsFree>
std::vector<std::size_t> skip_waypoints(std::size_t last, IsFree&& is_free) {
  std::vector<std::size_t> kept{0};
  while (kept.back() < last)
    kept.push_back(farthest_waypoint(kept.back(), last, [&](std::size_t to) { return is_free(kept.back(), to); }));
  return kept;
}

}  // namespace srmp
