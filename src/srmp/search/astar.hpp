#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "srmp/search/weighted_search.hpp"

/// A* and weighted A* with lazily evaluated edges.
///
/// Papers: Hart, Nilsson, Raphael 1968 (A*); Pohl 1970 (weighted A*); Cohen, Phillips, Likhachev 2014, "Planning
/// Single-Arm Manipulations with N-Arm Robots" (lazy weighted A*).
/// Guarantee: cost <= bound * optimal cost, bound <= weight; no state is expanded twice, no edge evaluated twice.
/// `exhausted` means that no start reaches a goal.
/// Needs: a Graph (see graph.hpp) and a consistent heuristic: h(a) <= cost(a, b) + h(b) for every edge, with its lower
/// bound as cost, and h = 0 at goals. Infinity prunes the state. With an inconsistent heuristic a path is still found,
/// but the bound does not hold.
namespace srmp::search {

struct AstarOptions {
  double weight{1.0};  ///< >= 1; 1 is A*, more expands fewer states for costlier paths
};

/// One search in slices, from all `starts` (cost 0 each) to the nearest goal. Throws InvalidArgument for options,
/// starts, heuristic values and edge costs outside their contracts.
template <Graph G, Heuristic H>
class WeightedAstar : public ResumableSearch {
 public:
  /// Graph and heuristic outlive this.
  WeightedAstar(G& graph, std::span<const StateId> starts, H& heuristic, const AstarOptions& options)
      : weight_(options.weight), search_(graph, heuristic, options.weight, WeightedSearch<G, H>::Expand::once) {
    require_weight(options.weight, "weight");
    search_.add_starts(starts);
  }

  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) override {
    return search_.improve(deadline, expansions);
  }
  bool finished() const override { return search_.finished(); }
  Result result(std::optional<Status> stop) const override { return search_.result(weight_, stop); }
  bool solved() const override { return search_.solved(); }
  double cost() const override { return search_.cost(); }
  Statistics statistics() const override { return search_.statistics(); }

 private:
  double weight_;
  WeightedSearch<G, H> search_;
};

/// The whole search at once.
template <Graph G, Heuristic H>
Result weighted_astar(G& graph, std::span<const StateId> starts, H& heuristic, const AstarOptions& options,
                      const Deadline& deadline) {
  WeightedAstar<G, H> search(graph, starts, heuristic, options);
  const std::optional<Status> stop = search.improve(deadline, unlimited);
  return search.result(stop);
}

}  // namespace srmp::search
