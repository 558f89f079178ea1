#include "srmp/search/dijkstra.hpp"

#include <tuple>

#include "search/graphs.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// Costs-to-go by relaxing every edge until nothing changes (Bellman, Ford).
template <class Cost, class CostOf>
std::vector<Cost> bellman_ford(const TestGraph& graph, const std::vector<StateId>& goals, CostOf&& cost_of) {
  std::vector<Cost> costs(graph.arcs.size(), unreachable<Cost>);
  for (const StateId goal : goals) costs[goal] = Cost{};
  for (bool changed = true; changed;) {
    changed = false;
    for (StateId s = 0; s < graph.arcs.size(); ++s)
      for (const Arc& arc : graph.arcs[s]) {
        if (costs[arc.to] == unreachable<Cost>) continue;
        const Cost cost = costs[arc.to] + static_cast<Cost>(cost_of(arc));
        if (cost >= costs[s]) continue;
        costs[s] = cost;
        changed = true;
      }
  }
  return costs;
}

template <class Cost, class CostOf>
std::vector<Cost> costs_of(const TestGraph& graph, const std::vector<StateId>& goals, CostOf&& cost_of,
                           const Deadline& deadline = {}) {
  std::vector<std::vector<std::pair<StateId, Cost>>> backward(graph.arcs.size());
  for (StateId s = 0; s < graph.arcs.size(); ++s)
    for (const Arc& arc : graph.arcs[s]) backward[arc.to].emplace_back(s, static_cast<Cost>(cost_of(arc)));
  const auto predecessors = [&](StateId to, auto&& relax) {
    for (const auto& [from, cost] : backward[to]) relax(from, cost);
  };
  return costs_to_go<Cost>(graph.arcs.size(), goals, predecessors, deadline);
}

std::vector<StateId> goals_of(const TestGraph& graph) {
  std::vector<StateId> goals;
  for (StateId s = 0; s < graph.goals.size(); ++s)
    if (graph.goals[s]) goals.push_back(s);
  return goals;
}

}  // namespace

BOOST_AUTO_TEST_CASE(costs_to_go_are_those_of_brute_force_on_random_graphs) {
  const auto whole = [](const Arc& arc) { return static_cast<int>(10.0 * arc.lower); };
  std::size_t reachable = 0, isolated = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      const TestGraph graph = random_problem(seed).graph;
      const std::vector<StateId> goals = goals_of(graph);
      const std::vector<double> costs = costs_of<double>(graph, goals, lower_of);
      BOOST_TEST((costs == bellman_ford<double>(graph, goals, lower_of)));
      BOOST_TEST((costs_of<int>(graph, goals, whole) == bellman_ford<int>(graph, goals, whole)));
      for (const double cost : costs) ++(cost < infinity ? reachable : isolated);
    }
  }
  BOOST_TEST(reachable > 1000u);
  BOOST_TEST(isolated > 1000u);
}

BOOST_AUTO_TEST_CASE(costs_to_go_without_goals_are_unreachable) {
  const TestGraph graph = corridor().graph;
  BOOST_TEST((costs_of<double>(graph, {}, lower_of) == std::vector<double>(5, infinity)));
  BOOST_TEST((costs_of<int>(graph, {}, lower_of) == std::vector<int>(5, std::numeric_limits<int>::max())));
}

BOOST_AUTO_TEST_CASE(costs_to_go_stop_at_the_deadline_with_upper_bounds) {
  const TestGraph graph = corridor().graph;
  const std::vector<double> expected{infinity, infinity, infinity, infinity, 0.0};
  BOOST_TEST((costs_of<double>(graph, {4}, lower_of, Deadline(0.0)) == expected));
}
