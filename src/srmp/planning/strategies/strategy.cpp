#include "srmp/planning/strategies/strategy.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/stopping.hpp"

namespace srmp {

FoundPath attempt_in_rounds(const Strategies& strategies, double lower, double weight, const Deadline& deadline,
                            const WorkUsedUp& used_up) {
  for (int round = 0;; ++round) {
    bool some_can_exhaust = false, all_exhausted = true;
    Attempt exhausted, unfinished;  // the last of either that says why there is no path
    for (const auto& strategy : strategies) {
      const double max_cost = std::isinf(weight) ? weight : weight * lower;  // infinity * 0 is NaN
      Attempt attempt = strategy->attempt({round, max_cost}, deadline);
      lower = std::max(lower, attempt.lower);
      if (attempt.status == Status::solved) {
        attempt.found.lower = std::max(attempt.found.lower, lower);
        return std::move(attempt.found);
      }
      if (attempt.of_all_paths) throw PlanningError(Status::exhausted, attempt.reason);
      if (strategy->can_exhaust()) {
        some_can_exhaust = true;
        all_exhausted = all_exhausted && attempt.status == Status::exhausted;
      }
      if (!attempt.reason.empty()) (attempt.status == Status::exhausted ? exhausted : unfinished) = std::move(attempt);
    }
    if (some_can_exhaust && all_exhausted) throw PlanningError(Status::exhausted, exhausted.reason);
    if (!deadline.stop_requested()) {
      const auto why = used_up ? used_up() : std::nullopt;
      if (why) throw PlanningError(Status::timed_out, *why);
      continue;
    }
    const Status why = stop_status(deadline).value_or(Status::timed_out);
    // An attempt may have ended earlier than the plan, for another reason.
    const bool explains = !unfinished.reason.empty() && unfinished.status == why;
    throw PlanningError(why,
                        explains ? unfinished.reason : "the plan was stopped before all of its searches had ended");
  }
}

}  // namespace srmp
