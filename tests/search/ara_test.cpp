#include "srmp/search/ara.hpp"

#include "search/graphs.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

Result plan(Problem& problem, const AraOptions& options, const Deadline& deadline = Deadline()) {
  return ara_star(problem.graph, problem.starts, problem, options, deadline);
}

}  // namespace

BOOST_AUTO_TEST_CASE(ara_costs_and_bounds_never_rise_and_end_at_the_optimum) {
  std::size_t improved = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      std::vector<Result> seen;
      AraOptions options{.initial_weight = 1.5 + seed % 20, .weight_delta = 0.3 + seed % 5};
      options.on_solution = [&](const Result& result) {
        check_result(problem, result, options.initial_weight);
        if (!seen.empty()) {
          BOOST_REQUIRE_LE(result.cost, seen.back().cost);
          BOOST_REQUIRE_LE(result.bound, seen.back().bound);
          BOOST_REQUIRE(result.cost < seen.back().cost || result.bound < seen.back().bound);
        }
        seen.push_back(result);
        return true;
      };
      const Result last = plan(problem, options);
      check_result(problem, last, 1.0);
      BOOST_REQUIRE_LE(problem.graph.max_evaluations(), 1);
      BOOST_REQUIRE_EQUAL(seen.empty(), last.status != Status::solved);
      if (seen.empty()) continue;
      check_same(seen.back(), last);
      BOOST_REQUIRE_EQUAL(last.bound, 1.0);
      BOOST_REQUIRE_LE(last.cost, problem.optimum() * (1.0 + 1e-12));
      improved += seen.back().cost < seen.front().cost;
    }
  }
  BOOST_TEST(improved > 20u);  // or the test would show little
}

BOOST_AUTO_TEST_CASE(ara_stops_at_the_first_path_that_is_proven_optimal) {
  Problem problem = corridor();
  int calls = 0;
  const Result result = plan(problem, {.on_solution = [&](const Result&) { return ++calls > 0; }});
  BOOST_TEST(calls == 1);
  BOOST_TEST(result.bound == 1.0);
  BOOST_TEST(result.statistics.expansions == 4u);
}

/// A problem whose first path is not optimal.
Problem improvable() {
  for (unsigned seed = 0;; ++seed) {
    Problem problem = random_problem(seed), copy = problem;
    double first = 0.0;
    const Result last = plan(copy, {.on_solution = [&](const Result& result) {
                               first = first > 0.0 ? first : result.cost;
                               return true;
                             }});
    if (last.status == Status::solved && last.cost < first) return problem;
  }
}

BOOST_AUTO_TEST_CASE(ara_stops_when_on_solution_returns_false) {
  Problem problem = improvable();
  Result first;
  const Result result = plan(problem, {.on_solution = [&](const Result& solution) {
                               first = solution;
                               return false;
                             }});
  check_same(result, first);
  BOOST_TEST(result.bound > 1.0);
}

BOOST_AUTO_TEST_CASE(ara_returns_the_best_path_so_far_at_the_deadline) {
  Problem problem = improvable();
  Result first;
  const Deadline deadline(0.2);
  const Result result = plan(problem,
                             {.on_solution =
                                  [&](const Result& solution) {
                                    first = solution;
                                    while (!deadline.expired()) {
                                    }
                                    return true;
                                  }},
                             deadline);
  BOOST_TEST((result.status == Status::solved));
  check_same(result, first);
}
