#include "srmp/planning/solution_record.hpp"

#include <algorithm>
#include <limits>

namespace srmp {

bool record_solution(PlanStatistics& statistics, double lower, const Deadline& deadline) {
  const double cost = std::min(statistics.path_cost_rad, statistics.search_cost_rad);
  statistics.bound = cost <= lower ? 1.0 : lower > 0.0 ? cost / lower : std::numeric_limits<double>::infinity();
  std::vector<Solution>& known = statistics.solutions;
  while (!known.empty() && known.back().cost_rad < statistics.path_cost_rad) known.pop_back();
  if (!known.empty() && statistics.path_cost_rad >= known.back().cost_rad && statistics.bound >= known.back().bound)
    return false;
  known.push_back({deadline.elapsed(), statistics.path_cost_rad, statistics.bound, statistics.bound_graph});
  return true;
}

}  // namespace srmp
