#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/core/status.hpp"

/// Graph search. Nothing here knows what a robot is; everything here is tested on grids and random graphs.
namespace srmp::search {

/// States are numbered 0, 1, 2, … in the order in which the graph generates them.
using StateId = std::uint32_t;
inline constexpr StateId no_state = std::numeric_limits<StateId>::max();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

struct Successor {
  StateId state{no_state};
  double cost{};  ///< lower bound of the edge's cost: > 0, finite
};

struct Edge {
  StateId from{no_state};
  StateId to{no_state};
  double cost{};  ///< the Successor's cost
};

/// An implicit directed graph with lazily evaluated edges.
/// - successors(s, out) appends s's outgoing edges to `out`, always in the same order, without parallel edges and
///   self-loops.
/// - evaluate(edges, costs) writes each edge's true cost: Edge::cost or more; infinity when the edge does not exist
///   after all. Expensive. Batches let the graph use SIMD lanes and threads; an edge's cost never depends on its batch.
/// - is_goal(s) is cheap.
/// Optional: expanding(s, parent), called before s is expanded, with the state from which it was reached (no_state for
/// a start).
template <class G>
concept Graph =
    requires(G& graph, StateId s, std::vector<Successor>& out, std::span<const Edge> edges, std::span<double> costs) {
      { graph.successors(s, out) } -> std::same_as<void>;
      { graph.evaluate(edges, costs) } -> std::same_as<void>;
      { graph.is_goal(s) } -> std::convertible_to<bool>;
    };

/// Estimated cost from a state to the nearest goal: >= 0, finite or infinity ("no goal from here"), 0 at goals.
template <class H>
concept Heuristic = requires(H& heuristic, StateId s) {
  { heuristic(s) } -> std::convertible_to<double>;
};

/// A heuristic that is evaluated for many states in one call: the searches do so for all successors of an expansion.
/// values(states, out) writes heuristic(s) of each state.
template <class H>
concept BatchHeuristic =
    Heuristic<H> && requires(H& heuristic, std::span<const StateId> states, std::span<double> out) {
      { heuristic.values(states, out) } -> std::same_as<void>;
    };

/// A heuristic given by a function: of one state, or of many, whose values it writes.
class AnyHeuristic {
 public:
  AnyHeuristic() = default;
  template <class F>
    requires std::is_invocable_v<F&, std::span<const StateId>, std::span<double>>
  AnyHeuristic(F many) : values_(std::move(many)) {}
  template <class F>
    requires std::is_invocable_r_v<double, F&, StateId>
  AnyHeuristic(F one)
      : values_([one = std::move(one)](std::span<const StateId> states, std::span<double> out) {
          for (std::size_t i = 0; i < states.size(); ++i) out[i] = one(states[i]);
        }) {}

  explicit operator bool() const { return static_cast<bool>(values_); }
  void values(std::span<const StateId> states, std::span<double> out) const { values_(states, out); }
  double operator()(StateId s) const {
    double value = 0.0;
    values({&s, 1}, {&value, 1});
    return value;
  }

 private:
  std::function<void(std::span<const StateId>, std::span<double>)> values_;
};

struct Statistics {
  std::uint64_t expansions{};
  std::uint64_t generated{};    ///< successors generated
  std::uint64_t evaluations{};  ///< edges evaluated
  std::uint64_t memory{};       ///< peak bytes of the search's tables and queues
};

struct Result {
  Status status{Status::exhausted};  ///< solved, exhausted, timed_out or cancelled
  std::vector<StateId> path;         ///< start … goal; empty unless solved
  double cost{infinity};             ///< of path
  double bound{infinity};            ///< proven: cost <= bound * optimal cost in this graph
  Statistics statistics;
};

}  // namespace srmp::search
