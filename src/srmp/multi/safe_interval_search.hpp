#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/timed_search.hpp"

namespace srmp::multi {

struct SafeIntervalSearchOptions {
  /// Of Agent::inadmissible_heuristic, >= 1: every second departure is the first by cost-to-come + this times the
  /// heuristic of where it leads. A large weight goes straight to the goal.
  double weight{50.0};
  /// The same for the other departures. A small weight leaves a place soon whose neighbours nearer to the goal are all
  /// blocked.
  double patient_weight{2.0};
  bool known_paths_only{false};                                              ///< see `known` below
  std::uint64_t max_evaluations{std::numeric_limits<std::uint64_t>::max()};  ///< departures checked
};

/// One agent's path to a goal where it can stay for good, that makes no move which one of `constraints`
/// forbids and has no conflict with the paths in `avoid`: safe-interval path planning (SIPP: Phillips, Likhachev 2011)
/// with lazily checked departures. A state is reached at most once in each interval of time during which the agent may
/// wait there, so that no two states differ by waits alone. A departure that is not free is tried again when what is in
/// its way has ended, so neither cost nor arrival is optimal, and nothing is proved where no path is found.
///
/// `known` (null: none) is a path of the same agent. The search is first restricted to it and to Agent::known_paths,
/// and only then goes to the whole graph.
TimedSearchResult safe_interval_search(World& world, std::size_t agent, std::span<const Constraint> constraints,
                                       std::span<const OtherPath> avoid, const TimedPath* known,
                                       const SafeIntervalSearchOptions& options, const Deadline& deadline);

}  // namespace srmp::multi
