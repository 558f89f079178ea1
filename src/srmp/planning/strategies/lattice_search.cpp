#include "srmp/planning/strategies/lattice_search.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/wpase.hpp"

namespace srmp {

using search::AnyHeuristic;

Attempt LatticeSearch::attempt(const AttemptBudget&, const Deadline&) {
  choose_direction();
  Lattice lattice = lattices_.plain(backward_);
  const search::Result result = search(lattice);
  context_.checks.require_not_stopped();
  context_.statistics.states = lattice.size();
  context_.statistics.memory_bytes += lattice.memory() + result.statistics.memory;
  context_.count(result.statistics);
  if (result.status != Status::solved)
    return {.status = result.status,
            .reason = context_.no_path_sentence(result, lattices_.describe(backward_) + " holds no")};
  return {.status = Status::solved, .found = found_path(result, lattice)};
}

/// A search out of a narrow place is easier than one into it: "auto" starts at the end with less clearance.
void LatticeSearch::choose_direction() {
  backward_ = context_.common.direction == "backward";
  if (context_.common.direction != "auto") return;
  double at_goals = search::infinity;
  for (const Eigen::VectorXd& target : endpoints_.targets) at_goals = std::min(at_goals, clearance(target));
  backward_ = at_goals < clearance(endpoints_.start);
}

double LatticeSearch::clearance(const Eigen::VectorXd& q) {
  context_.stop_if_late("the choice of a direction");
  return context_.checks.checker().clearance(q, context_.checks.workspace());
}

FoundPath LatticeSearch::found_path(const search::Result& result, const Lattice& lattice) const {
  FoundPath found = lattices_.path_of(result, lattice, backward_);
  if (!lattices_.heuristics().consistent(context_.common.heuristic))
    found.lower = 0.0;  // the search's bound means nothing
  return found;
}

search::Result LatticeSearch::search(Lattice& lattice) {
  const AnyHeuristic heuristic = lattices_.heuristics().make(context_.common.heuristic, lattice);
  context_.stop_if_late("the construction of the heuristic");
  PlanStatistics& statistics = context_.statistics;
  const double shortening = statistics.shortcut_time_s;
  search::Result result;
  {
    const PhaseTimer timer(context_.deadline, statistics.search_time_s);
    result = run_search(lattice, heuristic);
  }
  statistics.search_time_s -= statistics.shortcut_time_s - shortening;  // ARA* shortens each path as it comes
  return result;
}

search::Result LatticeSearch::run_search(Lattice& lattice, const AnyHeuristic& heuristic) {
  const std::vector<search::StateId> starts = lattice.starts();
  const Deadline& deadline = context_.deadline;
  if (std::holds_alternative<AStar>(context_.options))
    return search::weighted_astar(lattice, starts, heuristic, {.weight = 1.0}, deadline);
  if (const auto* options = std::get_if<WAStar>(&context_.options))
    return search::weighted_astar(lattice, starts, heuristic, {.weight = options->weight}, deadline);
  if (const auto* options = std::get_if<ARAStar>(&context_.options)) {
    search::AraOptions ara;
    ara.initial_weight = std::max(options->weight, options->final_weight);
    ara.weight_delta = options->weight_delta;
    ara.final_weight = options->final_weight;
    ara.on_solution = [&](const search::Result& better) { return best_.take(found_path(better, lattice), deadline); };
    return search::ara_star(lattice, starts, heuristic, ara, deadline);
  }
  if (const auto* options = std::get_if<MHAStar>(&context_.options)) {
    std::vector<search::InadmissibleHeuristic> others;
    for (const std::string& name : options->inadmissible_heuristics)
      others.push_back(lattices_.heuristics().make(name, lattice));
    return search::mha_star(lattice, starts, heuristic, others, {.w1 = options->w1, .w2 = options->w2}, deadline);
  }
  if (const auto* options = std::get_if<WPASE>(&context_.options))
    return search::wpase(lattice, starts, heuristic,
                         {.weight = options->weight, .batch_size = static_cast<std::size_t>(options->batch_size)},
                         deadline);
  throw NotSupported(planner_id(context_.options) +
                     " plans for many robots, with plan_multi; make_planner another planner, such as 'wAstar', for "
                     "plan");
}

}  // namespace srmp
