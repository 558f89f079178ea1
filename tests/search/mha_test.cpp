#include "srmp/search/mha.hpp"

#include "search/graphs.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

BOOST_AUTO_TEST_CASE(mha_keeps_its_bound_with_misleading_heuristics) {
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem problem = random_problem(seed);
      const InadmissibleHeuristic away = [&](StateId s) { return 100.0 / (0.01 + problem.h[s]); };
      const InadmissibleHeuristic noise = [](StateId s) { return static_cast<double>((s * 2654435761u) % 1009u); };
      const InadmissibleHeuristic steep = [&](StateId s) { return 30.0 * problem.h[s]; };
      const std::vector<InadmissibleHeuristic> others{away, noise, steep};
      const MhaOptions options{.w1 = 1.0 + 0.5 * (seed % 5), .w2 = 1.0 + 0.7 * (seed % 3)};
      const Result result = mha_star(problem.graph, problem.starts, problem, others, options, Deadline());
      check_result(problem, result, options.w1 * options.w2);
      BOOST_REQUIRE_LE(problem.graph.max_evaluations(), 1);
      BOOST_REQUIRE_LE(result.statistics.expansions, 2 * problem.graph.arcs.size());
    }
  }
}

/// An anchor heuristic of 0 beside the Manhattan distance: on a 60 x 60 grid, little more than the path is expanded.
BOOST_AUTO_TEST_CASE(mha_follows_a_good_inadmissible_heuristic) {
  constexpr StateId width = 60;
  Problem problem{TestGraph(width * width), {0}, std::vector<double>(width * width, 0.0)};
  for (StateId s = 0; s < width * width; ++s) {
    if (s % width + 1 < width) problem.graph.add(s, s + 1, 1.0).add(s + 1, s, 1.0);
    if (s + width < width * width) problem.graph.add(s, s + width, 1.0).add(s + width, s, 1.0);
  }
  problem.graph.goals.back() = 1;
  const InadmissibleHeuristic manhattan = [](StateId s) { return 2.0 * width - 2 - s % width - s / width; };
  const auto expansions = [&](std::span<const InadmissibleHeuristic> others) {
    return mha_star(problem.graph, problem.starts, problem, others, {2.0, 20.0}, Deadline()).statistics.expansions;
  };
  const std::uint64_t blind = expansions({}), guided = expansions({&manhattan, 1});
  BOOST_TEST(blind > 3000u);
  BOOST_TEST(guided < 300u);
}

BOOST_AUTO_TEST_CASE(mha_refuses_bad_inadmissible_heuristics) {
  for (const double bad : {std::nan(""), -1.0}) {
    Problem problem = corridor();
    const std::vector<InadmissibleHeuristic> others{[](StateId) { return 0.0; },
                                                    [&](StateId s) { return s == 1 ? bad : infinity; }};
    check_throws<InvalidArgument>([&] { mha_star(problem.graph, problem.starts, problem, others, {}, Deadline()); },
                                  "inadmissible heuristic 1 of state 1 is " + to_text(bad));
  }
}
