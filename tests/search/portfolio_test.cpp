#include "srmp/search/portfolio.hpp"

#include "search/graphs.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

using Member = PortfolioMember<TestGraph, Problem>;

Member member(Problem& problem) { return {&problem.graph, problem.starts, &problem}; }

PortfolioResult run(std::vector<Member> members, double weight = 1.5, std::uint64_t turn = 2) {
  return portfolio<TestGraph, Problem>(members, {weight, turn}, Deadline());
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_portfolio_keeps_the_bound_of_its_winner_and_fails_only_when_all_do) {
  int solved = 0, second = 0;
  for (unsigned seed = 0; seed + 1 < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Problem a = random_problem(seed), b = random_problem(seed + 1);
      Problem only_a = random_problem(seed), only_b = random_problem(seed + 1);
      const bool possible = run({member(only_a)}).result.status == Status::solved ||
                            run({member(only_b)}).result.status == Status::solved;
      const PortfolioResult found = run({member(a), member(b)});
      BOOST_TEST((found.result.status == Status::solved) == possible);
      if (!possible) continue;
      ++solved;
      second += found.winner == 1;
      check_result(found.winner ? b : a, found.result, 1.5);
      Problem again_a = random_problem(seed), again_b = random_problem(seed + 1);
      const PortfolioResult again = run({member(again_a), member(again_b)});
      BOOST_TEST(again.winner == found.winner);
      BOOST_TEST((again.result.path == found.result.path));
    }
  }
  BOOST_TEST(solved > 100);
  BOOST_TEST(second > 20);
}

BOOST_AUTO_TEST_CASE(a_portfolio_refuses_nonsense) {
  Problem problem = random_problem(0);
  check_throws<InvalidArgument>([&] { run({}); }, "at least one search");
  check_throws<InvalidArgument>([&] { run({member(problem)}, 0.5); }, "weight");
  check_throws<InvalidArgument>([&] { run({member(problem)}, 2.0, 0); }, "at least one expansion");
}
