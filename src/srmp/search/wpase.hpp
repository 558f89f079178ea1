#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "srmp/search/weighted_search.hpp"

/// wPA*SE: parallel weighted A* for slow edges, edge-based and lazy.
///
/// Papers: Phillips, Likhachev, Koenig 2014, "PA*SE: Parallel A* for Slow Expansions" (the independence check);
/// Mukherjee, Aine, Likhachev 2022, "ePA*SE: Edge-Based Parallel A* for Slow Evaluations".
/// What is parallel is the evaluation of edges: each round takes a batch of edges from OPEN, of a size that does not
/// depend on the number of threads, has the graph evaluate them in one call, and merges the costs in the order of the
/// batch, so the path is the same for any number of threads. While edges wait for their evaluation, a confirmed state
/// after them in OPEN may be expanded if it is independent of them: no path through a waiting state can lower its cost
/// by more than the weight.
/// Guarantee: cost <= bound * optimal cost, bound <= weight; no state is expanded twice, no edge evaluated twice.
/// Needs: as weighted A* (astar.hpp), and optionally a heuristic between pairs of states: pair(a, b) <= the cost of any
/// path from a to b. Without it h(a) - h(b) is used, a weaker bound.
namespace srmp::search {

struct WpaseOptions {
  double weight{1.0};  ///< >= 1
  /// Edges per round, >= 1; 1 is weighted A*. Best as many as the graph evaluates at once: a larger batch evaluates
  /// more edges that are not needed. The deadline is polled between rounds.
  std::size_t batch_size{4};
};

/// Lower bound of the cost of any path between two states; infinity when there is none.
template <class P>
concept PairHeuristic = requires(P& pair, StateId a, StateId b) {
  { pair(a, b) } -> std::convertible_to<double>;
};

/// Selects h(a) - h(b), which by consistency is a lower bound of the cost from a to b.
struct HeuristicDifference {};

/// One search in slices, from all `starts` (cost 0 each) to the nearest goal.
template <Graph G, Heuristic H, class P = HeuristicDifference>
  requires PairHeuristic<P> || std::same_as<P, HeuristicDifference>
class ParallelWeightedAstar : public ResumableSearch {
 public:
  /// Graph and heuristic outlive this.
  ParallelWeightedAstar(G& graph, std::span<const StateId> starts, H& heuristic, const WpaseOptions& options,
                        P pair = {})
      : search_(graph, heuristic, options.weight, WeightedSearch<G, H>::Expand::once),
        pair_(std::move(pair)),
        options_(options) {
    require_weight(options.weight, "weight");
    if (options.batch_size == 0) throw InvalidArgument("batch_size is 0, it must be at least 1");
    search_.add_starts(starts);
  }

  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) override {
    const std::uint64_t first = search_.expansions();
    while (!finished() && search_.expansions() - first < expansions) {
      const std::optional<Status> stop = collect(deadline);
      if (!stop && !search_.solved() && !batch_.empty()) search_.tree().evaluate(batch_);
      put_back();
      if (stop) return stop;
    }
    return std::nullopt;
  }

  bool finished() const override { return search_.open().empty() || search_.solved(); }
  Result result(std::optional<Status> stop) const override { return search_.result(options_.weight, stop); }
  bool solved() const override { return search_.solved(); }
  double cost() const override { return search_.cost(); }
  Statistics statistics() const override { return search_.statistics(); }

 private:
  /// Walks down OPEN: edges to evaluate go into the batch, independent confirmed states are expanded, all others wait.
  std::optional<Status> collect(const Deadline& deadline) {
    const std::size_t max_waiting = 4 * options_.batch_size;  // bounds the cost of a round
    batch_.clear();
    while (!search_.open().empty() && batch_.size() < options_.batch_size && waiting_.size() < max_waiting) {
      if (const auto stop = stop_status(deadline)) return stop;
      const OpenList::Entry entry = search_.open().pop();
      const bool confirmed = search_.table().confirmed(entry.state);
      if (confirmed && independent(entry.state)) {
        search_.visit(entry.state);
        if (search_.solved()) return std::nullopt;
        continue;
      }
      waiting_.push_back(entry);
      if (!confirmed) batch_.push_back(search_.table().best(entry.state));
    }
    return std::nullopt;
  }

  /// Is the cost of `s` within the weight of the optimum even if the best path to it leads through a waiting state?
  bool independent(StateId s) {
    const double g = search_.table().best_cost(s);
    return std::all_of(waiting_.begin(), waiting_.end(), [&](const OpenList::Entry& other) {
      const double g_other = search_.table().best_cost(other.state);  // infinity once it has been expanded
      return g <= g_other || g <= g_other + options_.weight * lower_bound(other.state, s);
    });
  }

  double lower_bound(StateId a, StateId b) {
    if constexpr (std::is_same_v<P, HeuristicDifference>) {
      return search_.table()[a].heuristic - search_.table()[b].heuristic;
    } else {
      return pair_(a, b);
    }
  }

  void put_back() {
    for (const OpenList::Entry& entry : waiting_) search_.put_back(entry);
    waiting_.clear();
  }

  WeightedSearch<G, H> search_;
  P pair_;
  WpaseOptions options_;
  std::vector<OpenList::Entry> waiting_;
  std::vector<EdgeId> batch_;
};

/// The whole search at once.
template <Graph G, Heuristic H, class P = HeuristicDifference>
Result wpase(G& graph, std::span<const StateId> starts, H& heuristic, const WpaseOptions& options,
             const Deadline& deadline, P pair = {}) {
  ParallelWeightedAstar<G, H, P> search(graph, starts, heuristic, options, std::move(pair));
  const std::optional<Status> stop = search.improve(deadline, unlimited);
  return search.result(stop);
}

}  // namespace srmp::search
