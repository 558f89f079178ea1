#pragma once

#include "srmp/planning/obstacles/safe_intervals.hpp"

namespace srmp {

struct TimedAnswer {
  /// solved, exhausted (none was found), timed_out (also when `looks` were used up) or cancelled
  Status status{Status::exhausted};
  Trajectory motion;  ///< from time 0, waits included; proved apart from the others
  std::uint64_t expansions{};
  std::uint64_t edge_checks{};   ///< motions looked at
  std::uint64_t memory_bytes{};  ///< of the roadmap and the searches on it
};

/// How long to search.
struct TimedEffort {
  double before;         ///< [s] only motions that arrive sooner
  int roadmaps;          ///< 1 to 3: each has more points than the one before
  std::uint64_t& looks;  ///< that may be taken, at configurations among the others; less, afterwards
  const Deadline& deadline;
  const Deadline& improve_until;  ///< no later: time to prove what was found
};

/// A motion of one arm around others whose motions are known: moves from rest to rest, with waits between them, found
/// by SafeIntervals on roadmaps with more and more points; then moves become one, and begin sooner, where the whole is
/// still proved apart.
///
/// The motion is proved apart from the others between rows too, by Coal alone, and what was rounded from what stands
/// still. Not complete, nor the soonest there is.
TimedAnswer plan_in_time(const TimedTask& task, const TimedEffort& effort);

}  // namespace srmp
