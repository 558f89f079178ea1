#pragma once

#include "srmp/core/deadline.hpp"
#include "srmp/planning/statistics.hpp"

namespace srmp {

/// Takes path_cost_rad, search_cost_rad and bound_graph of the statistics as they are now: no path of that graph costs
/// less than `lower` (0: nothing is proven). Sets `bound`, and appends to `solutions` when cost or bound are better
/// than those of the last one; solutions that the returned path no longer reaches are taken back. True: something was
/// appended.
bool record_solution(PlanStatistics& statistics, double lower, const Deadline& deadline);

}  // namespace srmp
