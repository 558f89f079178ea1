#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/world.hpp"

namespace srmp::multi {

/// Another agent's way.
struct OtherPath {
  std::size_t agent{};
  const TimedPath* path{};
};

struct TimedSearchOptions {
  double bound{1.0};  ///< cost <= bound * optimal cost under the constraints, >= 1; infinity: no matter
  double low_level_weight{
      1.0};           ///< of Agent::guide, >= 1: states are taken up by cost-to-come + low_level_weight * guide
  double focal{1.0};  ///< >= 1: among states within this factor of the best, the one that meets fewest others
  std::uint64_t max_evaluations{std::numeric_limits<std::uint64_t>::max()};  ///< moves looked at
};

struct TimedSearchResult {
  /// solved, exhausted (no way under these constraints), timed_out (also for max_evaluations) or cancelled
  Status status{Status::exhausted};
  TimedPath path;
  double lower{};  ///< no way under the constraints costs less
  search::Statistics statistics;
};

/// One agent's way to a goal where it can rest for good: focal search (Pearl, Kim 1982) in its graph times steps.
///
/// - It makes no move that one of `constraints` (all its own) forbids, and meets none of `avoid`.
/// - It meets `others` as little as the options let it.
/// - `experience` (null: none) is a way of the same agent, found under fewer constraints: what still holds of it, from
///   its start on, is known from the outset (Shaoul, Mishani, Likhachev, Li 2024). It changes nothing of the guarantee.
/// - States are opened again when a cheaper way to them turns up, so that Agent::heuristic bounds all that is open.
TimedSearchResult timed_search(World& world, std::size_t agent, std::span<const Constraint> constraints,
                               std::span<const OtherPath> avoid, std::span<const OtherPath> others,
                               const TimedPath* experience, const TimedSearchOptions& options,
                               const Deadline& deadline);

}  // namespace srmp::multi
