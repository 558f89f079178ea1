#include "srmp/planning/best_path.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

void BestPath::bound(double lower, const std::string& graph) {
  if (!context_.statistics.bound_graph.empty() && lower <= lower_ * (1.0 + 1e-9)) return;
  lower_ = lower;
  context_.statistics.bound_graph = graph;
}

bool BestPath::take(FoundPath found, const Deadline& until, const ShortcutOptions& effort) {
  if (context_.common.shortcut) found.waypoints = shortened(found.waypoints, until, effort);
  const double cost = context_.length(found.waypoints);
  PlanStatistics& statistics = context_.statistics;
  if (waypoints_.empty() || cost < statistics.path_cost_rad) {
    waypoints_ = std::move(found.waypoints);
    statistics.path_cost_rad = cost;
    statistics.goal_index = found.goal_index;
  }
  statistics.search_cost_rad =
      statistics.solutions.empty() ? found.cost : std::min(statistics.search_cost_rad, found.cost);
  return prove(found.lower, found.graph);
}

bool BestPath::prove(double lower, const std::string& graph) {
  bound(lower, graph);
  PlanStatistics& statistics = context_.statistics;
  const double cost = std::min(statistics.path_cost_rad, statistics.search_cost_rad);
  statistics.bound = cost <= lower_ ? 1.0 : lower_ > 0.0 ? cost / lower_ : search::infinity;
  const Solution now{context_.deadline.elapsed(), statistics.path_cost_rad, statistics.bound, statistics.bound_graph};
  std::vector<Solution>& known = statistics.solutions;
  if (!known.empty() && now.cost_rad >= known.back().cost_rad && now.bound >= known.back().bound) return true;
  known.push_back(now);
  const OnSolution& tell = context_.problem.on_solution;
  return !tell || tell(now, stack_waypoints(waypoints_));
}

std::vector<Eigen::VectorXd> BestPath::shortened(const std::vector<Eigen::VectorXd>& path, const Deadline& until,
                                                 ShortcutOptions options) {
  const PhaseTimer timer(context_.deadline, context_.statistics.shortcut_time_s);
  const auto is_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return context_.checks.is_motion_free(a, b);
  };
  options.continuous = context_.problem.limits.continuous;
  try {
    return unstack_waypoints(shortcut(stack_waypoints(path), is_free, until, options).waypoints);
  } catch (const MotionCheckStopped&) {
    return path;
  }
}

}  // namespace srmp
