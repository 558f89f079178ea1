/// One suite for all settings of the conflict search.
#include "multi/grids.hpp"

using namespace srmp;
using namespace srmp::multi;
using namespace srmp::multi::test;

namespace {

struct Planner {
  std::string name;
  ConflictSearchOptions options;
};

const std::vector<Planner>& all_planners() {
  static const std::vector<Planner> planners{
      {"CBS", {}},
      {"CBS with experience", {.experience = true}},
      {"CBS with priorities", {.priorities = true}},
  };
  return planners;
}

ConflictSearchResult plan(World& world, const ConflictSearchOptions& options) {
  return conflict_search(world, options, Deadline());
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_planner_keeps_its_bound_on_random_worlds) {
  for (const Planner& planner : all_planners()) {
    for (const auto& [seed, optimum] : questions()) {
      BOOST_TEST_CONTEXT(planner.name << " seed " << seed) {
        const auto world = random_world(seed);
        check_result(*world, plan(*world, planner.options), planner.options.bound(), optimum);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(no_guide_breaks_the_bound) {
  for (const Planner& planner : all_planners()) {
    for (const auto& [seed, optimum] : questions()) {
      BOOST_TEST_CONTEXT(planner.name << " seed " << seed) {
        const auto world = random_world(seed);
        misguide(*world, seed);
        check_result(*world, plan(*world, planner.options), planner.options.bound(), optimum);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(priorities_alone_give_ways_that_never_meet) {
  std::size_t solved = 0;
  for (const auto& [seed, optimum] : questions()) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      const auto world = random_world(seed);
      const ConflictSearchOptions options{.priorities_only = true};
      const ConflictSearchResult result = plan(*world, options);
      if (result.status == Status::exhausted) continue;
      check_result(*world, result, options.bound(), optimum);
      ++solved;
    }
  }
  BOOST_TEST(solved > questions().size() * 9 / 10);
}

BOOST_AUTO_TEST_CASE(the_same_question_has_the_same_answer) {
  for (const Planner& planner : all_planners()) {
    for (unsigned seed = 0; seed < 40; ++seed) {
      const auto world = random_world(questions()[seed].seed);
      const ConflictSearchResult once = plan(*world, planner.options);
      check_same(once, plan(*world, planner.options));
      check_same(once, plan(*random_world(questions()[seed].seed), planner.options));
    }
  }
}
