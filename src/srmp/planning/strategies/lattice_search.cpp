#include "srmp/planning/strategies/lattice_search.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/strategies/plan_heuristics.hpp"
#include "srmp/planning/strategies/plan_lattices.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/wpase.hpp"

namespace srmp {

namespace {

using search::AnyHeuristic;

class LatticeSearch {
 public:
  LatticeSearch(PlanContext& context, const Endpoints& ends, BestPath& best)
      : context_(context), ends_(ends), best_(best), lattices_(context, ends), heuristics_(context, ends.start) {}

  void run() {
    choose_direction();
    Lattice lattice = lattices_.plain(backward_);
    const search::Result result = search(lattice);
    context_.checks.require_not_stopped();
    context_.statistics.states = lattice.size();
    context_.statistics.memory_bytes += lattice.memory() + result.statistics.memory;
    context_.count(result.statistics);
    context_.require_solved(result, lattices_.describe(backward_) + " holds no");
    if (best_.empty()) take(result, lattice);  // ARA* has handed in its own
  }

 private:
  /// A search out of a narrow place is easier than one into it: "auto" starts at the end with less clearance.
  void choose_direction() {
    backward_ = context_.common.direction == "backward";
    if (context_.common.direction != "auto") return;
    double at_goals = search::infinity;
    for (const Eigen::VectorXd& target : ends_.targets) at_goals = std::min(at_goals, clearance(target));
    backward_ = at_goals < clearance(ends_.start);
  }

  double clearance(const Eigen::VectorXd& q) {
    context_.stop_if_late("the choice of a direction");
    const auto pair = context_.checks.checker().nearest(q, context_.checks.workspace());
    return pair ? pair->distance : search::infinity;
  }

  search::Result search(Lattice& lattice) {
    const AnyHeuristic anchor = heuristics_.make(context_.common.heuristic, lattice);
    context_.stop_if_late("the construction of the heuristic");
    PlanStatistics& statistics = context_.statistics;
    const double shortening = statistics.shortcut_time_s;
    search::Result result;
    {
      const PhaseTimer timer(context_.deadline, statistics.search_time_s);
      const auto starts = lattice.starts();
      result = std::visit([&](const auto& options) { return run_search(lattice, starts, anchor, options); },
                          context_.problem.options);
    }
    statistics.search_time_s -= statistics.shortcut_time_s - shortening;  // ARA* shortens each path as it comes
    return result;
  }

  using Starts = std::vector<search::StateId>;

  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const AStar&) {
    return search::weighted_astar(lattice, starts, h, {.weight = 1.0}, context_.deadline);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const WAStar& options) {
    return search::weighted_astar(lattice, starts, h, {.weight = options.weight}, context_.deadline);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const ARAStar& options) {
    search::AraOptions ara;
    ara.initial_weight = std::max(options.weight, options.final_weight);
    ara.weight_delta = options.weight_delta;
    ara.final_weight = options.final_weight;
    ara.on_solution = [&](const search::Result& better) { return take(better, lattice); };
    return search::ara_star(lattice, starts, h, ara, context_.deadline);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const MHAStar& options) {
    std::vector<search::InadmissibleHeuristic> others;
    for (const std::string& name : options.inadmissible_heuristics) others.push_back(heuristics_.make(name, lattice));
    return search::mha_star(lattice, starts, h, others, {.w1 = options.w1, .w2 = options.w2}, context_.deadline);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const WPASE& options) {
    return search::wpase(lattice, starts, h,
                         {.weight = options.weight, .batch_size = static_cast<std::size_t>(options.batch_size)},
                         context_.deadline);
  }
  search::Result run_search(Lattice&, const Starts&, const AnyHeuristic&, const Auto&) {
    throw Error("internal error: 'auto' searches more than one lattice");
  }
  /// The planners for many robots.
  template <class Multi>
  search::Result run_search(Lattice&, const Starts&, const AnyHeuristic&, const Multi&) {
    throw NotSupported(planner_id(context_.problem.options) +
                       " plans for many robots, with plan_multi; make_planner another planner, such as 'wAstar', for "
                       "plan");
  }

  /// False: the user wants no better path.
  bool take(const search::Result& result, const Lattice& lattice) {
    FoundPath found = lattices_.path_of(result, lattice, backward_);
    if (!heuristics_.consistent(context_.common.heuristic)) found.lower = 0.0;  // the search's bound means nothing
    return best_.take(std::move(found), context_.deadline);
  }

  PlanContext& context_;
  const Endpoints& ends_;
  BestPath& best_;
  PlanLattices lattices_;
  PlanHeuristics heuristics_;
  bool backward_{false};
};

}  // namespace

void search_lattice(PlanContext& context, const Endpoints& ends, BestPath& best) {
  LatticeSearch(context, ends, best).run();
}

}  // namespace srmp
