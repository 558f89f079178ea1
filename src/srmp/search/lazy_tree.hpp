#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "srmp/core/block_vector.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/search/graph.hpp"

/// What all searches with lazy edges share: the table of states and the candidate edges that lead to them.
///
/// Lazy edge evaluation (Cohen, Phillips, Likhachev 2014, "Planning Single-Arm Manipulations with N-Arm Robots"): an
/// expansion offers its edges at their lower bounds. An edge is evaluated only once it is the best candidate of a state
/// that has come to the top of OPEN; if it costs more than its lower bound or does not exist, the state's next
/// candidate takes over.
namespace srmp::search {

using EdgeId = std::uint32_t;
inline constexpr EdgeId no_edge = std::numeric_limits<EdgeId>::max();

/// The states seen so far and, for each, the candidate edges into it.
///
/// The candidates of a state are a list sorted by cost-to-come g. The first is the best; the state's cost is
/// *confirmed* when that one has been evaluated. At most one candidate is evaluated, and it is the last: those behind
/// it could never win. Only candidates better than the state's cost at its last expansion are kept.
class CandidateTable {
 public:
  /// Edges of an expansion that are remembered, one after the other in the table.
  struct EdgeBlock {
    EdgeId first{no_edge};  ///< no_edge: not generated yet
    std::uint32_t count{};
  };
  struct State {
    double cost{infinity};   ///< to come, at the last expansion; infinity before
    double heuristic{-1.0};  ///< negative: not evaluated yet
    EdgeId parent{no_edge};  ///< the edge over which `cost` was reached
    EdgeId best{no_edge};    ///< first candidate
    EdgeBlock edges{};       ///< outgoing edges; only when edges are remembered
    std::uint32_t closed{};  ///< the search's mark
    bool inconsistent{};     ///< in the search's INCONS
  };

  const State& operator[](StateId s) const { return states_[s]; }
  State& operator[](StateId s) { return states_[s]; }

  /// Makes room for `s`.
  void ensure(StateId s) {
    if (s < states_.size()) return;
    if (s == no_state) throw InvalidArgument("the graph generated no_state (4294967295) as a state");
    states_.grow_to(std::size_t{s} + 1, {});
  }

  std::size_t size() const { return states_.size(); }

  bool has_candidate(StateId s) const { return states_[s].best != no_edge; }
  /// Is the best candidate of `s` evaluated?
  bool confirmed(StateId s) const { return has_candidate(s) && edges_[states_[s].best].evaluated; }
  /// Cost to come over the best candidate; infinity without one.
  double best_cost(StateId s) const { return has_candidate(s) ? edges_[states_[s].best].g : infinity; }
  EdgeId best(StateId s) const { return states_[s].best; }

  Edge edge(EdgeId e) const { return {edges_[e].from, edges_[e].to, edges_[e].cost}; }

  /// Stores an edge without offering it.
  EdgeId add(StateId from, StateId to, double cost, bool evaluated = false) {
    if (edges_.size() >= no_edge) throw Error("the search has stored 4294967295 edges, the most it can");
    edges_.push_back({.cost = cost, .from = from, .to = to, .evaluated = evaluated});
    return static_cast<EdgeId>(edges_.size() - 1);
  }

  /// Offers a stored edge at cost-to-come `g`; true when it is now the best candidate.
  bool offer(EdgeId e, double g) {
    withdraw(e);
    const Slot slot = find_slot(edges_[e].to, g, edges_[e].evaluated);
    return slot.open && link(e, g, slot.previous);
  }

  /// Stores and offers an unevaluated edge, unless it could never win; true when it is now the best candidate.
  bool offer_new(const Edge& edge, double g) {
    const Slot slot = find_slot(edge.to, g, false);
    return slot.open && link(add(edge.from, edge.to, edge.cost), g, slot.previous);
  }

  /// Enters the true cost of an edge. It stays a candidate only if it exists.
  void set_true_cost(EdgeId e, double true_cost) {
    withdraw(e);
    edges_[e].evaluated = true;
    edges_[e].cost = true_cost;
    if (true_cost < infinity) offer(e, states_[edges_[e].from].cost + true_cost);
  }

  /// The confirmed best candidate becomes the state's parent.
  void commit(StateId s) {
    State& state = states_[s];
    state.cost = edges_[state.best].g;
    state.parent = state.best;
    edges_[state.best].g = infinity;
    state.best = no_edge;
  }

  /// Start … s over the parents. Costs are positive and a parent was expanded at less than its child, so it ends.
  std::vector<StateId> path_to(StateId s) const {
    std::vector<StateId> path;
    for (; s != no_state; s = edges_[states_[s].parent].from) path.push_back(s);
    std::reverse(path.begin(), path.end());
    return path;
  }

  /// True cost of path_to(path.back()), summed from the start.
  double path_cost(std::span<const StateId> path) const {
    double cost = 0.0;
    for (const StateId s : path) cost += edges_[states_[s].parent].cost;
    return cost;
  }

  std::size_t memory() const { return states_.memory() + edges_.memory(); }

 private:
  struct Candidate {
    double g{infinity};  ///< cost to come over this edge while it is in its state's list, infinity otherwise
    double cost{};       ///< lower bound, or true cost once evaluated
    StateId from{no_state};
    StateId to{no_state};
    EdgeId next{no_edge};
    bool evaluated{};
  };
  struct Slot {
    bool open{};  ///< false: the edge could never win
    EdgeId previous{no_edge};
  };

  /// Where an edge at `g` belongs. Equal costs: an evaluated one first, then first come, first served.
  Slot find_slot(StateId to, double g, bool evaluated) const {
    if (!(g < states_[to].cost)) return {};
    EdgeId previous = no_edge;
    for (EdgeId at = states_[to].best; at != no_edge; at = edges_[at].next) {
      const Candidate& other = edges_[at];
      if (other.evaluated && other.g <= g) return {};
      if (other.g > g || (evaluated && other.g == g)) break;
      previous = at;
    }
    return {true, previous};
  }

  bool link(EdgeId e, double g, EdgeId previous) {
    Candidate& edge = edges_[e];
    EdgeId& before = previous == no_edge ? states_[edge.to].best : edges_[previous].next;
    edge.g = g;
    edge.next = before;
    before = e;
    if (edge.evaluated) drop_after(e);
    return previous == no_edge;
  }

  void drop_after(EdgeId e) {
    EdgeId at = edges_[e].next;
    edges_[e].next = no_edge;
    while (at != no_edge) {
      edges_[at].g = infinity;
      at = std::exchange(edges_[at].next, no_edge);
    }
  }

  void withdraw(EdgeId e) {
    if (edges_[e].g == infinity) return;
    EdgeId* link = &states_[edges_[e].to].best;
    while (*link != e) link = &edges_[*link].next;
    *link = edges_[e].next;
    edges_[e].next = no_edge;
    edges_[e].g = infinity;
  }

  BlockVector<State> states_;
  BlockVector<Candidate> edges_;
};

/// The cheapest path to a goal so far, as it was found: later expansions may give its states other parents, over which
/// they cost more for a while.
class BestGoal {
 public:
  bool known() const { return !path_.empty(); }
  double cost() const { return cost_; }  ///< infinity while there is none

  void offer(const CandidateTable& table, StateId goal) {
    std::vector<StateId> path = table.path_to(goal);
    const double cost = table.path_cost(path);
    if (cost >= cost_) return;
    path_ = std::move(path);
    cost_ = cost;
  }

  /// The path, if there is one; the caller sets the bound.
  Result result(const Statistics& statistics, std::optional<Status> stop) const {
    Result result;
    result.statistics = statistics;
    result.status = known() ? Status::solved : stop.value_or(Status::exhausted);
    if (!known()) return result;
    result.path = path_;
    result.cost = cost_;
    return result;
  }

 private:
  std::vector<StateId> path_;
  double cost_{infinity};
};

/// Throws InvalidArgument unless `value` is a valid estimate of a cost-to-go; `what` names it.
inline void require_estimate(double value, std::string_view what, StateId s) {
  if (value >= 0.0) return;
  throw InvalidArgument("the " + std::string(what) + " of state " + std::to_string(s) + " is " + to_text(value) +
                        ", it must be 0 or more, or infinity");
}

inline std::string name_of(const Edge& edge) {
  return "the edge from state " + std::to_string(edge.from) + " to " + std::to_string(edge.to);
}

/// Throws InvalidArgument unless the edge's lower bound is finite and more than 0.
inline void require_edge(const Edge& edge) {
  if (edge.cost > 0.0 && edge.cost < infinity) return;
  throw InvalidArgument(name_of(edge) + " has cost " + to_text(edge.cost) + ", it must be finite and more than 0");
}

/// Throws InvalidArgument unless the edge's true cost is no less than its lower bound.
inline void require_evaluation(const Edge& edge, double cost) {
  if (cost >= edge.cost) return;
  throw InvalidArgument(name_of(edge) + " was evaluated to " + to_text(cost) + ", below its lower bound " +
                        to_text(edge.cost));
}

/// The table together with the graph and the heuristic that fill it. `reached(s)` is called whenever the best candidate
/// of s has improved; the search then puts s into its queue or changes its key.
template <Graph G, Heuristic H>
class LazyTree {
 public:
  LazyTree(G& graph, H& heuristic) : graph_(graph), heuristic_(heuristic) {}

  CandidateTable table;
  Statistics statistics;

  template <class Reached>
  void add_starts(std::span<const StateId> starts, Reached&& reached) {
    if (starts.empty()) throw InvalidArgument("the search needs at least one start state");
    for (const StateId s : starts) {
      table.ensure(s);
      if (heuristic(s) < infinity && table.offer(table.add(no_state, s, 0.0, true), 0.0)) reached(s);
    }
  }

  /// Counts it, and tells a graph that wants to know where the committed state comes from.
  void begin_expansion(StateId s) {
    ++statistics.expansions;
    if constexpr (requires { graph_.expanding(s, s); }) graph_.expanding(s, table.edge(table[s].parent).from);
  }

  /// Offers the edges of a committed state, for searches that expand a state at most once.
  template <class Reached>
  void expand_once(StateId s, Reached&& reached) {
    begin_expansion(s);
    generate_successors([this, s](std::vector<Successor>& out) { graph_.successors(s, out); });
    const double cost = table[s].cost;
    for (const Successor& next : successors_) {
      if (admit(s, next) && table.offer_new({s, next.state, next.cost}, cost + next.cost)) reached(next.state);
    }
  }

  /// The same for searches that may expand a state again: edges and their true costs are remembered.
  template <class Reached>
  void expand(StateId s, Reached&& reached) {
    begin_expansion(s);
    CandidateTable::EdgeBlock edges = table[s].edges;
    expand(s, edges, [this, s](std::vector<Successor>& out) { graph_.successors(s, out); }, reached);
    table[s].edges = edges;
  }

  /// The same for a part of the edges, which `generate(out)` appends to `out` when it is called for the first time. No
  /// expansion is counted.
  template <class Generate, class Reached>
  void expand(StateId s, CandidateTable::EdgeBlock& edges, Generate&& generate, Reached&& reached) {
    if (edges.first == no_edge) return expand_first(s, edges, generate, reached);
    for (EdgeId e = edges.first; e < edges.first + edges.count; ++e) offer(s, e, reached);
  }

  /// Evaluates edges in one call to the graph. The caller must requeue the states they lead to.
  void evaluate(std::span<const EdgeId> edges) {
    batch_.clear();
    for (const EdgeId e : edges) batch_.push_back(table.edge(e));
    true_costs_.assign(edges.size(), 0.0);
    graph_.evaluate(std::span<const Edge>(batch_), std::span<double>(true_costs_));
    statistics.evaluations += edges.size();
    for (std::size_t i = 0; i < edges.size(); ++i) {
      require_evaluation(batch_[i], true_costs_[i]);
      table.set_true_cost(edges[i], true_costs_[i]);
    }
  }

  bool is_goal(StateId s) { return graph_.is_goal(s); }

  /// The heuristic of `s`, evaluated once.
  double heuristic(StateId s) {
    if (table[s].heuristic < 0.0) set_heuristic(s, heuristic_(s));
    return table[s].heuristic;
  }

 private:
  template <class Generate>
  void generate_successors(Generate&& generate) {
    successors_.clear();
    generate(successors_);
    statistics.generated += successors_.size();
    if constexpr (BatchHeuristic<H>) evaluate_heuristics();
  }

  /// The heuristics of all new successors in one call.
  void evaluate_heuristics() {
    new_states_.clear();
    for (const Successor& next : successors_) {
      table.ensure(next.state);
      if (table[next.state].heuristic < 0.0) new_states_.push_back(next.state);
    }
    if (new_states_.empty()) return;
    values_.assign(new_states_.size(), 0.0);
    heuristic_.values(std::span<const StateId>(new_states_), std::span<double>(values_));
    for (std::size_t i = 0; i < values_.size(); ++i) set_heuristic(new_states_[i], values_[i]);
  }

  void set_heuristic(StateId s, double h) {
    require_estimate(h, "heuristic", s);
    table[s].heuristic = h;
  }

  /// Checks a successor; false when the heuristic prunes it.
  bool admit(StateId from, const Successor& next) {
    require_edge({from, next.state, next.cost});
    table.ensure(next.state);
    return heuristic(next.state) < infinity;
  }

  template <class Generate, class Reached>
  void expand_first(StateId s, CandidateTable::EdgeBlock& edges, Generate&& generate, Reached&& reached) {
    generate_successors(generate);
    edges = {.first = 0, .count = 0};  // generated, though perhaps there are none
    for (const Successor& next : successors_) {
      if (!admit(s, next)) continue;
      const EdgeId e = table.add(s, next.state, next.cost);
      if (edges.count++ == 0) edges.first = e;
      offer(s, e, reached);
    }
  }

  template <class Reached>
  void offer(StateId s, EdgeId e, Reached&& reached) {
    const Edge edge = table.edge(e);
    if (edge.cost < infinity && table.offer(e, table[s].cost + edge.cost)) reached(edge.to);
  }

  G& graph_;
  H& heuristic_;
  std::vector<Successor> successors_;
  std::vector<StateId> new_states_;
  std::vector<double> values_;
  std::vector<Edge> batch_;
  std::vector<double> true_costs_;
};

using srmp::stop_status;

/// The tighter of what the algorithm guarantees and what the search has shown: no path costs less than `lower`.
inline double proven_bound(double guaranteed, double cost, double lower) {
  if (cost <= lower) return 1.0;
  return std::clamp(cost / lower, 1.0, guaranteed);
}

/// Throws InvalidArgument unless `weight` is finite and >= 1; `what` names it.
inline void require_weight(double weight, std::string_view what) {
  if (weight >= 1.0 && weight < infinity) return;
  throw InvalidArgument(std::string(what) + " is " + to_text(weight) + ", it must be finite and at least 1");
}

}  // namespace srmp::search
