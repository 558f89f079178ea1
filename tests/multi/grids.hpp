#pragma once

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "search/graphs.hpp"
#include "srmp/multi/conflict_search.hpp"

/// Worlds of agents for the tests, and brute force to check the results against.
namespace srmp::multi::test {

using search::infinity;
using search::test::Dice;
using search::test::Problem;
using search::test::TestGraph;

inline std::uint64_t mixed(std::initializer_list<std::uint64_t> values) {
  std::uint64_t hash = 0;
  for (const std::uint64_t value : values) {
    hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

/// A problem of the search tests whose edges take `min_steps` to `max_steps` steps.
struct TestAgent : Agent {
  Problem problem;
  int min_steps{1}, max_steps{1};
  double wait{1.0};
  std::vector<double> inadmissible_heuristics;  ///< by state; empty: the heuristic
  std::vector<std::vector<double>> costs;       ///< of the cheapest paths between states; empty: not known
  std::vector<std::vector<int>> steps;          ///< of the quickest ones

  explicit TestAgent(Problem p) : problem(std::move(p)) {}

  StateId start() override { return problem.starts.front(); }
  void successors(StateId s, std::vector<search::Successor>& out) override { problem.graph.successors(s, out); }
  double evaluate(StateId from, StateId to) override { return problem.graph.find(from, to)->cost; }
  bool is_goal(StateId s) override { return problem.graph.is_goal(s); }
  double heuristic(StateId s) override { return problem.h[s]; }
  double inadmissible_heuristic(StateId s) override {
    return inadmissible_heuristics.empty() ? problem.h[s] : inadmissible_heuristics[s];
  }
  int duration(StateId from, StateId to) override {
    return min_steps + static_cast<int>(mixed({from, to}) % static_cast<std::uint64_t>(max_steps - min_steps + 1));
  }
  double wait_cost() override { return wait; }
  double lower_cost(StateId from, StateId to) override { return costs.empty() ? 0.0 : costs[from][to]; }
  int lower_steps(StateId from, StateId to) override { return steps.empty() ? 0 : steps[from][to]; }

  /// By Floyd and Warshall.
  void set_lower_bounds() {
    const std::size_t count = problem.h.size();
    costs.assign(count, std::vector<double>(count, infinity));
    steps.assign(count, std::vector<int>(count, 1'000));
    for (StateId s = 0; s < count; ++s) {
      costs[s][s] = steps[s][s] = 0;
      for (const auto& arc : problem.graph.arcs[s]) {
        if (arc.cost == infinity) continue;
        costs[s][arc.to] = arc.cost;
        steps[s][arc.to] = duration(s, arc.to);
      }
    }
    for (StateId via = 0; via < count; ++via)
      for (StateId a = 0; a < count; ++a)
        for (StateId b = 0; b < count; ++b) {
          costs[a][b] = std::min(costs[a][b], costs[a][via] + costs[via][b]);
          steps[a][b] = std::min(steps[a][b], steps[a][via] + steps[via][b]);
        }
  }
};

/// What an agent does during a step: it is on an edge, or at a state (from == to).
struct Place {
  StateId from{}, to{};
};

/// Agents that collide if two of them are at certain places in the same step.
struct TestWorld : World {
  std::vector<TestAgent> agents;

  /// Do the two collide if they are there in the same step? Symmetric.
  virtual bool collide(std::size_t a, Place in_a, std::size_t b, Place in_b) const = 0;

  std::size_t size() const override { return agents.size(); }
  Agent& agent(std::size_t i) override { return agents[i]; }
  bool may_conflict(std::size_t, std::size_t) const override { return true; }
  bool in_conflict(std::size_t a, const Move& in_a, std::size_t b, const Move& in_b) override {
    const auto [first, last] = overlap(in_a, in_b);
    return first < last && collide(a, {in_a.from, in_a.to}, b, {in_b.from, in_b.to});
  }
};

/// Cells of a 4-connected grid, numbered by rows; edges and waits cost 1 and take 1 step. Two agents may not be at the
/// same cell, nor swap cells.
struct GridWorld : TestWorld {
  bool collide(std::size_t, Place a, std::size_t, Place b) const override {
    return a.to == b.to || a.from == b.from || (a.from == b.to && a.to == b.from);
  }
};

/// A grid drawn in rows: '#' is a wall, a letter an agent's start, and the same letter in `goals` its goal.
inline GridWorld grid(const std::vector<std::string>& starts, const std::vector<std::string>& goals) {
  const int height = static_cast<int>(starts.size()), width = static_cast<int>(starts.front().size());
  TestGraph graph(static_cast<std::size_t>(width * height));
  const auto free = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < width && y < height &&
           starts[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] != '#';
  };
  const auto cell = [&](int x, int y) { return static_cast<StateId>(y * width + x); };
  std::map<char, StateId> from, to;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!free(x, y)) continue;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}})
        if (free(x + dx, y + dy)) graph.add(cell(x, y), cell(x + dx, y + dy), 1.0);
      const auto row = static_cast<std::size_t>(y), column = static_cast<std::size_t>(x);
      if (std::isalpha(starts[row][column])) from[starts[row][column]] = cell(x, y);
      if (std::isalpha(goals[row][column])) to[goals[row][column]] = cell(x, y);
    }
  }
  GridWorld world;
  for (const auto& [name, start] : from) {
    Problem problem{graph, {start}, {}};
    problem.graph.goals[to.at(name)] = 1;
    problem.set_heuristic(1.0);
    world.agents.emplace_back(std::move(problem));
  }
  return world;
}

/// `count` agents in a grid; a fraction of about `walls` of the cells where none starts or ends is walls.
inline GridWorld random_grid(Dice& dice, unsigned width, unsigned height, unsigned count, double walls) {
  std::vector<std::string> starts(height, std::string(width, '.')), goals = starts;
  for (std::vector<std::string>* rows : {&starts, &goals}) {
    for (unsigned i = 0; i < count;) {
      char& cell = (*rows)[dice.below(height)][dice.below(width)];
      if (cell == '.') cell = static_cast<char>('a' + i++);
    }
  }
  for (unsigned y = 0; y < height; ++y) {
    for (unsigned x = 0; x < width; ++x)
      if (starts[y][x] == '.' && goals[y][x] == '.' && dice.chance(walls)) starts[y][x] = '#';
  }
  return grid(starts, goals);
}

/// Each agent its own directed graph, with edges of 1 to 3 steps that may cost more than their lower bounds, or not
/// exist, and its own cost of waiting. Which places collide is random for each pair of agents and of places: a state or
/// an edge against a state or an edge. An edge is one place from its beginning to its end, so that two moves collide
/// if and only if they last in the same step anywhere, and parts of moves collide as whole ones do.
struct RandomWorld : TestWorld {
  unsigned seed{};
  double density{};  ///< fraction of the pairs of places that collide

  static bool strangers(std::size_t a, std::size_t b) { return a + b == 3; }  // 0 and 3, 1 and 2

  bool may_conflict(std::size_t a, std::size_t b) const override { return !strangers(a, b); }
  bool collide(std::size_t a, Place in_a, std::size_t b, Place in_b) const override {
    if (a > b) return collide(b, in_b, a, in_a);
    const std::uint64_t dice = mixed({seed, a, in_a.from, in_a.to, b, in_b.from, in_b.to});
    return !strangers(a, b) && static_cast<double>(dice >> 11) * 0x1p-53 < density;
  }
};

inline RandomWorld random_graphs(unsigned seed) {
  Dice dice(seed);
  RandomWorld world;
  world.seed = seed;
  world.density = 0.3 * dice.unit();
  const bool bounds = dice.chance(0.5);
  const unsigned count = 2 + dice.below(3), states = 10 - 2 * count + dice.below(3);
  const bool ties = dice.chance(0.5);
  for (unsigned i = 0; i < count; ++i) {
    Problem problem{TestGraph(states), {dice.below(states)}, {}};
    for (StateId s = 0; s < states; ++s) {
      for (unsigned k = 0; k < 3; ++k) {
        const StateId to = dice.below(states);
        if (to == s || problem.graph.find(s, to)) continue;
        const double lower = ties ? 1.0 + dice.below(3) : 0.1 + 2.9 * dice.unit();
        problem.graph.add(s, to, lower, search::test::true_cost(dice, lower, 0.3, 0.1));
      }
    }
    for (unsigned k = 0; k <= dice.below(2); ++k) problem.graph.goals[dice.below(states)] = 1;
    problem.set_heuristic(dice.chance(0.2) ? 0.0 : dice.unit());
    world.agents.emplace_back(std::move(problem));
    world.agents.back().max_steps = 3;
    world.agents.back().wait = ties ? 1.0 : 0.1 + dice.unit();
    if (bounds) world.agents.back().set_lower_bounds();
  }
  return world;
}

/// Small enough for brute force, with 2 to 4 agents.
inline std::unique_ptr<TestWorld> random_world(unsigned seed) {
  if (seed % 2) return std::make_unique<RandomWorld>(random_graphs(seed));
  Dice dice(seed);
  const unsigned count = 2 + dice.below(3), side = 7 - count;
  return std::make_unique<GridWorld>(
      random_grid(dice, 2 + dice.below(side), 2 + dice.below(side), count, 0.3 * dice.unit()));
}

/// Gives every agent a random inadmissible heuristic.
inline void set_random_heuristics(TestWorld& world, unsigned seed) {
  Dice dice(seed);
  for (TestAgent& agent : world.agents) {
    for (std::size_t s = 0; s < agent.problem.h.size(); ++s) agent.inadmissible_heuristics.push_back(8.0 * dice.unit());
  }
}

/// The least sum of costs, by Dijkstra's algorithm over the joint states: where each agent is, how many steps of its
/// edge are left, whether it stays for good. Infinity: there is no solution.
class BruteForce {
 public:
  explicit BruteForce(TestWorld& world) : world_(world) {}

  double optimum() {
    std::vector<Stage> start;
    for (TestAgent& agent : world_.agents) start.push_back({{agent.start(), agent.start()}});
    reach(start, 0.0);
    while (!queue_.empty()) {
      const auto [cost, code] = queue_.top();
      queue_.pop();
      if (cost > best_.at(code)) continue;
      const std::vector<Stage> joint = decode(code);
      if (std::ranges::all_of(joint, &Stage::stays)) return cost;
      std::vector<Place> places;
      std::vector<Stage> next;
      step(joint, places, next, cost);
    }
    return infinity;
  }

 private:
  struct Stage {
    Place place;
    unsigned left{};  // steps on the edge
    bool stays{};
  };
  using Entry = std::pair<double, std::uint64_t>;

  static std::uint64_t encode(const std::vector<Stage>& joint) {
    std::uint64_t code = 0;
    for (const Stage& s : joint) {
      code = code << 16 | std::uint64_t{s.place.from} << 9 | std::uint64_t{s.place.to} << 3 |
             std::uint64_t{s.left} << 1 | std::uint64_t{s.stays};
    }
    return code;
  }

  std::vector<Stage> decode(std::uint64_t code) const {
    std::vector<Stage> joint(world_.size());
    for (std::size_t i = joint.size(); i-- > 0; code >>= 16) {
      joint[i] = {{static_cast<StateId>(code >> 9 & 63), static_cast<StateId>(code >> 3 & 63)},
                  static_cast<unsigned>(code >> 1 & 3),
                  (code & 1) != 0};
    }
    return joint;
  }

  void reach(const std::vector<Stage>& joint, double cost) {
    const std::uint64_t code = encode(joint);
    double& best = best_.try_emplace(code, infinity).first->second;
    if (cost < best) queue_.emplace(best = cost, code);
  }

  /// All that the agents from number next.size() on may do in a step, those before them being at `places`.
  void step(const std::vector<Stage>& joint, std::vector<Place>& places, std::vector<Stage>& next, double cost) {
    const std::size_t i = next.size();
    if (i == joint.size()) return reach(next, cost);
    const auto go_on = [&](Place place, unsigned left, bool stays, double more) {
      for (std::size_t k = 0; k < i; ++k)
        if (world_.collide(k, places[k], i, place)) return;
      places.push_back(place);
      next.push_back({left > 0 ? place : Place{place.to, place.to}, left, stays});
      step(joint, places, next, cost + more);
      places.pop_back();
      next.pop_back();
    };
    const Stage& now = joint[i];
    TestAgent& agent = world_.agents[i];
    const StateId at = now.place.to;
    if (now.stays) return go_on(now.place, 0, true, 0.0);
    if (now.left > 0) return go_on(now.place, now.left - 1, false, 0.0);
    if (agent.is_goal(at)) go_on({at, at}, 0, true, 0.0);
    go_on({at, at}, 0, false, agent.wait);
    for (const search::test::Arc& arc : agent.problem.graph.arcs[at]) {
      if (arc.cost < infinity)
        go_on({at, arc.to}, static_cast<unsigned>(agent.duration(at, arc.to) - 1), false, arc.cost);
    }
  }

  TestWorld& world_;
  std::unordered_map<std::uint64_t, double> best_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

/// A random world that has a solution, and its optimal cost.
struct SolvableWorld {
  unsigned seed{};
  double optimum{};
};

/// More than 300 worlds. Those whose solution costs far more than the agents' single-agent paths are left out: a
/// conflict-based search takes time exponential in the difference.
inline const std::vector<SolvableWorld>& solvable_worlds() {
  static const std::vector<SolvableWorld> all = [] {
    std::vector<SolvableWorld> found;
    for (unsigned seed = 0; seed < 500; ++seed) {
      const auto world = random_world(seed);
      double alone = 0.0;
      for (const TestAgent& agent : world->agents) alone += agent.problem.optimum();
      const double optimum = BruteForce(*world).optimum();
      if (optimum < alone + 8.0) found.push_back({seed, optimum});
    }
    BOOST_REQUIRE_GE(found.size(), 300u);
    return found;
  }();
  return all;
}

/// Where an agent is during a step.
inline Place place_at(const TimedPath& path, int step) {
  for (const Move& move : path.moves)
    if (move.start <= step && step < move.end) return {move.from, move.to};
  BOOST_FAIL("nowhere");
  return {};
}

/// A solved result holds collision-free paths of these agents, and its costs are correct.
inline void check_paths(TestWorld& world, const ConflictSearchResult& result) {
  BOOST_REQUIRE(result.status == Status::solved);
  BOOST_REQUIRE_EQUAL(result.paths.size(), world.size());
  int end = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < world.size(); ++i) {
    TestAgent& agent = world.agents[i];
    const TimedPath& path = result.paths[i];
    double cost = 0.0;
    StateId at = agent.start();
    int step = 0;
    for (const Move& move : path.moves) {
      BOOST_REQUIRE_EQUAL(move.from, at);
      BOOST_REQUIRE_EQUAL(move.start, step);
      if (&move == &path.moves.back()) break;
      if (!move.waits()) BOOST_REQUIRE(agent.problem.graph.find(move.from, move.to) != nullptr);
      BOOST_REQUIRE_EQUAL(move.end - move.start, move.waits() ? 1 : agent.duration(move.from, move.to));
      cost += move.waits() ? agent.wait : agent.evaluate(move.from, move.to);
      at = move.to;
      step = move.end;
    }
    BOOST_REQUIRE(path.moves.back().waits());
    BOOST_REQUIRE(path.moves.back().end == forever);
    BOOST_REQUIRE(agent.is_goal(at));
    BOOST_REQUIRE_EQUAL(path.arrival(), step);
    BOOST_REQUIRE_EQUAL(path.cost, cost);
    sum += cost;
    end = std::max(end, step);
  }
  BOOST_REQUIRE_EQUAL(result.cost, sum);
  for (int step = 0; step <= end; ++step) {
    for (std::size_t a = 0; a < world.size(); ++a) {
      for (std::size_t b = a + 1; b < world.size(); ++b)
        BOOST_REQUIRE(!world.collide(a, place_at(result.paths[a], step), b, place_at(result.paths[b], step)));
    }
  }
}

/// The same, and the bound holds: with the optimum, and with the result's own lower bound.
inline void check_result(TestWorld& world, const ConflictSearchResult& result, double bound, double optimum) {
  check_paths(world, result);
  constexpr double eps = 1e-9;
  BOOST_REQUIRE_GE(result.cost, optimum * (1.0 - eps));
  BOOST_REQUIRE_LE(result.lower, optimum * (1.0 + eps));
  if (bound == infinity) return;
  BOOST_REQUIRE_LE(result.cost, bound * optimum * (1.0 + eps));
  BOOST_REQUIRE_LE(result.cost, bound * result.lower * (1.0 + eps));
}

inline void check_same(const ConflictSearchResult& a, const ConflictSearchResult& b) {
  BOOST_REQUIRE(a.status == b.status);
  BOOST_REQUIRE_EQUAL(a.cost, b.cost);
  BOOST_REQUIRE_EQUAL(a.lower, b.lower);
  BOOST_REQUIRE_EQUAL(a.paths.size(), b.paths.size());
  for (std::size_t i = 0; i < a.paths.size(); ++i) {
    BOOST_REQUIRE(a.paths[i].moves == b.paths[i].moves);
    BOOST_REQUIRE_EQUAL(a.paths[i].cost, b.paths[i].cost);
  }
  BOOST_REQUIRE_EQUAL(a.statistics.tree_nodes, b.statistics.tree_nodes);
  BOOST_REQUIRE_EQUAL(a.statistics.low.expansions, b.statistics.low.expansions);
  BOOST_REQUIRE_EQUAL(a.statistics.low.generated, b.statistics.low.generated);
  BOOST_REQUIRE_EQUAL(a.statistics.low.evaluations, b.statistics.low.evaluations);
  BOOST_REQUIRE_EQUAL(a.statistics.low.memory, b.statistics.low.memory);
  BOOST_REQUIRE_EQUAL(a.statistics.memory, b.statistics.memory);
}

}  // namespace srmp::multi::test
