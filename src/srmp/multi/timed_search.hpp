#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/world.hpp"

namespace srmp::multi {

/// Another agent's path.
struct OtherPath {
  std::size_t agent{};
  const TimedPath* path{};
};

struct TimedSearchOptions {
  double bound{1.0};  ///< cost <= bound * optimal cost under the constraints, >= 1; infinity: any cost
  /// Of Agent::inadmissible_heuristic, >= 1: states are ordered by cost-to-come + low_level_weight * heuristic.
  double low_level_weight{1.0};
  double focal{1.0};  ///< >= 1: among states within this factor of the best, the one with the fewest conflicts
  std::uint64_t max_evaluations{std::numeric_limits<std::uint64_t>::max()};  ///< moves evaluated
};

struct TimedSearchResult {
  /// solved, exhausted (no path under these constraints), timed_out (also for max_evaluations) or cancelled
  Status status{Status::exhausted};
  TimedPath path;
  double lower{};  ///< no path under the constraints costs less
  search::Statistics statistics;
};

/// One agent's path to a goal where it can stay for good: focal search (Pearl, Kim 1982) in the product of its graph
/// and time.
///
/// - It makes no move that one of `constraints` forbids, and has no conflict with the paths in `avoid`. Moves that the
///   agent has to make are landmarks on its way: what is to go leads through them, and what comes too late is left out.
/// - It has as few conflicts with the paths in `others` as the options allow.
/// - `experience` (null: none) is a path of the same agent, found under fewer constraints: the part of it from the
///   start that is still valid is in OPEN from the outset (Shaoul, Mishani, Likhachev, Li 2024). The guarantee is the
///   same.
/// - States are reopened when a cheaper path to them is found, so that Agent::heuristic bounds all that is open.
TimedSearchResult timed_search(World& world, std::size_t agent, std::span<const Constraint> constraints,
                               std::span<const OtherPath> avoid, std::span<const OtherPath> others,
                               const TimedPath* experience, const TimedSearchOptions& options,
                               const Deadline& deadline);

}  // namespace srmp::multi
