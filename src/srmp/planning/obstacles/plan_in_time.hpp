#pragma once

#include "srmp/planning/obstacles/safe_intervals.hpp"

namespace srmp {

struct TimedResult {
  /// solved, exhausted (no motion was found), timed_out (also when the checks are used up) or cancelled
  Status status{Status::exhausted};
  Trajectory motion;  ///< from time 0, waits included; proved collision-free
  std::uint64_t expansions{};
  std::uint64_t edge_checks{};
  std::uint64_t memory_bytes{};  ///< of the roadmap and the searches on it
};

struct TimedBudget {
  double max_arrival;     ///< [s] only motions that arrive earlier
  int roadmaps;           ///< > 0: how many are tried, each with more vertices than the one before
  std::uint64_t& checks;  ///< of configurations against the other robots: those that are left, before and afterwards
  const Deadline& deadline;
  const Deadline& improve_until;  ///< earlier than `deadline`, so that time is left to prove what was found
};

struct PlanInTimeOptions {
  SafeIntervalOptions roadmap;
  /// Sampled vertices of the first roadmap, and how many times as many each further one adds: more find motions in
  /// narrower places, fewer find easy ones earlier.
  std::size_t first_vertices{128};
  std::size_t growth{4};
  /// Searches of one roadmap that are repeated because what they found could not be proved.
  int max_repairs{32};
  /// Rounds of improvements over all moves, and the gain [s; rad, prismatic joints m] below which there is none.
  int max_rounds{4};
  double min_gain{1e-6};
  /// CertifyOptions::gap_tolerance of a move among static obstacles: it has to be free, its clearance does not matter.
  double gap_tolerance{0.99};
};

/// A motion of one robot among others whose motions are known: moves, stationary at both ends, with waits between them,
/// found by SafeIntervals on roadmaps with more and more vertices. Moves are then merged, and begin earlier, where the
/// whole can still be proved.
///
/// The motion is proved collision-free with the other robots at all times, and its blended moves with static obstacles,
/// both by exact geometry. Not complete, and not the earliest there is. Deterministic for a given budget of checks.
TimedResult plan_in_time(const TimedTask& task, const TimedBudget& budget, const PlanInTimeOptions& options = {});

}  // namespace srmp
