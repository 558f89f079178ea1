#include "srmp/search/wpase.hpp"

#include <map>

#include "search/graphs.hpp"
#include "srmp/search/astar.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// The tightest pair heuristic there is without evaluating an edge.
struct LowerBounds {
  const TestGraph& graph;
  std::map<StateId, std::vector<double>> from;

  double operator()(StateId a, StateId b) {
    if (!from.contains(a)) from[a] = dijkstra(graph, {a}, lower_of);
    return from[a][b];
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(wpase_keeps_its_bound_with_a_pair_heuristic) {
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      LowerBounds pair{problem.graph, {}};
      const WpaseOptions options{.weight = 1.0 + 0.8 * (seed % 4), .batch_size = 1 + seed % 13};
      const Result result = wpase(problem.graph, problem.starts, problem, options, Deadline(), pair);
      check_result(problem, result, options.weight);
      BOOST_REQUIRE_LE(problem.graph.max_evaluations(), 1);
      BOOST_REQUIRE_LE(result.statistics.expansions, problem.graph.arcs.size());
    }
  }
}

BOOST_AUTO_TEST_CASE(wpase_finds_the_same_path_with_any_number_of_threads) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      std::vector<Result> results;
      for (const unsigned threads : {1u, 2u, 4u}) {
        Problem problem = random_problem(seed);
        problem.graph.threads = threads;
        results.push_back(wpase(problem.graph, problem.starts, problem, {2.0, 8}, Deadline()));
      }
      check_same(results[0], results[1]);
      check_same(results[0], results[2]);
    }
  }
}

BOOST_AUTO_TEST_CASE(wpase_with_batches_of_one_is_weighted_astar) {
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      check_same(wpase(problem.graph, problem.starts, problem, {3.0, 1}, Deadline()),
                 weighted_astar(problem.graph, problem.starts, problem, {3.0}, Deadline()));
    }
  }
}

/// Threads and SIMD lanes speed up calls of evaluate(); batches need fewer calls.
BOOST_AUTO_TEST_CASE(wpase_needs_fewer_calls_than_edges) {
  struct CountingGraph : TestGraph {
    std::uint64_t calls{};
    void evaluate(std::span<const Edge> edges, std::span<double> costs) {
      ++calls;
      TestGraph::evaluate(edges, costs);
    }
  };
  std::uint64_t calls = 0, edges = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    Problem problem = random_grid(seed);
    CountingGraph graph{problem.graph};
    edges += wpase(graph, problem.starts, problem, {1.0, 8}, Deadline()).statistics.evaluations;
    calls += graph.calls;
  }
  BOOST_TEST(3 * calls < edges);
}
