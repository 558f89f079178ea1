#include "srmp/search/astar.hpp"

#include <map>
#include <set>
#include <tuple>

#include "search/graphs.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// The number of evaluations of an A* that evaluates every edge it generates to a state that is not closed.
std::uint64_t eager_evaluations(Problem& problem) {
  using Key = std::tuple<double, double, std::uint64_t, StateId>;
  std::set<Key> open;
  std::map<StateId, Key> keys;
  std::map<StateId, double> g;
  std::set<StateId> closed;
  std::uint64_t number = 0, evaluations = 0;
  const auto reach = [&](StateId s, double cost) {
    if (g.contains(s) && g[s] <= cost) return;
    if (keys.contains(s)) open.erase(keys[s]);
    g[s] = cost;
    keys[s] = {cost + problem.h[s], problem.h[s], number++, s};
    open.insert(keys[s]);
  };
  for (const StateId s : problem.starts) {
    if (problem.h[s] < infinity) reach(s, 0.0);
  }
  while (!open.empty()) {
    const StateId s = std::get<3>(*open.begin());
    open.erase(open.begin());
    closed.insert(s);
    if (problem.graph.is_goal(s)) break;
    for (const Arc& arc : problem.graph.arcs[s]) {
      if (closed.contains(arc.to) || problem.h[arc.to] == infinity) continue;
      ++evaluations;
      if (arc.cost < infinity) reach(arc.to, g[s] + arc.cost);
    }
  }
  return evaluations;
}

}  // namespace

BOOST_AUTO_TEST_CASE(lazy_astar_evaluates_no_more_than_eager_astar) {
  std::uint64_t lazy = 0, eager = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      const std::uint64_t mine =
          weighted_astar(problem.graph, problem.starts, problem, {}, Deadline()).statistics.evaluations;
      const std::uint64_t theirs = eager_evaluations(problem);
      BOOST_TEST(mine <= theirs);
      lazy += mine;
      eager += theirs;
    }
  }
  BOOST_TEST(3 * lazy < 2 * eager);  // far fewer, in fact
}

BOOST_AUTO_TEST_CASE(true_lower_bounds_are_evaluated_along_the_path_only) {
  Problem problem = corridor();
  const Result result = weighted_astar(problem.graph, problem.starts, problem, {}, Deadline());
  BOOST_TEST(result.statistics.evaluations == 4u);
  BOOST_TEST(result.statistics.expansions == 4u);
  BOOST_TEST(result.statistics.generated == 7u);
}

BOOST_AUTO_TEST_CASE(a_greedy_path_may_prove_a_tighter_bound_than_its_weight) {
  Problem problem = corridor();
  BOOST_TEST(weighted_astar(problem.graph, problem.starts, problem, {50.0}, Deadline()).bound == 1.0);
}
