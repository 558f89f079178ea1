#include "srmp/planning/strategies/best_path.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/solution_record.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

void BestPath::bound(double lower, const std::string& graph) {
  if (!context_.statistics.bound_graph.empty() && lower <= lower_ * (1.0 + 1e-9)) return;
  lower_ = lower;
  context_.statistics.bound_graph = graph;
}

bool BestPath::take(FoundPath found, const Deadline& until, const ShortcutOptions& options) {
  RowMatrix& path = found.path.positions.front();
  if (context_.common.shortcut) path = shortened(path, until, options);
  const double cost = context_.length(unstack_waypoints(path));
  PlanStatistics& statistics = context_.statistics;
  statistics.search_cost_rad = empty() ? found.cost : std::min(statistics.search_cost_rad, found.cost);
  if (empty() || cost < statistics.path_cost_rad) {
    waypoints_ = std::move(path);
    statistics.path_cost_rad = cost;
    statistics.goal_index = found.goal_index;
    statistics.found_by = found.found_by;
  }
  return prove(found.lower, found.graph);
}

bool BestPath::take_if_promising(FoundPath found, const Deadline& until, double ratio, const ShortcutOptions& options) {
  double& search_cost = context_.statistics.search_cost_rad;
  search_cost = std::min(search_cost, found.cost);
  RowMatrix& path = found.path.positions.front();
  if (context_.common.shortcut) path = shortened(path, until, quick_shortcut);
  const double cost = context_.length(unstack_waypoints(path));
  return cost > ratio * context_.statistics.path_cost_rad || take(std::move(found), until, options);
}

bool BestPath::prove(double lower, const std::string& graph) {
  bound(lower, graph);
  PlanStatistics& statistics = context_.statistics;
  const bool news = record_solution(statistics, lower_, context_.deadline);
  const OnSolution& tell = context_.problem.on_solution;
  return !news || !tell || tell(statistics.solutions.back(), waypoints_);
}

bool BestPath::good_enough(double final_weight, double direct) const {
  const PlanStatistics& statistics = context_.statistics;
  // A shortened path may well be shorter than all of a lattice, so a bound of 1 there is no reason to stop.
  if (final_weight > 1.0 && statistics.bound <= final_weight) return true;
  return statistics.path_cost_rad <= direct * (1.0 + 1e-9);
}

RowMatrix BestPath::shortened(const RowMatrix& path, const Deadline& until, ShortcutOptions options) {
  const PhaseTimer timer(context_.deadline, context_.statistics.shortcut_time_s);
  const auto is_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return context_.checks.is_motion_free(a, b);
  };
  options.continuous = context_.task.limits.continuous;
  try {
    if (preferred_.size() > 0)
      return shortcut_keeping_clearance(path, preferred_, is_free,
                                        context_.task.constraints != nullptr || context_.common.clearance > 0.0, until,
                                        options);  // levels exempt other pairs of links than the clearance does
    return shortcut(path, is_free, until, options).waypoints;
  } catch (const MotionCheckStopped&) {
    return path;
  }
}

}  // namespace srmp
