#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "srmp/search/lazy_tree.hpp"
#include "srmp/search/open_list.hpp"
#include "srmp/search/resumable_search.hpp"

namespace srmp::search {

/// What searches with one OPEN ordered by f = g + weight * h share: OPEN, CLOSED, INCONS and the best goal.
///
/// INCONS holds closed states for which a cheaper candidate has been found since. No path can cost less than the
/// smallest g + h over OPEN and INCONS: of an optimal path, the first state that was not expanded at its optimal cost
/// is in one of them, at its optimal cost or a lower bound of it.
template <Graph G, Heuristic H>
class WeightedSearch {
 public:
  enum class Expand {
    once,   ///< a state is never expanded again: edges that lost are forgotten
    again,  ///< all edges and their true costs are remembered
  };

  WeightedSearch(G& graph, H& heuristic, double weight, Expand expand)
      : tree_(graph, heuristic), weight_(weight), expand_(expand) {}

  void add_starts(std::span<const StateId> starts) {
    tree_.add_starts(starts, [this](StateId s) { requeue(s); });
  }

  /// No state in OPEN can beat the best goal within the weight.
  bool finished() const { return open_.empty() || (solved() && open_.min_priority() >= goal_.cost()); }

  /// Expands in the order of OPEN until finished, or `expansions` states more. Says why when it had to stop earlier.
  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions = unlimited) {
    const std::uint64_t first = this->expansions();
    while (!finished() && this->expansions() - first < expansions) {
      if (const auto stop = stop_status(deadline)) return stop;
      const StateId s = open_.top().state;
      if (table().confirmed(s)) {
        open_.pop();
        visit(s);
      } else {
        const EdgeId e = table().best(s);
        tree_.evaluate({&e, 1});
        requeue(s);
      }
    }
    return std::nullopt;
  }

  /// Starts the next round: nothing is closed, INCONS goes to OPEN, OPEN is sorted by the new weight.
  void next_round(double weight) {
    ++round_;
    weight_ = weight;
    open_.reprioritise([&](const OpenList::Entry& entry) { return priority(entry.state); });
    for (const StateId s : inconsistent_) {
      table()[s].inconsistent = false;
      requeue(s);
    }
    inconsistent_.clear();
  }

  /// Closes a confirmed state that is out of OPEN; it is either a goal or expanded.
  void visit(StateId s) {
    table().commit(s);
    table()[s].closed = round_;
    if (tree_.is_goal(s)) return goal_.offer(table(), s);
    const auto reached = [this](StateId next) { requeue(next); };
    if (expand_ == Expand::once) {
      tree_.expand_once(s, reached);
    } else {
      tree_.expand(s, reached);
    }
  }

  /// Moves `s` to where its best candidate belongs: OPEN, INCONS or, without a candidate, nowhere.
  void requeue(StateId s) {
    CandidateTable::State& state = table()[s];
    if (state.best == no_edge) return open_.erase(s);
    if (state.closed != round_) return open_.set(s, priority(s), state.heuristic);
    if (!std::exchange(state.inconsistent, true)) inconsistent_.push_back(s);
  }

  /// Returns an entry that was popped from OPEN; if nothing has changed, to its old place among equals.
  void put_back(const OpenList::Entry& entry) {
    const StateId s = entry.state;
    const bool open = table().has_candidate(s) && table()[s].closed != round_ && !open_.contains(s);
    if (open && priority(s) == entry.priority) return open_.restore(entry);
    requeue(s);
  }

  bool solved() const { return goal_.known(); }
  std::uint64_t expansions() const { return tree_.statistics.expansions; }
  /// Of the best path; infinity while there is none.
  double cost() const { return goal_.cost(); }

  Statistics statistics() const {
    Statistics statistics = tree_.statistics;
    statistics.memory = table().memory() + open_.memory() + inconsistent_.capacity() * sizeof(StateId);
    return statistics;
  }

  /// The path to the best goal, its cost and its bound, if any.
  Result result(double guaranteed_bound, std::optional<Status> stop) const {
    Result result = goal_.result(statistics(), stop);
    if (!solved()) return result;
    result.bound = proven_bound(guaranteed_bound, result.cost, lower_bound(guaranteed_bound, result.cost));
    return result;
  }

  double priority(StateId s) const { return table().best_cost(s) + weight_ * table()[s].heuristic; }
  OpenList& open() { return open_; }
  const OpenList& open() const { return open_; }
  LazyTree<G, H>& tree() { return tree_; }
  CandidateTable& table() { return tree_.table; }
  const CandidateTable& table() const { return tree_.table; }

 private:
  double lower_bound(double guaranteed_bound, double cost) const {
    if (guaranteed_bound == 1.0) return cost;
    double lower = cost;
    const auto lower_to = [&](StateId s) { lower = std::min(lower, table().best_cost(s) + table()[s].heuristic); };
    open_.entries().for_each([&](const OpenList::Entry& entry) { lower_to(entry.state); });
    for (const StateId s : inconsistent_) lower_to(s);
    return lower;
  }

  LazyTree<G, H> tree_;
  OpenList open_;
  std::vector<StateId> inconsistent_;
  double weight_;
  Expand expand_;
  std::uint32_t round_{1};
  BestGoal goal_;
};

}  // namespace srmp::search
