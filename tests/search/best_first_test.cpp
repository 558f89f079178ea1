#include "srmp/search/best_first.hpp"

#include <map>
#include <set>

#include "search/graphs.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// Weighted A* on a graph with lazy edges: a node whose edge costs more is put back at its true cost.
class GraphSearch {
 public:
  struct Node {
    StateId state;
    double cost;
    bool evaluated;
  };

  GraphSearch(Problem& problem, double weight) : problem_(problem), weight_(weight) {}

  BestFirstResult run(const Deadline& deadline = {}) {
    for (const StateId s : problem_.starts) add({s, 0.0, true}, no_node);
    return nodes.run(*this, deadline);
  }

  bool is_dominated(const Node& node) const { return closed_.dominates(node.state, node.cost); }
  bool is_valid(NodeId id) {
    Node node = nodes[id];
    if (node.evaluated) return true;
    const NodeId parent = nodes.parent(id);
    node.cost = nodes[parent].cost + problem_.graph.find(nodes[parent].state, node.state)->cost;
    if (node.cost == nodes[id].cost) return true;
    node.evaluated = true;
    if (node.cost < infinity) add(node, parent);
    return false;
  }
  void close(const Node& node) {
    closed_.close(node.state, node.cost);
    order.push_back(node.state);
  }
  bool is_goal(const Node& node) const { return problem_.graph.is_goal(node.state); }
  bool may_continue() const { return nodes.size() < max_nodes; }
  bool may_expand(std::uint64_t expansions) const { return expansions <= max_expansions; }
  void expand(NodeId id) {
    const Node from = nodes[id];
    for (const Arc& arc : problem_.graph.arcs[from.state]) add({arc.to, from.cost + arc.lower, false}, id);
  }

  BestFirstSearch<Node, double> nodes;
  std::vector<StateId> order;  // in which states were closed
  std::size_t max_nodes = std::numeric_limits<std::size_t>::max();
  std::uint64_t max_expansions = std::numeric_limits<std::uint64_t>::max();

 private:
  void add(const Node& node, NodeId parent) {
    if (problem_.h[node.state] < infinity) nodes.add(node, node.cost + weight_ * problem_.h[node.state], parent);
  }

  Problem& problem_;
  double weight_;
  ClosedCosts<std::map<StateId, double>> closed_;
};

/// The order in which a plain implementation of the same search closes states.
std::vector<StateId> plain_order(Problem& problem, double weight) {
  struct Item {
    StateId state, from;
    double from_cost, cost;
    bool evaluated;
  };
  std::vector<Item> items;
  std::vector<double> keys;
  std::set<std::size_t> open;
  std::map<StateId, double> closed;
  std::vector<StateId> order;
  const auto add = [&](const Item& item) {
    if (problem.h[item.state] == infinity) return;
    open.insert(items.size());
    items.push_back(item);
    keys.push_back(item.cost + weight * problem.h[item.state]);
  };
  for (const StateId s : problem.starts) add({s, no_state, 0.0, 0.0, true});
  while (!open.empty()) {
    std::size_t best = *open.begin();
    for (const std::size_t i : open)
      if (keys[i] < keys[best]) best = i;
    open.erase(best);
    Item item = items[best];
    if (closed.contains(item.state) && closed[item.state] <= item.cost) continue;
    if (!item.evaluated) {
      const Arc& arc = *problem.graph.find(item.from, item.state);
      if (arc.cost != arc.lower) {
        item.cost = item.from_cost + arc.cost;
        item.evaluated = true;
        if (arc.cost < infinity) add(item);
        continue;
      }
    }
    closed[item.state] = item.cost;
    order.push_back(item.state);
    if (problem.graph.is_goal(item.state)) break;
    for (const Arc& arc : problem.graph.arcs[item.state])
      add({arc.to, item.state, item.cost, item.cost + arc.lower, false});
  }
  return order;
}

}  // namespace

BOOST_AUTO_TEST_CASE(best_first_search_keeps_its_bound_on_random_problems) {
  unsigned solved = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed)
    for (const double weight : {1.0, 1.7, 20.0}) BOOST_TEST_CONTEXT("seed " << seed << ", weight " << weight) {
        Problem problem = random_problem(seed);
        GraphSearch search(problem, weight);
        const BestFirstResult result = search.run();
        const double optimum = problem.optimum();
        BOOST_REQUIRE((result.status == Status::solved) == (optimum < infinity));
        if (result.status != Status::solved) {
          BOOST_REQUIRE(result.status == Status::exhausted && result.goal == no_node);
          continue;
        }
        ++solved;
        BOOST_REQUIRE_LE(search.nodes[result.goal].cost, weight * optimum * (1.0 + 1e-12));
        const std::vector<NodeId> path = search.nodes.path_to(result.goal);
        double cost = 0.0;
        for (std::size_t i = 1; i < path.size(); ++i) {
          const Arc* arc = problem.graph.find(search.nodes[path[i - 1]].state, search.nodes[path[i]].state);
          BOOST_REQUIRE(arc);
          cost += arc->cost;
        }
        BOOST_REQUIRE_EQUAL(cost, search.nodes[result.goal].cost);
        BOOST_REQUIRE(search.nodes.parent(path.front()) == no_node);
      }
  BOOST_TEST(solved > random_problems);
}

BOOST_AUTO_TEST_CASE(best_first_search_closes_states_in_the_plain_order) {
  for (unsigned seed = 0; seed < random_problems; ++seed)  // many with ties
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      GraphSearch search(problem, 2.0);
      search.run();
      BOOST_REQUIRE(search.order == plain_order(problem, 2.0));
    }
}

BOOST_AUTO_TEST_CASE(nodes_of_equal_keys_are_first_in_first_out) {
  Problem star{TestGraph(5), {0}, std::vector<double>(5, 0.0)};
  for (const StateId to : {3u, 1u, 4u, 2u}) star.graph.add(0, to, 1.0);
  GraphSearch search(star, 1.0);
  BOOST_TEST((search.run().status == Status::exhausted));
  BOOST_TEST((search.order == std::vector<StateId>{0, 3, 1, 4, 2}));
}

BOOST_AUTO_TEST_CASE(a_search_ends_when_its_budget_is_used_up) {
  Problem problem = corridor();
  GraphSearch few_expansions(problem, 1.0);
  few_expansions.max_expansions = 2;
  const BestFirstResult result = few_expansions.run();
  BOOST_TEST((result.status == Status::timed_out));
  BOOST_TEST(result.expansions == 2u);  // the third was refused
  BOOST_TEST((few_expansions.order == std::vector<StateId>{0, 1, 2}));
  GraphSearch few_nodes(problem, 1.0);
  few_nodes.max_nodes = 2;
  BOOST_TEST((few_nodes.run().status == Status::timed_out));
  BOOST_TEST((few_nodes.order == std::vector<StateId>{0}));
}

BOOST_AUTO_TEST_CASE(a_search_stops_at_the_deadline_and_when_cancelled) {
  Problem problem = corridor(), broken = broken_bridge();
  for (Problem* any : {&problem, &broken}) {
    BOOST_TEST((GraphSearch(*any, 1.0).run(Deadline(0.0)).status == Status::timed_out));
    BOOST_TEST((GraphSearch(*any, 1.0).run(Deadline(1e9, [] { return true; })).status == Status::cancelled));
  }
  problem.starts.clear();
  BOOST_TEST((GraphSearch(problem, 1.0).run(Deadline(0.0)).status == Status::timed_out));
  BOOST_TEST((GraphSearch(problem, 1.0).run().status == Status::exhausted));
}

BOOST_AUTO_TEST_CASE(memory_of_a_search_counts_its_nodes) {
  Problem problem = corridor();
  GraphSearch search(problem, 1.0);
  search.run();
  BOOST_TEST(search.nodes.memory() >= search.nodes.size() * sizeof(GraphSearch::Node));
}
