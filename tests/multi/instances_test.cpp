/// Grids whose optimum is known: by reasoning, or by another exact algorithm.
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "multi/grids.hpp"

using namespace srmp;
using namespace srmp::multi;
using namespace srmp::multi::test;

namespace {

const ConflictSearchOptions cbs{}, cbs_with_experience{.experience = true}, cbs_with_priorities{.priorities = true};
const ConflictSearchOptions ecbs{.low_focal = 1.2, .high_focal = 1.25};
const ConflictSearchOptions xecbs{
    .low_level_weight = 1.5, .low_focal = 1.1, .high_focal = 1.2, .experience = true, .priorities = true};

void check_optimum(GridWorld world, double optimum) {
  for (const ConflictSearchOptions& options : {cbs, cbs_with_experience, cbs_with_priorities, ecbs, xecbs}) {
    const ConflictSearchResult result = conflict_search(world, options, Deadline());
    check_result(world, result, options.bound(), optimum);
    if (options.bound() == 1.0) BOOST_TEST(result.cost == optimum);
  }
}

void check_small(const GridWorld& world, double optimum) {
  GridWorld copy = world;
  BOOST_TEST(BruteForce(copy).optimum() == optimum);
  check_optimum(world, optimum);
}

}  // namespace

BOOST_AUTO_TEST_CASE(two_swap_in_a_corridor_with_a_siding) {
  // 4 + 4 without conflicts. One must go into the siding and out again (+2). It gets there at step 3 at the earliest,
  // so the other, which could be at the junction at step 2, waits for a step (+1).
  check_small(grid({"a...b",  //
                    "##.##"},
                   {"b...a",  //
                    "##.##"}),
              11.0);
}

BOOST_AUTO_TEST_CASE(two_swap_in_a_square) {
  // They may not swap directly, and an agent that waits finds the other's cell taken: one goes around (3), the other
  // goes straight after it has left (1).
  check_small(grid({"ab", ".."}, {"ba", ".."}), 4.0);
}

BOOST_AUTO_TEST_CASE(four_rotate_in_a_square) {
  // Each follows the next: a rotation is no swap.
  check_small(grid({"ab", "dc"}, {"da", "cb"}), 4.0);
}

BOOST_AUTO_TEST_CASE(three_cross_at_a_junction) {
  // Each needs 2 steps through the middle, which holds one at a time: they are there at steps 1, 2, 3 and done a step
  // later. c's goal is where b starts, agents is gone by then.
  check_small(grid({"#b#",  //
                    "a..",  //
                    "#c#"},
                   {"#c#",  //
                    "b.a",  //
                    "#.#"}),
              9.0);
}

BOOST_AUTO_TEST_CASE(one_at_its_goal_makes_room) {
  // b is at its goal, which a must pass: down and up again (2) while a passes (2).
  check_small(grid({"ab.",  //
                    "#.#"},
                   {".ba",  //
                    "#.#"}),
              4.0);
}

BOOST_AUTO_TEST_CASE(three_leave_by_a_door) {
  // 7 + 7 + 4 without conflicts, all through the gap in the wall, where c can be at step 1, a and b at step 3: one of
  // them waits.
  check_small(grid({"a.#...",  //
                    ".c....",  //
                    "b.#..."},
                   {"..#..a",  //
                    ".....c",  //
                    "..#..b"}),
              19.0);
}

namespace {

/// Increasing cost tree search (Sharon, Stern, Goldenberg, Felner 2013), for grids: sums of costs from the least on,
/// and for each all distributions over the agents; are there collision-free paths of just these costs?
class IncreasingCostTree {
 public:
  explicit IncreasingCostTree(GridWorld& world) : world_(world) {}

  double optimum() {
    std::vector<int> alone;
    for (TestAgent& agent : world_.agents) alone.push_back(to_go(agent, agent.start()));
    std::set<std::vector<int>> level{alone};
    while (true) {
      std::set<std::vector<int>> next;
      for (const std::vector<int>& costs : level) {
        if (has_paths(costs)) return std::accumulate(costs.begin(), costs.end(), 0.0);
        for (std::size_t i = 0; i < costs.size(); ++i) {
          std::vector<int> more = costs;
          ++more[i];
          next.insert(std::move(more));
        }
      }
      level = std::move(next);
    }
  }

 private:
  using Cells = std::vector<StateId>;

  static int to_go(const TestAgent& agent, StateId cell) { return static_cast<int>(agent.problem.h[cell]); }

  /// Pairs first: they rule out most distributions.
  bool has_paths(const std::vector<int>& costs) {
    for (std::size_t a = 0; a < costs.size(); ++a) {
      for (std::size_t b = a + 1; b < costs.size(); ++b) {
        const auto [known, first] = pairs_.try_emplace({a, costs[a], b, costs[b]}, false);
        if (first) known->second = have_joint_paths({a, b}, costs);
        if (!known->second) return false;
      }
    }
    std::vector<std::size_t> all(costs.size());
    std::iota(all.begin(), all.end(), 0u);
    return have_joint_paths(all, costs);
  }

  bool have_joint_paths(const std::vector<std::size_t>& agents, const std::vector<int>& costs) {
    agents_ = agents;
    costs_ = costs;
    dead_ends_.clear();
    Cells cells;
    for (const std::size_t i : agents) cells.push_back(world_.agents[i].start());
    return from(cells, 0);
  }

  /// Can all agents reach their goals in time from here?
  bool from(const Cells& cells, int step) {
    bool arrived = true;
    for (std::size_t k = 0; k < agents_.size(); ++k) arrived = arrived && step >= costs_[agents_[k]];
    if (arrived) return true;
    Cells all = cells;
    all.push_back(static_cast<StateId>(step));
    return !dead_ends_.contains(all) && (go(cells, {}, step) || !dead_ends_.insert(all).second);
  }

  /// The same, after the agents before number next.size() have moved.
  bool go(const Cells& cells, const Cells& next, int step) {
    const std::size_t k = next.size();
    if (k == cells.size()) return from(next, step + 1);
    const TestAgent& agent = world_.agents[agents_[k]];
    const auto enter = [&](StateId to) {
      if (step + 1 + to_go(agent, to) > std::max(costs_[agents_[k]], step + 1)) return false;
      for (std::size_t i = 0; i < k; ++i)
        if (next[i] == to || (next[i] == cells[k] && cells[i] == to)) return false;
      Cells more = next;
      more.push_back(to);
      return go(cells, more, step);
    };
    for (const search::test::Arc& arc : agent.problem.graph.arcs[cells[k]])
      if (enter(arc.to)) return true;
    return enter(cells[k]);
  }

  GridWorld& world_;
  std::map<std::tuple<std::size_t, int, std::size_t, int>, bool> pairs_;
  std::vector<std::size_t> agents_;
  std::vector<int> costs_;
  std::set<Cells> dead_ends_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(an_increasing_cost_tree_agrees_with_brute_force) {
  for (unsigned seed = 0; seed < 100; seed += 2) {
    const auto world = random_world(seed);
    const double optimum = BruteForce(*world).optimum();
    double alone = 0.0;
    for (const TestAgent& agent : world->agents) alone += agent.problem.optimum();
    if (optimum < alone + 6.0) BOOST_TEST(IncreasingCostTree(dynamic_cast<GridWorld&>(*world)).optimum() == optimum);
  }
}

BOOST_AUTO_TEST_CASE(ten_agents_in_a_grid_of_8_by_8) {
  double lost = 0.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Dice dice(seed);
      GridWorld world = random_grid(dice, 8, 8, 10, 0.0);
      const double optimum = IncreasingCostTree(world).optimum();
      lost += optimum;
      for (const TestAgent& agent : world.agents) lost -= agent.problem.optimum();
      check_optimum(world, optimum);
    }
  }
  BOOST_TEST(lost > 5.0);  // there are conflicts
}
