#include "srmp/search/portfolio.hpp"

#include "search/graphs.hpp"
#include "srmp/search/alternating_search.hpp"
#include "srmp/search/astar.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// Two inadmissible heuristics: the problem's own heuristic, and a hash.
InadmissibleHeuristics inadmissible_heuristics(const Problem& problem) {
  return {2, [&problem](std::span<const StateId> states, std::span<double> out) {
            for (std::size_t i = 0; i < states.size(); ++i) {
              out[2 * i] = problem.h[states[i]] < infinity ? problem.h[states[i]] : 0.0;
              out[2 * i + 1] = static_cast<double>((states[i] * 2654435761u) % 97u);
            }
          }};
}

struct Options {
  double weight{1.5};
  std::uint64_t slice{2};
  std::uint64_t max_expansions{unlimited};
  MoreExpansions more_expansions{};
};

PortfolioResult run(const std::vector<Problem*>& members, const Options& options = {}) {
  const auto make = [&](std::size_t i) {
    Problem& problem = *members[i];
    return std::make_unique<AlternatingSearch<TestGraph, Problem>>(problem.graph, problem.starts, problem,
                                                                   inadmissible_heuristics(problem), options.weight);
  };
  return portfolio(
      members.size(), make,
      {.slice = options.slice, .max_expansions = options.max_expansions, .more_expansions = options.more_expansions},
      Deadline());
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_portfolio_keeps_the_bound_of_its_winner_and_fails_only_when_all_do) {
  int solved = 0, second = 0;
  for (unsigned seed = 0; seed + 1 < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem a = random_problem(seed), b = random_problem(seed + 1);
      Problem only_a = random_problem(seed), only_b = random_problem(seed + 1);
      const bool possible =
          run({&only_a}).result.status == Status::solved || run({&only_b}).result.status == Status::solved;
      const PortfolioResult found = run({&a, &b});
      BOOST_TEST((found.result.status == Status::solved) == possible);
      if (!possible) continue;
      ++solved;
      second += found.winner == 1;
      check_result(found.winner ? b : a, found.result, 1.5);
      Problem again_a = random_problem(seed), again_b = random_problem(seed + 1);
      const PortfolioResult again = run({&again_a, &again_b});
      BOOST_TEST(again.winner == found.winner);
      BOOST_TEST((again.result.path == found.result.path));
    }
  }
  BOOST_TEST(solved > 100);
  BOOST_TEST(second > 20);
}

BOOST_AUTO_TEST_CASE(a_portfolio_that_goes_on_returns_the_cheapest_path) {
  int cheaper = 0;
  for (unsigned seed = 0; seed + 1 < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      const auto of = [&](double more) {
        Problem a = random_problem(seed), b = random_problem(seed + 1);
        const PortfolioResult found = run({&a, &b}, {.more_expansions = {more}});
        if (found.result.status == Status::solved) check_result(found.winner ? b : a, found.result, 1.5);
        return found;
      };
      const PortfolioResult first = of(0.0), more = of(0.5), all = of(1e9);
      BOOST_TEST((more.result.status == first.result.status));
      BOOST_TEST((all.result.status == first.result.status));
      Problem a = random_problem(seed), b = random_problem(seed + 1);
      const PortfolioResult two = run({&a, &b}, {.more_expansions = {.fraction = 1e9, .most = 2}});
      BOOST_TEST(two.result.statistics.expansions <= first.result.statistics.expansions + 4);  // the slice is 2
      BOOST_TEST(more.result.statistics.expansions >= first.result.statistics.expansions);
      if (first.result.status != Status::solved) continue;
      BOOST_TEST(more.result.cost <= first.result.cost);
      BOOST_TEST(all.result.cost <= more.result.cost);
      cheaper += all.result.cost < first.result.cost;
      for (const unsigned which : {0u, 1u}) {
        Problem alone = random_problem(seed + which);
        const Result own = run({&alone}).result;
        if (own.status == Status::solved) BOOST_TEST(all.result.cost <= own.cost);
      }
    }
  }
  BOOST_TEST(cheaper > 20);
}

BOOST_AUTO_TEST_CASE(a_portfolio_refuses_invalid_options) {
  Problem problem = random_problem(0);
  check_throws<InvalidArgument>([&] { run({}); }, "at least one search");
  check_throws<InvalidArgument>([&] { run({&problem}, {0.5}); }, "weight");
  check_throws<InvalidArgument>([&] { run({&problem}, {2.0, 0}); }, "at least one expansion");
  for (const double bad : {-0.1, std::numeric_limits<double>::quiet_NaN()})
    check_throws<InvalidArgument>([&] { run({&problem}, {.more_expansions = {bad}}); }, "more_expansions.fraction is");
}

BOOST_AUTO_TEST_CASE(a_portfolio_says_which_graphs_hold_no_path) {
  Problem open = corridor(), broken = broken_bridge();
  const PortfolioResult found = run({&broken, &open}, {1.0, 1});
  BOOST_TEST(found.winner == 1u);
  BOOST_TEST((found.exhausted == std::vector<char>{1, 0}));
  Problem alone = broken_bridge();
  const PortfolioResult none = run({&alone});
  BOOST_TEST((none.result.status == Status::exhausted));
  BOOST_TEST((none.exhausted == std::vector<char>{1}));
}

BOOST_AUTO_TEST_CASE(a_portfolio_stops_after_max_expansions) {
  Problem problem = corridor();
  const PortfolioResult found = run({&problem}, {1.0, 1, 2});
  BOOST_TEST((found.result.status == Status::timed_out));
  BOOST_TEST((found.exhausted == std::vector<char>{0}));
  BOOST_TEST(found.result.statistics.expansions == 2u);
}

BOOST_AUTO_TEST_CASE(a_member_is_made_before_its_first_slice) {
  Problem problem = corridor();
  std::size_t made = 0;
  const auto make = [&](std::size_t) {
    ++made;
    return std::make_unique<WeightedAstar<TestGraph, Problem>>(problem.graph, problem.starts, problem, AstarOptions{});
  };
  BOOST_TEST((portfolio(3, make, {}, Deadline()).result.status == Status::solved));
  BOOST_TEST(made == 1u);
}

/// A heuristic of infinity says that no path through a state is short enough; an exhausted graph then holds none.
BOOST_AUTO_TEST_CASE(a_graph_exhausted_within_a_limit_holds_no_path_below_it) {
  int proven = 0, solved = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      const double optimum = problem.optimum();
      if (optimum == infinity) continue;
      const std::vector<double> from_start = dijkstra(problem.graph, problem.starts, lower_of);
      for (const double fraction : {0.8, 0.999, 1.001, 1.5}) {
        const double limit = fraction * optimum;
        Problem within = problem;
        for (StateId s = 0; s < within.h.size(); ++s)
          if (from_start[s] + within.h[s] > limit) within.h[s] = infinity;
        const PortfolioResult found = run({&within});
        if (found.exhausted[0]) {
          BOOST_REQUIRE_GE(optimum, limit);
          ++proven;
        } else {
          BOOST_REQUIRE(found.result.status == Status::solved);
          ++solved;
        }
      }
    }
  }
  BOOST_TEST(proven > 100);
  BOOST_TEST(solved > 100);
}
