#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "srmp/core/deadline.hpp"

namespace srmp::search {

/// The cost of a vertex from which no goal can be reached: infinity, or the largest number where there is none.
template <class Cost>
inline constexpr Cost unreachable =
    std::numeric_limits<Cost>::has_infinity ? std::numeric_limits<Cost>::infinity() : std::numeric_limits<Cost>::max();

/// Costs-to-go on an explicit graph: of every vertex 0 … `vertices` - 1, the cost of the cheapest path from it to the
/// nearest of the `goals` (0 at goals, `unreachable<Cost>` where there is no path).
///
/// Paper: Dijkstra 1959, "A Note on Two Problems in Connexion with Graphs", from all goals at once against the
/// direction of the edges. Guarantee: costs are exact (for floating-point costs, sums in the order from the goal); once
/// the deadline has passed they are upper bounds only. O(edges * log(edges)), deterministic.
/// Needs: `predecessors(v, relax)` calls relax(u, cost) for every edge from u to v, with cost >= 0 such that sums do
/// not overflow.
template <class Cost, class Predecessors>
std::vector<Cost> costs_to_go(std::size_t vertices, std::span<const std::uint32_t> goals, Predecessors&& predecessors,
                              const Deadline& deadline = {}) {
  using Entry = std::pair<Cost, std::uint32_t>;
  std::vector<Cost> costs(vertices, unreachable<Cost>);
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto reach = [&](std::uint32_t vertex, Cost cost) {
    if (cost >= costs[vertex]) return;
    costs[vertex] = cost;
    open.emplace(cost, vertex);
  };
  for (const std::uint32_t goal : goals) reach(goal, Cost{});
  while (!open.empty() && !deadline.stop_requested()) {
    const auto [cost, vertex] = open.top();
    open.pop();
    if (cost > costs[vertex]) continue;  // a cheaper path to it was found after this entry
    predecessors(vertex, [&, base = cost](std::uint32_t from, Cost edge) { reach(from, base + edge); });
  }
  return costs;
}

}  // namespace srmp::search
