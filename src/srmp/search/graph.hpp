#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/core/status.hpp"

/// Graph search. Nothing here knows what a robot is; everything here is tested on grids and random graphs.
namespace srmp::search {

/// States are numbered 0, 1, 2, … in the order in which the graph first hands them out.
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
/// - successors(s, out) appends s's outgoing edges to `out`, always in the same order; parallel edges and self-loops
///   are not handed out.
/// - evaluate(edges, costs) writes each edge's true cost: Edge::cost or more; infinity when there is no such edge after
///   all. Expensive. Batches let the graph use lanes and threads; an edge's answer never depends on its batch.
/// - is_goal(s) is cheap.
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

struct Statistics {
  std::uint64_t expansions{};
  std::uint64_t generated{};    ///< successors handed out
  std::uint64_t evaluations{};  ///< edges evaluated
  std::uint64_t memory{};       ///< bytes of the search's tables and queues, which only grow: the most it held
};

struct Result {
  Status status{Status::exhausted};  ///< solved, exhausted, timed_out or cancelled
  std::vector<StateId> path;         ///< start … goal; empty unless solved
  double cost{infinity};             ///< of path
  double bound{infinity};            ///< proven: cost <= bound * optimal cost in this graph
  Statistics statistics;
};

}  // namespace srmp::search
