#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "srmp/core/block_vector.hpp"
#include "srmp/search/inadmissible_heuristics.hpp"
#include "srmp/search/lazy_tree.hpp"
#include "srmp/search/open_list.hpp"
#include "srmp/search/resumable_search.hpp"

/// AMRA*: anytime multi-resolution multi-heuristic A* with lazily evaluated edges.
///
/// Papers: Saxena, Kusnur, Likhachev 2022, "AMRA*: Anytime Multi-Resolution Multi-Heuristic A*"; Du, Islam, Likhachev
/// 2020, "Multi-Resolution A*"; lazy edges as in Cohen, Phillips, Likhachev 2014.
/// Every inadmissible heuristic has a queue for each resolution. A state is expanded in the resolutions on whose grid
/// it lies, in each at most once in a round, and all queues share the states and their costs, so that a search that is
/// stuck at one resolution goes on at another. The anchor queue expands in the finest resolution.
/// Guarantee: cost <= bound * the optimum of the finest graph; bound <= w1 * w2 after the first round, and at last
/// <= final_weight; no edge is evaluated twice.
/// Needs: a MultiResolutionGraph and a consistent anchor heuristic, as weighted A* (astar.hpp).
namespace srmp::search {

/// A Graph whose states lie on grids of several resolutions.
/// - levels() >= 1; level 0 is the finest, and all states are on it.
/// - successors(s, level, out) appends the edges of that resolution, connections(s, out) those that belong to all.
///   successors(s, out), as of every Graph, appends those of level 0 and the connections.
template <class G>
concept MultiResolutionGraph =
    Graph<G> && requires(G& graph, StateId s, std::size_t level, std::vector<Successor>& out) {
      { graph.levels() } -> std::convertible_to<std::size_t>;
      { graph.is_on(s, level) } -> std::convertible_to<bool>;
      { graph.successors(s, level, out) } -> std::same_as<void>;
      { graph.connections(s, out) } -> std::same_as<void>;
    };

struct AmraOptions {
  double w1{20.0};           ///< >= 1; inflates all heuristics in the first round
  double w2{5.0};            ///< >= 1; the other queues' keys may exceed the anchor's by this factor in the first round
  double final_weight{1.0};  ///< >= 1; stop once this bound is proven
  /// Is called with each path that is cheaper or has a tighter bound than the one before; false stops the search. May
  /// be empty.
  std::function<bool(const Result&)> on_solution{};
};

/// One search in slices, from all `starts` (cost 0 each) to the nearest goal.
template <MultiResolutionGraph G, Heuristic H>
class AmraStar : public ResumableSearch {
 public:
  /// Graph and anchor outlive this.
  AmraStar(G& graph, std::span<const StateId> starts, H& anchor, InadmissibleHeuristics others, AmraOptions options)
      : graph_(graph),
        tree_(graph, anchor),
        others_(std::move(others)),
        options_(std::move(options)),
        w1_(options_.w1),
        w2_(options_.w2),
        levels_(graph.levels()),
        queues_(others_.count() * levels_) {
    require_weight(options_.w1, "w1");
    require_weight(options_.w2, "w2");
    require_weight(options_.final_weight, "final_weight");
    if (levels_ == 0 || levels_ > max_levels)
      throw InvalidArgument("the graph has " + std::to_string(levels_) + " resolutions, it must have 1 to " +
                            std::to_string(max_levels));
    tree_.add_starts(starts, [this](StateId s) { reached_.push_back(s); });
    requeue_reached();
  }

  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) override {
    const std::uint64_t first = tree_.statistics.expansions;
    while (!finished_ && tree_.statistics.expansions - first < expansions) {
      if (const auto stop = stop_status(deadline)) return stop;
      const std::size_t queue = next_queue();
      OpenList& open = queue == anchor_queue ? anchor_ : queues_[queue];
      if (open.empty() || (goal_.known() && open.min_priority() >= goal_.cost())) {
        end_round();
        continue;
      }
      const StateId s = open.top().state;
      if (table().has_candidate(s) && !table().confirmed(s)) {
        const EdgeId e = table().best(s);
        tree_.evaluate({&e, 1});
        requeue(s);
      } else {
        visit(s, queue);
      }
    }
    return std::nullopt;
  }

  bool finished() const override { return finished_; }
  bool solved() const override { return goal_.known(); }
  double cost() const override { return goal_.cost(); }
  /// Between two rounds' ends the path may be better than the last that on_solution was told.
  Result result(std::optional<Status> stop) const override {
    Result result = goal_.result(statistics(), stop);
    if (solved()) result.bound = std::min(bound_, proven_bound(infinity, result.cost, lower_bound()));
    return result;
  }
  Statistics statistics() const override {
    Statistics statistics = tree_.statistics;
    statistics.memory = table().memory() + anchor_.memory() + others_.memory() + blocks_.memory() +
                        inconsistent_.capacity() * sizeof(StateId);
    for (const OpenList& queue : queues_) statistics.memory += queue.memory();
    return statistics;
  }

 private:
  static constexpr std::size_t max_levels = 16;
  static constexpr std::size_t anchor_queue = static_cast<std::size_t>(-1);
  // Marks of a state; bit l: expanded at level l in this round.
  static constexpr std::uint32_t closed_by_anchor = std::uint32_t{1} << max_levels;  // in this round
  static constexpr std::uint32_t offered = closed_by_anchor << 1;  // its edges of level 0, at the cost in the table

  CandidateTable& table() { return tree_.table; }
  const CandidateTable& table() const { return tree_.table; }
  std::size_t level_of(std::size_t queue) const { return queue == anchor_queue ? 0 : queue % levels_; }
  /// Cost to come over the best candidate, or as it was at the last expansion.
  double g(StateId s) const { return std::min(table().best_cost(s), table()[s].cost); }

  /// Round robin over the inadmissible queues; the anchor replaces one that is empty or whose keys are too far above.
  std::size_t next_queue() const {
    if (queues_.empty()) return anchor_queue;
    const std::size_t queue = visits_ % queues_.size();
    if (queues_[queue].empty() || queues_[queue].min_priority() > w2_ * anchor_.min_priority()) return anchor_queue;
    return queue;
  }

  void visit(StateId s, std::size_t queue) {
    ++visits_;
    const bool improved = table().has_candidate(s);
    if (improved) {
      table().commit(s);
      table()[s].closed &= ~offered;
    }
    if (tree_.is_goal(s)) {
      dequeue(s);
      if (improved) goal_.offer(table(), s);
      return;
    }
    const std::size_t level = level_of(queue);
    table()[s].closed |= std::uint32_t{1} << level | (level == 0 ? offered : 0);
    if (queue == anchor_queue) table()[s].closed |= closed_by_anchor;
    requeue(s);
    expand(s, level);
  }

  void expand(StateId s, std::size_t level) {
    tree_.begin_expansion(s);
    const std::size_t first = std::size_t{s} * (levels_ + 1);
    blocks_.grow_to(first + levels_ + 1, {});
    reached_.clear();
    const auto reached = [this](StateId next) { reached_.push_back(next); };
    tree_.expand(
        s, blocks_[first + levels_], [&](std::vector<Successor>& out) { graph_.connections(s, out); }, reached);
    tree_.expand(
        s, blocks_[first + level], [&](std::vector<Successor>& out) { graph_.successors(s, level, out); }, reached);
    requeue_reached();
  }

  void requeue_reached() {
    others_.evaluate(reached_);
    for (const StateId s : reached_) requeue(s);
  }

  void dequeue(StateId s) {
    anchor_.erase(s);
    for (OpenList& queue : queues_) queue.erase(s);
  }

  /// Moves `s` into the queues where its cost belongs.
  void requeue(StateId s) {
    CandidateTable::State& state = table()[s];
    const double cost = g(s);
    if (cost == infinity) return dequeue(s);
    if (state.best == no_edge && state.closed & offered)
      anchor_.erase(s);
    else if (!(state.closed & closed_by_anchor))
      anchor_.set(s, cost + w1_ * state.heuristic, state.heuristic);
    else if (!std::exchange(state.inconsistent, true))
      inconsistent_.push_back(s);
    set_inadmissible(s, cost);
  }

  void set_inadmissible(StateId s, double cost) {
    const double limit = w2_ * (cost + w1_ * table()[s].heuristic);
    for (std::size_t i = 0; i < queues_.size(); ++i) {
      const std::size_t level = level_of(i);
      const double h = others_(s, i / levels_), priority = cost + w1_ * h;
      const bool open = !(table()[s].closed >> level & 1) && priority <= limit && on(s, level);
      if (open)
        queues_[i].set(s, priority, h);
      else
        queues_[i].erase(s);
    }
  }

  bool on(StateId s, std::size_t level) { return tree_.is_goal(s) || graph_.is_on(s, level); }

  void end_round() {
    Result now = result(std::nullopt);
    now.bound = std::min(now.bound, w1_ * w2_);
    const bool better = now.cost < told_cost_ || now.bound < bound_;
    bound_ = now.bound;
    told_cost_ = now.cost;
    finished_ =
        !solved() || (better && options_.on_solution && !options_.on_solution(now)) || bound_ <= options_.final_weight;
    if (!finished_) next_round();
  }

  /// Halves how far the weights are above 1; nothing is closed, INCONS goes to OPEN.
  void next_round() {
    const auto halved = [](double w) { return w < 1.05 ? 1.0 : 1.0 + 0.5 * (w - 1.0); };
    w1_ = halved(w1_);
    w2_ = halved(w2_);
    reached_.assign(inconsistent_.begin(), inconsistent_.end());
    anchor_.entries().for_each([&](const OpenList::Entry& entry) { reached_.push_back(entry.state); });
    std::sort(reached_.begin(), reached_.end());
    for (const StateId s : inconsistent_) table()[s].inconsistent = false;
    inconsistent_.clear();
    for (OpenList& queue : queues_) queue = {};
    anchor_ = {};
    for (StateId s = 0; s < table().size(); ++s) table()[s].closed &= offered;
    for (const StateId s : reached_) requeue(s);
  }

  double lower_bound() const {
    double lower = goal_.cost();
    const auto lower_to = [&](StateId s) { lower = std::min(lower, g(s) + table()[s].heuristic); };
    anchor_.entries().for_each([&](const OpenList::Entry& entry) { lower_to(entry.state); });
    for (const StateId s : inconsistent_) lower_to(s);
    return lower;
  }

  G& graph_;
  LazyTree<G, H> tree_;
  InadmissibleValues others_;
  AmraOptions options_;
  double w1_, w2_;  // of this round
  std::size_t levels_;
  OpenList anchor_;
  std::vector<OpenList> queues_;                   // number: heuristic * levels + level
  BlockVector<CandidateTable::EdgeBlock> blocks_;  // by state: one for each level, then the connections
  std::vector<StateId> reached_;                   // by the last expansion
  std::vector<StateId> inconsistent_;              // expanded by the anchor; a cheaper candidate was found since
  BestGoal goal_;
  double bound_{infinity}, told_cost_{infinity};
  std::size_t visits_{};
  bool finished_{};
};

}  // namespace srmp::search
