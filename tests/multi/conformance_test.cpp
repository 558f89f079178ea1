/// One suite for all settings of the conflict search.
#include "multi/grids.hpp"
#include "srmp/core/error.hpp"
#include "support/throws.hpp"

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
      {"ECBS 1.1", {.low_focal = 1.1, .high_focal = 1.1}},
      {"ECBS low 1.5", {.low_focal = 1.5}},
      {"ECBS high 1.5", {.high_focal = 1.5}},
      {"ECBS 2", {.low_focal = 2.0, .high_focal = 2.0}},
      {"ECBS 1.2 with experience", {.low_focal = 1.2, .high_focal = 1.2, .experience = true}},
      {"weighted", {.low_level_weight = 1.5}},
      {"xECBS 2", {.low_level_weight = 2.0, .low_focal = 1.3, .high_focal = 1.3, .experience = true}},
      {"xECBS 5", {.low_level_weight = 5.0, .low_focal = 1.1, .high_focal = 1.3, .experience = true}},
      {"xECBS 1 with priorities", {.low_focal = 1.2, .high_focal = 1.1, .experience = true, .priorities = true}},
      {"xECBS 3 with priorities",
       {.low_level_weight = 3.0, .low_focal = 1.2, .high_focal = 1.1, .experience = true, .priorities = true}},
  };
  return planners;
}

ConflictSearchResult plan(World& world, const ConflictSearchOptions& options) {
  return conflict_search(world, options, Deadline());
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_planner_keeps_its_bound_on_random_worlds) {
  for (const Planner& planner : all_planners()) {
    for (const auto& [seed, optimum] : solvable_worlds()) {
      BOOST_TEST_CONTEXT(planner.name << " seed " << seed) {
        const auto world = random_world(seed);
        check_result(*world, plan(*world, planner.options), planner.options.bound(), optimum);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(no_inadmissible_heuristic_breaks_the_bound) {
  for (const Planner& planner : all_planners()) {
    for (std::size_t i = 0; i < solvable_worlds().size(); i += 4) {
      const auto& [seed, optimum] = solvable_worlds()[i];
      BOOST_TEST_CONTEXT(planner.name << " seed " << seed) {
        const auto world = random_world(seed);
        set_random_heuristics(*world, seed);
        check_result(*world, plan(*world, planner.options), planner.options.bound(), optimum);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(priorities_alone_give_collision_free_paths) {
  std::size_t solved = 0;
  for (const auto& [seed, optimum] : solvable_worlds()) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      const auto world = random_world(seed);
      const ConflictSearchOptions options{.priorities_only = true};
      const ConflictSearchResult result = plan(*world, options);
      if (result.status == Status::exhausted) continue;
      check_result(*world, result, options.bound(), optimum);
      ++solved;
    }
  }
  BOOST_TEST(solved > solvable_worlds().size() * 9 / 10);
}

BOOST_AUTO_TEST_CASE(the_same_world_gives_the_same_result) {
  for (const Planner& planner : all_planners()) {
    for (unsigned seed = 0; seed < 40; ++seed) {
      const auto world = random_world(solvable_worlds()[seed].seed);
      const ConflictSearchResult once = plan(*world, planner.options);
      check_same(once, plan(*world, planner.options));
      check_same(once, plan(*random_world(solvable_worlds()[seed].seed), planner.options));
    }
  }
}

BOOST_AUTO_TEST_CASE(an_agent_at_its_goal_stays_at_no_cost) {
  for (const Planner& planner : all_planners()) {
    GridWorld world = grid({"a.b"}, {"a.b"});
    const ConflictSearchResult result = plan(world, planner.options);
    check_result(world, result, 1.0, 0.0);
    BOOST_TEST(result.statistics.tree_nodes == 1u);
    GridWorld empty;
    const ConflictSearchResult nothing = plan(empty, planner.options);
    BOOST_TEST((nothing.status == Status::solved));
    BOOST_TEST(nothing.cost == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(an_exhausted_result_names_the_agent_without_a_path) {
  for (const bool hidden : {false, true}) {  // hidden: the wall shows only when the edge is evaluated
    for (const Planner& planner : all_planners()) {
      GridWorld world = grid({"a...", "###.", "b#.."}, {"...a", "###.", ".#b."});
      if (hidden) {
        world.agents[1].problem.graph.add(8, 9, 1.0, infinity).add(9, 10, 1.0);
        world.agents[1].problem.set_heuristic(1.0);
      }
      const ConflictSearchResult result = plan(world, planner.options);
      BOOST_TEST((result.status == Status::exhausted));
      BOOST_TEST(result.stuck_agent == 1u);
      BOOST_TEST(result.paths.empty());
      BOOST_TEST(result.cost == infinity);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_world_without_paths_under_the_constraints_is_exhausted) {
  for (const Planner& planner : all_planners()) {
    RandomWorld world = random_graphs(1);
    world.density = 1.0;  // at any two places
    const ConflictSearchResult result = plan(world, planner.options);
    BOOST_TEST((result.status == Status::exhausted));
    BOOST_TEST(result.stuck_agent == no_agent);
  }
}

BOOST_AUTO_TEST_CASE(every_planner_stops_at_the_deadline_and_when_cancelled) {
  for (const Planner& planner : all_planners()) {
    GridWorld world = grid({"a.b"}, {"b.a"});
    const ConflictSearchResult late = conflict_search(world, planner.options, Deadline(0.0));
    BOOST_TEST((late.status == Status::timed_out));
    BOOST_TEST(late.paths.empty());
    BOOST_TEST(late.stuck_agent == no_agent);
    BOOST_TEST(late.statistics.low.expansions == 0u);
    const ConflictSearchResult cancelled = conflict_search(world, planner.options, Deadline(1e9, [] { return true; }));
    BOOST_TEST((cancelled.status == Status::cancelled));
    // They cannot pass each other, which a search by constraints alone never proves.
    const ConflictSearchResult endless = conflict_search(world, planner.options, Deadline(0.02));
    BOOST_TEST((endless.status == Status::timed_out));
    BOOST_TEST(endless.lower >= 4.0);
    BOOST_TEST(endless.cost == infinity);
    BOOST_TEST(endless.statistics.tree_nodes > 1u);
  }
}

BOOST_AUTO_TEST_CASE(results_are_correct_for_every_budget) {
  for (const Planner& planner : all_planners()) {
    int late = 0;
    for (std::size_t i = 0; i < solvable_worlds().size(); i += 5) {
      const auto& [seed, optimum] = solvable_worlds()[i];
      BOOST_TEST_CONTEXT(planner.name << " seed " << seed) {
        const auto world = random_world(seed);
        ConflictSearchOptions options = planner.options;
        options.max_priority_evaluations = seed % 30;
        options.max_evaluations = 10 + 3 * seed;
        const ConflictSearchResult result = plan(*world, options);
        BOOST_TEST(result.statistics.low.evaluations <= options.max_evaluations);
        BOOST_TEST(result.lower <= optimum * (1.0 + 1e-9));
        if (result.status == Status::solved)
          check_result(*world, result, options.bound(), optimum);
        else
          BOOST_TEST((result.status == Status::timed_out));
        late += result.status != Status::solved;
      }
    }
    BOOST_TEST(late > 0);
  }
}

BOOST_AUTO_TEST_CASE(priorities_alone_prove_that_two_cannot_pass) {
  GridWorld world = grid({"a.b"}, {"b.a"});
  const ConflictSearchResult result = plan(world, {.priorities_only = true});
  BOOST_TEST((result.status == Status::exhausted));
  BOOST_TEST(result.stuck_agent == no_agent);
}

BOOST_AUTO_TEST_CASE(options_out_of_range_are_refused) {
  GridWorld world = grid({"a.b"}, {"a.b"});
  for (const double bad : {std::nan(""), 0.99, -1.0, infinity}) {
    const std::string text = " is " + to_text(bad) + ", it must be finite and at least 1";
    check_throws<InvalidArgument>([&] { plan(world, {.low_level_weight = bad}); }, "low_level_weight" + text);
    check_throws<InvalidArgument>([&] { plan(world, {.low_focal = bad}); }, "low_focal" + text);
    check_throws<InvalidArgument>([&] { plan(world, {.high_focal = bad}); }, "high_focal" + text);
  }
  check_throws<InvalidArgument>([&] { plan(world, {.lower_bound_period = 0}); }, "lower_bound_period is 0");
}

BOOST_AUTO_TEST_CASE(agents_that_break_their_contract_are_refused) {
  const GridWorld good = grid({"a.."}, {"..a"});
  for (const double bad : {std::nan(""), -1.0, -infinity}) {
    GridWorld world = good;
    world.agents[0].problem.h[1] = bad;
    check_throws<InvalidArgument>([&] { plan(world, {}); }, "the heuristic of state 1 is " + to_text(bad));
    world = good;
    world.agents[0].inadmissible_heuristics = {0.0, bad, 0.0};
    check_throws<InvalidArgument>([&] { plan(world, {}); }, "the inadmissible heuristic of state 1 is " + to_text(bad));
  }
  for (const double bad : {std::nan(""), 0.0, -1.0, infinity}) {
    GridWorld world = good;
    world.agents[0].problem.graph.find(1, 2)->lower = bad;
    check_throws<InvalidArgument>([&] { plan(world, {}); }, "the edge from state 1 to 2 has cost " + to_text(bad));
  }
  for (const double bad : {std::nan(""), 0.5, -infinity}) {
    GridWorld world = good;
    world.agents[0].problem.graph.find(1, 2)->cost = bad;
    check_throws<InvalidArgument>([&] { plan(world, {}); }, "was evaluated to " + to_text(bad));
  }
  GridWorld rounded = good;
  rounded.agents[0].problem.graph.find(1, 2)->cost = 1.0 - 1e-12;  // counts as 1
  BOOST_TEST(plan(rounded, {}).cost == 2.0);
  for (const double bad : {std::nan(""), 0.0, -1.0}) {
    GridWorld world = good;
    world.agents[0].wait = bad;
    check_throws<InvalidArgument>([&] { plan(world, {}); }, "agent 0: wait_cost is " + to_text(bad));
  }
  GridWorld world = good;
  world.agents[0].min_steps = 0;
  check_throws<InvalidArgument>([&] { plan(world, {}); }, "agent 0: the edge from state 0 to 1 takes 0 steps");
}

BOOST_AUTO_TEST_CASE(opened_nodes_are_told_and_change_nothing) {
  for (const Planner& planner : all_planners()) {
    const auto world = random_world(solvable_worlds().front().seed);
    const ConflictSearchResult plain = plan(*world, planner.options);
    ConflictSearchOptions options = planner.options;
    std::uint64_t opened = 0;
    options.on_opened = [&](const OpenedNode& node) {
      BOOST_TEST(node.number == opened++);
      BOOST_TEST((node.number == 0 || node.parent < node.number));
      BOOST_TEST(node.first.has_value() == (node.conflicts > 0));
    };
    const ConflictSearchResult told = plan(*world, options);
    BOOST_TEST(told.cost == plain.cost);
    BOOST_TEST(opened == plain.statistics.tree_nodes);
  }
}
