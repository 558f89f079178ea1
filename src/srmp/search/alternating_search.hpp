#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "srmp/search/lazy_tree.hpp"
#include "srmp/search/open_list.hpp"

namespace srmp::search {

/// Estimates of the cost-to-go, which may overestimate it: each finite and >= 0. values(states, out) writes all `count`
/// of the first state, then of the next.
struct InadmissibleHeuristics {
  std::size_t count{};
  std::function<void(std::span<const StateId>, std::span<double>)> values;
};

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
class AlternatingSearch {
 public:
  AlternatingSearch(G& graph, H& anchor, InadmissibleHeuristics inadmissible_heuristics, double weight)
      : tree_(graph, anchor),
        inadmissible_heuristics_(std::move(inadmissible_heuristics)),
        weight_(weight),
        queues_(inadmissible_heuristics_.count) {}

  void add_starts(std::span<const StateId> starts) {
    reached_.clear();
    tree_.add_starts(starts, [this](StateId s) { reached_.push_back(s); });
    requeue_reached();
  }

  bool solved() const { return goal_.known(); }
  /// Of the best path; infinity while there is none.
  double cost() const { return goal_.cost(); }
  /// Nothing left to do: proven, or exhausted.
  bool finished() const {
    if (solved()) return cost() <= weight_ * anchor_.min_priority();
    return queues_.empty() ? anchor_.empty() : queues_[0].empty();  // these queues hold the same states
  }

  /// Expands until finished, or `expansions` states. Says why when it had to stop earlier.
  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) {
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

  Result result(std::optional<Status> stop) const {
    Result result = goal_.result(statistics(), stop);
    if (solved()) result.bound = proven_bound(infinity, cost(), anchor_.min_priority());
    return result;
  }

  std::uint64_t expansions() const { return tree_.statistics.expansions; }
  Statistics statistics() const {
    Statistics statistics = tree_.statistics;
    statistics.memory = table().memory() + anchor_.memory() + values_of_.capacity() * sizeof(double);
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
    evaluate_inadmissible();
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
    for (std::size_t i = 0; i < queues_.size(); ++i) queues_[i].set(s, values_of_[at(s, i)], g);
  }

  std::size_t at(StateId s, std::size_t i) const { return std::size_t{s} * queues_.size() + i; }

  /// The inadmissible heuristics of the states reached, each evaluated once, all in one call.
  void evaluate_inadmissible() {
    const std::size_t count = queues_.size();
    if (count == 0) return;
    new_states_.clear();
    for (const StateId s : reached_) {
      if (at(s, count) > values_of_.size()) values_of_.resize(at(s, count), -1.0);
      if (values_of_[at(s, 0)] < 0.0) new_states_.push_back(s);
    }
    if (new_states_.empty()) return;
    values_.resize(new_states_.size() * count);
    inadmissible_heuristics_.values(new_states_, values_);
    for (std::size_t k = 0; k < values_.size(); ++k) {
      const StateId s = new_states_[k / count];
      if (!(values_[k] >= 0.0 && values_[k] < infinity))
        throw InvalidArgument("inadmissible heuristic " + std::to_string(k % count) + " of state " + std::to_string(s) +
                              " is " + to_text(values_[k]) + ", it must be finite and at least 0");
      values_of_[at(s, k % count)] = values_[k];
    }
  }

  LazyTree<G, H> tree_;
  InadmissibleHeuristics inadmissible_heuristics_;
  double weight_;
  OpenList anchor_;
  std::vector<OpenList> queues_;     ///< one per inadmissible heuristic
  std::vector<StateId> reached_;     ///< by the last expansion
  std::vector<StateId> new_states_;  ///< of these, those not evaluated yet
  std::vector<double> values_;       ///< of these
  std::vector<double> values_of_;    ///< by state and inadmissible heuristic; negative: not evaluated yet
  BestGoal goal_;
  std::uint64_t round_{};
};

}  // namespace srmp::search
