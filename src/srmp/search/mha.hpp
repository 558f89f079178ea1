#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "srmp/search/inadmissible_heuristics.hpp"
#include "srmp/search/lazy_tree.hpp"
#include "srmp/search/open_list.hpp"
#include "srmp/search/resumable_search.hpp"

/// MHA*: multi-heuristic A* with shared expansions (SMHA*) and lazily evaluated edges.
///
/// Papers: Aine, Swaminathan, Narayanan, Hwang, Likhachev 2016, "Multi-Heuristic A*"; lazy edges as in Cohen, Phillips,
/// Likhachev 2014.
/// Guarantee: cost <= bound * optimal cost, bound <= w1 * w2, whatever the other heuristics say; no state is expanded
/// more than twice, no edge evaluated twice.
/// Needs: a Graph (see graph.hpp) and a consistent anchor heuristic, as weighted A* (astar.hpp). The other heuristics
/// may be inadmissible; infinity there keeps a state out of that heuristic's queue only.
namespace srmp::search {

struct MhaOptions {
  double w1{5.0};  ///< >= 1; inflates all heuristics
  double w2{5.0};  ///< >= 1; the other queues' keys may exceed the anchor's by this factor
};

using InadmissibleHeuristic = AnyHeuristic;

/// One search in slices, from all `starts` (cost 0 each) to the nearest goal, guided by `anchor` and any number of
/// `others`. Queue 0 belongs to the anchor and holds every open state.
template <Graph G, Heuristic H>
class MultiHeuristicSearch : public ResumableSearch {
 public:
  /// Graph and heuristics outlive this.
  MultiHeuristicSearch(G& graph, std::span<const StateId> starts, H& anchor,
                       std::span<const InadmissibleHeuristic> others, const MhaOptions& options)
      : tree_(graph, anchor), others_(together(others)), options_(options), queues_(others.size() + 1) {
    require_weight(options.w1, "w1");
    require_weight(options.w2, "w2");
    tree_.add_starts(starts, [this](StateId s) { reached_.push_back(s); });
    others_.evaluate(reached_);
    for (const StateId s : reached_) requeue(s);
  }

  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) override {
    const std::uint64_t first = tree_.statistics.expansions;
    while (!finished() && tree_.statistics.expansions - first < expansions) {
      if (const auto stop = stop_status(deadline)) return stop;
      const std::size_t queue = queue_of(round_);
      const StateId s = queues_[queue].top().state;
      if (!table().confirmed(s)) {
        const EdgeId e = table().best(s);
        tree_.evaluate({&e, 1});
        requeue(s);
        continue;
      }
      close(s, queue);
      if (tree_.is_goal(s)) {
        goal_.offer(table(), s);
        break;
      }
      reached_.clear();
      tree_.expand(s, [this](StateId next) { reached_.push_back(next); });
      others_.evaluate(reached_);
      for (const StateId next : reached_) requeue(next);
      ++round_;
    }
    return std::nullopt;
  }

  bool finished() const override { return solved() || queues_[0].empty(); }
  bool solved() const override { return goal_.known(); }
  double cost() const override { return goal_.cost(); }

  Result result(std::optional<Status> stop) const override {
    Result result = goal_.result(statistics(), stop);
    if (!solved()) return result;
    double lower = result.cost;
    const auto lower_to = [&](StateId s) { lower = std::min(lower, table().best_cost(s) + table()[s].heuristic); };
    queues_[0].entries().for_each([&](const OpenList::Entry& entry) { lower_to(entry.state); });
    for (const StateId s : inconsistent_) lower_to(s);
    result.bound = proven_bound(options_.w1 * options_.w2, result.cost, lower);
    return result;
  }

  Statistics statistics() const override {
    Statistics statistics = tree_.statistics;
    statistics.memory = table().memory() + others_.memory() + inconsistent_.capacity() * sizeof(StateId);
    for (const OpenList& open : queues_) statistics.memory += open.memory();
    return statistics;
  }

 private:
  static constexpr std::uint32_t closed_by_inadmissible = 1;
  static constexpr std::uint32_t closed_by_anchor = 2;

  CandidateTable& table() { return tree_.table; }
  const CandidateTable& table() const { return tree_.table; }

  /// Round robin over the other queues; the anchor's replaces one whose keys are too far above its own.
  std::size_t queue_of(std::size_t round) const {
    if (others_.count() == 0) return 0;
    const std::size_t queue = 1 + round % others_.count();
    if (queues_[queue].empty()) return 0;
    return queues_[queue].min_priority() <= options_.w2 * queues_[0].min_priority() ? queue : 0;
  }

  void close(StateId s, std::size_t queue) {
    for (OpenList& open : queues_) open.erase(s);
    table().commit(s);
    table()[s].closed |= queue == 0 ? closed_by_anchor : closed_by_inadmissible;
  }

  /// Moves `s` into the queues where its best candidate belongs.
  void requeue(StateId s) {
    CandidateTable::State& state = table()[s];
    if (state.best == no_edge) {
      for (OpenList& open : queues_) open.erase(s);
      return;
    }
    if (state.closed & closed_by_anchor) {
      if (!std::exchange(state.inconsistent, true)) inconsistent_.push_back(s);
      return;
    }
    const double g = table().best_cost(s), anchor = g + options_.w1 * state.heuristic;
    queues_[0].set(s, anchor, state.heuristic);
    if (state.closed & closed_by_inadmissible) return;
    for (std::size_t i = 0; i < others_.count(); ++i) {
      const double h = others_(s, i), priority = g + options_.w1 * h;
      if (h < infinity && priority <= options_.w2 * anchor) {
        queues_[i + 1].set(s, priority, h);
      } else {
        queues_[i + 1].erase(s);
      }
    }
  }

  LazyTree<G, H> tree_;
  InadmissibleValues others_;
  MhaOptions options_;
  std::vector<OpenList> queues_;
  std::vector<StateId> reached_;       ///< by the last expansion
  std::vector<StateId> inconsistent_;  ///< closed by the anchor, but a cheaper candidate was found since
  BestGoal goal_;
  std::size_t round_{};
};

/// The whole search at once.
template <Graph G, Heuristic H>
Result mha_star(G& graph, std::span<const StateId> starts, H& anchor, std::span<const InadmissibleHeuristic> others,
                const MhaOptions& options, const Deadline& deadline) {
  MultiHeuristicSearch<G, H> search(graph, starts, anchor, others, options);
  const std::optional<Status> stop = search.improve(deadline, unlimited);
  return search.result(stop);
}

}  // namespace srmp::search
