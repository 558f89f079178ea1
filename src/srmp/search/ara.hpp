#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "srmp/search/weighted_search.hpp"

/// ARA*: anytime repairing A* with lazily evaluated edges.
///
/// Papers: Likhachev, Gordon, Thrun 2003, "ARA*: Anytime A* with Provable Bounds on Sub-Optimality"; lazy edges as in
/// Cohen, Phillips, Likhachev 2014.
/// Guarantee: a sequence of paths whose costs never rise and whose bounds never rise, each cost <= bound * optimal
/// cost; within one weight no state is expanded twice, in the whole search no edge is evaluated twice. With enough time
/// the last bound is <= final_weight, for 1 the path is optimal. Needs: as weighted A* (astar.hpp).
namespace srmp::search {

struct AraOptions {
  double initial_weight{50.0};  ///< >= final_weight; of the first path
  double weight_delta{10.0};    ///< > 0; the weight falls by this, or straight to the proven bound when that is less
  double final_weight{1.0};     ///< >= 1; stop once this bound is proven
  /// Is called with each path that is cheaper or has a tighter bound than the one before; false stops the search. May
  /// be empty.
  std::function<bool(const Result&)> on_solution{};
};

/// When time runs out or the caller cancels, the best path so far is the result (`solved`, with its bound); timed_out
/// and cancelled mean that there was none yet.
template <Graph G, Heuristic H>
Result ara_star(G& graph, std::span<const StateId> starts, H& heuristic, const AraOptions& options,
                const Deadline& deadline) {
  require_weight(options.final_weight, "final_weight");
  require_weight(options.initial_weight, "initial_weight");
  require_positive(options.weight_delta, "weight_delta");
  if (options.initial_weight < options.final_weight) {
    throw InvalidArgument("initial_weight is " + to_text(options.initial_weight) + ", less than final_weight " +
                          to_text(options.final_weight));
  }
  using Search = WeightedSearch<G, H>;
  double weight = options.initial_weight;
  Search search(graph, heuristic, weight, Search::Expand::again);
  search.add_starts(starts);
  Result best;
  while (true) {
    const std::optional<Status> stop = search.improve(deadline);
    if (stop && best.status == Status::solved) {
      best.statistics = search.statistics();
      return best;
    }
    Result now = search.result(weight, stop);
    now.bound = std::min(now.bound, best.bound);  // proven for a costlier path, so for this one
    const bool improved = now.cost < best.cost || now.bound < best.bound;
    best = std::move(now);
    if (best.status != Status::solved) return best;
    if (improved && options.on_solution && !options.on_solution(best)) return best;
    if (best.bound <= options.final_weight) return best;
    weight = std::max(options.final_weight, std::min(weight - options.weight_delta, best.bound));
    search.next_round(weight);
  }
}

}  // namespace srmp::search
