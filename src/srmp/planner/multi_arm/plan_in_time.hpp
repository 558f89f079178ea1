#pragma once

#include "srmp/planner/multi_arm/safe_intervals.hpp"

namespace srmp {

struct TimedAnswer {
  Status status{Status::exhausted};  ///< solved, exhausted (none was found), timed_out or cancelled
  Trajectory motion;                 ///< from time 0, waits included; proved apart from the others
  std::uint64_t expansions{};
};

/// A motion of one arm around others whose motions are known: moves from rest to rest, with waits between them, found
/// by SafeIntervals on roadmaps with more and more points; then moves become one, and begin sooner, where the whole is
/// still proved apart. Only motions that arrive sooner than `before` [s]; with infinity, as many roadmaps are tried as
/// there are, else the first ones.
///
/// The motion is proved apart from the others between rows too, by Coal alone, and what was rounded from what stands
/// still. Not complete, nor the soonest there is.
TimedAnswer plan_in_time(const TimedTask& task, double before, const Deadline& deadline);

}  // namespace srmp
