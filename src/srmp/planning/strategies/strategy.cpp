#include "srmp/planning/strategies/strategy.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"

namespace srmp {

FoundPath attempt_in_rounds(const Strategies& strategies, double lower, double weight, const Deadline& deadline) {
  for (int round = 0;; ++round) {
    bool some_can_exhaust = false, all_exhausted = true;
    Attempt last;  // that says why there is no path
    for (const auto& strategy : strategies) {
      Attempt attempt = strategy->attempt({round, weight * lower}, deadline);
      lower = std::max(lower, attempt.lower);
      if (attempt.status == Status::solved) {
        attempt.found.lower = std::max(attempt.found.lower, lower);
        return std::move(attempt.found);
      }
      if (strategy->can_exhaust()) {
        some_can_exhaust = true;
        all_exhausted = all_exhausted && attempt.status == Status::exhausted;
      }
      if (!attempt.reason.empty()) last = std::move(attempt);
    }
    if (deadline.stop_requested() || (some_can_exhaust && all_exhausted)) throw PlanningError(last.status, last.reason);
  }
}

}  // namespace srmp
