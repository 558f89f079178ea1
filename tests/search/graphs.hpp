#pragma once

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <queue>
#include <random>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "srmp/search/graph.hpp"

/// Graphs for the search tests, and brute force to check the results against.
namespace srmp::search::test {

struct Arc {
  StateId to{no_state};
  double lower{};     ///< as successors() has it
  double cost{};      ///< the true cost; infinity: no such edge
  int evaluations{};  ///< times evaluated
};

/// A graph written out. Evaluates with `threads` threads, each its own part of the batch.
struct TestGraph {
  std::vector<std::vector<Arc>> arcs;
  std::vector<char> goals;
  unsigned threads{1};

  explicit TestGraph(std::size_t states = 0) : arcs(states), goals(states, 0) {}

  TestGraph& add(StateId from, StateId to, double lower, double cost) {
    arcs[from].push_back({to, lower, cost});
    return *this;
  }
  TestGraph& add(StateId from, StateId to, double cost) { return add(from, to, cost, cost); }

  Arc* find(StateId from, StateId to) {
    for (Arc& arc : arcs[from]) {
      if (arc.to == to) return &arc;
    }
    return nullptr;
  }

  void successors(StateId s, std::vector<Successor>& out) const {
    for (const Arc& arc : arcs[s]) out.push_back({arc.to, arc.lower});
  }

  void evaluate(std::span<const Edge> edges, std::span<double> costs) {
    const auto part = [&](unsigned first) {
      for (std::size_t i = first; i < edges.size(); i += threads) costs[i] = find(edges[i].from, edges[i].to)->cost;
    };
    std::vector<std::thread> helpers;
    for (unsigned t = 1; t < threads; ++t) helpers.emplace_back(part, t);
    part(0);
    for (std::thread& helper : helpers) helper.join();
    for (const Edge& edge : edges) {
      Arc& arc = *find(edge.from, edge.to);
      ++arc.evaluations;
      BOOST_REQUIRE_EQUAL(arc.lower, edge.cost);
    }
  }

  bool is_goal(StateId s) const { return goals[s]; }

  int max_evaluations() const {
    int maximum = 0;
    for (const auto& out : arcs) {
      for (const Arc& arc : out) maximum = std::max(maximum, arc.evaluations);
    }
    return maximum;
  }
};

/// Distances from `sources` over the costs that `cost_of(arc)` gives; against the direction of the edges if
/// `backwards`.
template <class CostOf>
std::vector<double> dijkstra(const TestGraph& graph, const std::vector<StateId>& sources, CostOf&& cost_of,
                             bool backwards = false) {
  std::vector<std::vector<std::pair<StateId, double>>> out(graph.arcs.size());
  for (StateId s = 0; s < graph.arcs.size(); ++s) {
    for (const Arc& arc : graph.arcs[s]) {
      out[backwards ? arc.to : s].emplace_back(backwards ? s : arc.to, cost_of(arc));
    }
  }
  std::vector<double> distance(graph.arcs.size(), infinity);
  std::priority_queue<std::pair<double, StateId>, std::vector<std::pair<double, StateId>>, std::greater<>> queue;
  for (const StateId s : sources) queue.emplace(distance[s] = 0.0, s);
  while (!queue.empty()) {
    const auto [d, s] = queue.top();
    queue.pop();
    if (d > distance[s]) continue;
    for (const auto& [to, cost] : out[s]) {
      if (d + cost < distance[to]) queue.emplace(distance[to] = d + cost, to);
    }
  }
  return distance;
}

inline double lower_of(const Arc& arc) { return arc.lower; }
inline double cost_of(const Arc& arc) { return arc.cost; }

/// A graph, where to start, and a consistent heuristic: a fraction of the cost-to-go over the lower bounds.
struct Problem {
  TestGraph graph;
  std::vector<StateId> starts;
  std::vector<double> h;

  double operator()(StateId s) const { return h[s]; }  // a Heuristic

  void set_heuristic(double fraction) {
    std::vector<StateId> goals;
    for (StateId s = 0; s < graph.goals.size(); ++s) {
      if (graph.goals[s]) goals.push_back(s);
    }
    h = dijkstra(graph, goals, lower_of, true);
    for (double& value : h) value = value < infinity ? fraction * value : infinity;
  }

  double optimum() const {
    const std::vector<double> distance = dijkstra(graph, starts, cost_of);
    double best = infinity;
    for (StateId s = 0; s < distance.size(); ++s) {
      if (graph.goals[s]) best = std::min(best, distance[s]);
    }
    return best;
  }
};

/// Dice with the same numbers everywhere (the distributions of <random> differ between libraries).
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  unsigned below(unsigned n) { return static_cast<unsigned>(engine_() % n); }
  double unit() { return static_cast<double>(engine_()) / 4294967296.0; }
  bool chance(double p) { return unit() < p; }

 private:
  std::mt19937 engine_;
};

/// The true cost of an edge with this lower bound: mostly the same, sometimes more, sometimes no edge at all.
inline double true_cost(Dice& dice, double lower, double costlier, double missing) {
  if (dice.chance(missing)) return infinity;
  return dice.chance(costlier) ? lower * (1.0 + 3.0 * dice.unit()) : lower;
}

/// 5 to 80 states with a few edges each; whole-numbered costs (many ties) or not; often without a path.
inline Problem random_digraph(unsigned seed) {
  Dice dice(seed);
  const unsigned n = 5 + dice.below(76), degree = 1 + dice.below(5);
  const bool ties = dice.chance(0.5);
  const double costlier = 0.4 * dice.unit(), missing = 0.3 * dice.unit();
  Problem problem{TestGraph(n), {}, {}};
  for (StateId s = 0; s < n; ++s) {
    for (unsigned k = 0; k < degree; ++k) {
      const StateId to = dice.below(n);
      const double lower = ties ? 1.0 + dice.below(4) : 0.1 + 9.9 * dice.unit();
      if (to != s && !problem.graph.find(s, to)) {
        problem.graph.add(s, to, lower, true_cost(dice, lower, costlier, missing));
      }
    }
  }
  for (unsigned k = 0; k <= dice.below(3); ++k) problem.starts.push_back(dice.below(n));
  for (unsigned k = 0; k <= dice.below(3); ++k) problem.graph.goals[dice.below(n)] = 1;
  problem.set_heuristic(dice.chance(0.2) ? 0.0 : dice.unit());
  return problem;
}

/// A 4- or 8-connected grid of up to 14 x 14 cells. Walls show in successors() or only when an edge is evaluated.
inline Problem random_grid(unsigned seed) {
  Dice dice(seed);
  const int width = 2 + static_cast<int>(dice.below(13)), height = 2 + static_cast<int>(dice.below(13));
  const bool eight = dice.chance(0.5), hidden = dice.chance(0.7);
  const double walls = 0.45 * dice.unit(), costlier = dice.chance(0.5) ? 0.3 : 0.0;
  std::vector<char> wall(static_cast<std::size_t>(width * height));
  for (char& cell : wall) cell = dice.chance(walls);
  Problem problem{TestGraph(wall.size()), {0}, {}};
  wall[0] = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int step = 0; step < 9; ++step) {
        const int dx = step % 3 - 1, dy = step / 3 - 1, nx = x + dx, ny = y + dy;
        if ((dx == 0 && dy == 0) || (!eight && dx != 0 && dy != 0)) continue;
        if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
        const StateId to = static_cast<StateId>(ny * width + nx);
        if (wall[to] && !hidden) continue;
        const double lower = std::hypot(dx, dy);
        const double cost = wall[to] ? infinity : true_cost(dice, lower, costlier, 0.0);
        problem.graph.add(static_cast<StateId>(y * width + x), to, lower, cost);
      }
    }
  }
  problem.graph.goals.back() = 1;
  problem.set_heuristic(dice.chance(0.5) ? 1.0 : dice.unit());
  return problem;
}

inline constexpr unsigned random_problems = 600;
inline Problem random_problem(unsigned seed) { return seed % 2 ? random_digraph(seed) : random_grid(seed); }

/// 0 -1- 1 -1- 2 -1- 3 -1- 4*    (both ways; * is the goal)
inline Problem corridor() {
  Problem problem{TestGraph(5), {0}, {}};
  for (StateId s = 0; s < 4; ++s) problem.graph.add(s, s + 1, 1.0).add(s + 1, s, 1.0);
  problem.graph.goals[4] = 1;
  problem.set_heuristic(1.0);
  return problem;
}

///      1?         1?: lower bound 1, costs 9
///  0 ----> 2 -1-> 3*
///   \-1-> 1 -1.5-^2
inline Problem false_shortcut(double true_cost) {
  Problem problem{TestGraph(4), {0}, {}};
  problem.graph.add(0, 2, 1.0, true_cost).add(0, 1, 1.0).add(1, 2, 1.5).add(2, 3, 1.0);
  problem.graph.goals[3] = 1;
  problem.set_heuristic(1.0);
  return problem;
}

/// 0 -1-> 1 -1?-> 2*    1?: does not exist
inline Problem broken_bridge() {
  Problem problem{TestGraph(3), {0}, {}};
  problem.graph.add(0, 1, 1.0).add(1, 2, 1.0, infinity);
  problem.graph.goals[2] = 1;
  problem.set_heuristic(1.0);
  return problem;
}

/// A solved result is a path of this problem and keeps its bound; an unsolved one has none.
inline void check_result(Problem& problem, const Result& result, double guaranteed_bound) {
  const double optimum = problem.optimum();
  if (optimum == infinity) {
    BOOST_REQUIRE(result.status == Status::exhausted);
    BOOST_REQUIRE(result.path.empty());
    BOOST_REQUIRE_EQUAL(result.cost, infinity);
    return;
  }
  BOOST_REQUIRE(result.status == Status::solved);
  BOOST_REQUIRE(std::ranges::count(problem.starts, result.path.front()) > 0);
  BOOST_REQUIRE(problem.graph.is_goal(result.path.back()));
  double cost = 0.0;
  for (std::size_t i = 0; i + 1 < result.path.size(); ++i) {
    const Arc* arc = problem.graph.find(result.path[i], result.path[i + 1]);
    BOOST_REQUIRE(arc != nullptr);
    BOOST_REQUIRE(arc->evaluations > 0);
    cost += arc->cost;
  }
  BOOST_REQUIRE_EQUAL(cost, result.cost);
  BOOST_REQUIRE_GE(result.bound, 1.0);
  BOOST_REQUIRE_LE(result.bound, guaranteed_bound);
  BOOST_REQUIRE_LE(result.cost, result.bound * optimum * (1.0 + 1e-12));
}

inline void check_same(const Result& a, const Result& b) {
  BOOST_REQUIRE(a.status == b.status);
  BOOST_REQUIRE(a.path == b.path);
  BOOST_REQUIRE_EQUAL(a.cost, b.cost);
  BOOST_REQUIRE_EQUAL(a.bound, b.bound);
  BOOST_REQUIRE_EQUAL(a.statistics.expansions, b.statistics.expansions);
  BOOST_REQUIRE_EQUAL(a.statistics.generated, b.statistics.generated);
  BOOST_REQUIRE_EQUAL(a.statistics.evaluations, b.statistics.evaluations);
  BOOST_REQUIRE_EQUAL(a.statistics.memory, b.statistics.memory);
}

}  // namespace srmp::search::test
