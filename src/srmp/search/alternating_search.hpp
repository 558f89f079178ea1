#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "srmp/search/inadmissible_heuristics.hpp"
#include "srmp/search/lazy_tree.hpp"
#include "srmp/search/open_list.hpp"
#include "srmp/search/resumable_search.hpp"

namespace srmp::search {

/// Finds some path quickly, and then proves or improves its cost: greedy best-first search in the orders of several
/// heuristics that share their expansions, beside A*.
///
/// Papers: Röger, Helmert 2010, "The More, the Merrier: Combining Heuristic Estimators for Satisficing Planning"
/// (queues alternate, each expands its best state); Aine et al. 2016, "Multi-Heuristic A*" (the consistent anchor
/// beside them, no state expanded more than twice); lazy edges as in Cohen, Phillips, Likhachev 2014.
/// The anchor queue holds all open states in the order of g + h, so no path costs less than its smallest key. Until
/// there is a path the inadmissible queues expand; then, as long as it costs more than weight times that key, the
/// anchor does, as A* would.
///
/// Guarantee: cost <= bound * optimal cost, bound <= weight unless the deadline came first; no edge evaluated twice.
/// Needs: a Graph, and a consistent heuristic for the anchor as weighted A* (astar.hpp). Without inadmissible
/// heuristics it is A*.
template <Graph G, Heuristic H>
class AlternatingSearch : public ResumableSearch {
 public:
  /// Graph and anchor outlive this.
  AlternatingSearch(G& graph, std::span<const StateId> starts, H& anchor,
                    InadmissibleHeuristics inadmissible_heuristics, double weight)
      : tree_(graph, anchor), values_(std::move(inadmissible_heuristics)), weight_(weight), queues_(values_.count()) {
    require_weight(weight, "weight");
    tree_.add_starts(starts, [this](StateId s) { reached_.push_back(s); });
    requeue_reached();
  }

  bool solved() const override { return goal_.known(); }
  double cost() const override { return goal_.cost(); }
  bool finished() const override {
    if (solved()) return cost() <= weight_ * anchor_.min_priority();
    return queues_.empty() ? anchor_.empty() : queues_[0].empty();  // these queues hold the same states
  }

  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) override {
    const std::uint64_t first = tree_.statistics.expansions;
    while (!finished() && tree_.statistics.expansions - first < expansions) {
      if (const auto stop = stop_status(deadline)) return stop;
      const bool greedy = !solved() && !queues_.empty();
      const StateId s = (greedy ? queues_[round_ % queues_.size()] : anchor_).top().state;
      if (!table().confirmed(s)) {
        const EdgeId e = table().best(s);
        tree_.evaluate({&e, 1});
        requeue(s);
        continue;
      }
      ++round_;
      visit(s, greedy ? by_inadmissible : by_anchor);
    }
    return std::nullopt;
  }

  Result result(std::optional<Status> stop) const override {
    Result result = goal_.result(statistics(), stop);
    if (solved()) result.bound = proven_bound(infinity, cost(), anchor_.min_priority());
    return result;
  }

  Statistics statistics() const override {
    Statistics statistics = tree_.statistics;
    statistics.memory = table().memory() + anchor_.memory() + values_.memory();
    for (const OpenList& queue : queues_) statistics.memory += queue.memory();
    return statistics;
  }

 private:
  static constexpr std::uint32_t by_inadmissible = 1;
  static constexpr std::uint32_t by_anchor = 2;

  CandidateTable& table() { return tree_.table; }
  const CandidateTable& table() const { return tree_.table; }

  void visit(StateId s, std::uint32_t closed_by) {
    dequeue(s);
    table().commit(s);
    table()[s].closed |= closed_by;
    if (tree_.is_goal(s)) return goal_.offer(table(), s);
    reached_.clear();
    tree_.expand(s, [this](StateId next) { reached_.push_back(next); });
    requeue_reached();
  }

  void requeue_reached() {
    values_.evaluate(reached_);
    for (const StateId s : reached_) requeue(s);
  }

  void dequeue(StateId s) {
    anchor_.erase(s);
    for (OpenList& queue : queues_) queue.erase(s);
  }

  /// Moves `s` into the queues where its best candidate belongs. What an inadmissible
  /// queue has expanded, only the anchor may expand again.
  void requeue(StateId s) {
    const CandidateTable::State& state = table()[s];
    if (state.best == no_edge) return dequeue(s);
    if (state.closed & by_anchor) return;  // at its optimal cost, as the heuristic is consistent
    const double g = table().best_cost(s);
    anchor_.set(s, g + state.heuristic, state.heuristic);
    if (state.closed) return;
    for (std::size_t i = 0; i < queues_.size(); ++i) queues_[i].set(s, values_(s, i), g);
  }

  LazyTree<G, H> tree_;
  InadmissibleValues values_;
  double weight_;
  OpenList anchor_;
  std::vector<OpenList> queues_;  ///< one per inadmissible heuristic
  std::vector<StateId> reached_;  ///< by the last expansion
  BestGoal goal_;
  std::uint64_t round_{};
};

}  // namespace srmp::search
