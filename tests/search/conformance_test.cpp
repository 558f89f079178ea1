/// One suite for all planners.
#include <functional>
#include <string>

#include "search/graphs.hpp"
#include "srmp/search/alternating_search.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/portfolio.hpp"
#include "srmp/search/wpase.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// Any graph and heuristic, so that one list of planners serves all tests.
struct AnyGraph {
  std::function<void(StateId, std::vector<Successor>&)> successors;
  std::function<void(std::span<const Edge>, std::span<double>)> evaluate;
  std::function<bool(StateId)> is_goal;
};

AnyGraph any(TestGraph& graph) {
  return {[&](StateId s, std::vector<Successor>& out) { graph.successors(s, out); },
          [&](std::span<const Edge> edges, std::span<double> costs) { graph.evaluate(edges, costs); },
          [&](StateId s) { return graph.is_goal(s); }};
}

struct Planner {
  std::string name;
  double bound;
  std::function<Result(AnyGraph&, std::span<const StateId>, AnyHeuristic&, const Deadline&)> plan;

  Result operator()(Problem& problem, const Deadline& deadline = Deadline()) const {
    AnyGraph graph = any(problem.graph);
    AnyHeuristic heuristic = std::cref(problem);
    return plan(graph, problem.starts, heuristic, deadline);
  }
};

Planner astar_with(double weight) {
  return {"weighted_astar " + to_text(weight), weight, [=](auto& graph, auto starts, auto& h, auto& deadline) {
            return weighted_astar(graph, starts, h, {weight}, deadline);
          }};
}

Planner ara_with(double initial, double delta, double final) {
  return {"ara_star " + to_text(initial), final, [=](auto& graph, auto starts, auto& h, auto& deadline) {
            return ara_star(graph, starts, h, {initial, delta, final, {}}, deadline);
          }};
}

Planner mha_with(double w1, double w2, std::vector<InadmissibleHeuristic> others) {
  return {"mha_star " + to_text(w1) + " " + to_text(w2) + " with " + std::to_string(others.size()), w1 * w2,
          [=](auto& graph, auto starts, auto& h, auto& deadline) {
            return mha_star(graph, starts, h, others, {w1, w2}, deadline);
          }};
}

/// Each of the inadmissible heuristics is a hash of the state, the first is 0.
Planner portfolio_of_one(double weight, std::uint64_t slice, std::size_t inadmissible_heuristics) {
  return {"portfolio " + to_text(weight) + " with " + std::to_string(inadmissible_heuristics), weight,
          [=](auto& graph, auto starts, auto& h, auto& deadline) {
            const InadmissibleHeuristics values{
                inadmissible_heuristics,
                [inadmissible_heuristics](std::span<const StateId> states, std::span<double> out) {
                  for (std::size_t i = 0; i < out.size(); ++i)
                    out[i] = static_cast<double>(
                        ((i % inadmissible_heuristics) * states[i / inadmissible_heuristics] * 2654435761u) % 97u);
                }};
            const auto make = [&](std::size_t) {
              return std::make_unique<AlternatingSearch<AnyGraph, AnyHeuristic>>(graph, starts, h, values, weight);
            };
            return portfolio(1, make, {.slice = slice}, deadline).result;
          }};
}

Planner wpase_with(double weight, std::size_t batch_size) {
  return {"wpase " + to_text(weight) + " batch " + std::to_string(batch_size), weight,
          [=](auto& graph, auto starts, auto& h, auto& deadline) {
            return wpase(graph, starts, h, {weight, batch_size}, deadline);
          }};
}

const std::vector<Planner>& all_planners() {
  const InadmissibleHeuristic hash = [](StateId s) { return static_cast<double>((s * 2654435761u) % 97u); };
  const InadmissibleHeuristic upwards = [](StateId s) { return static_cast<double>(s); };
  const InadmissibleHeuristic choosy = [](StateId s) { return s % 3 ? 0.0 : infinity; };
  static const std::vector<Planner> planners{astar_with(1.0),
                                             astar_with(1.7),
                                             astar_with(20.0),
                                             portfolio_of_one(1.0, 2, 0),
                                             portfolio_of_one(1.0, 3, 2),
                                             portfolio_of_one(1.7, 2, 3),
                                             ara_with(50.0, 10.0, 1.0),
                                             ara_with(4.0, 0.7, 1.0),
                                             ara_with(10.0, 5.0, 2.5),
                                             mha_with(1.0, 1.0, {}),
                                             mha_with(1.0, 1.0, {hash}),
                                             mha_with(1.5, 2.0, {hash, upwards, choosy}),
                                             mha_with(5.0, 5.0, {upwards, hash}),
                                             wpase_with(1.0, 1),
                                             wpase_with(1.0, 8),
                                             wpase_with(1.7, 3),
                                             wpase_with(20.0, 16)};
  return planners;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_planner_keeps_its_bound_on_random_problems) {
  unsigned solvable = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    for (const Planner& planner : all_planners()) {
      BOOST_TEST_CONTEXT(planner.name << ", seed " << seed) {
        Problem problem = random_problem(seed);
        const Result result = planner(problem);
        check_result(problem, result, planner.bound);
        BOOST_REQUIRE_LE(problem.graph.max_evaluations(), 1);
        solvable += result.status == Status::solved;
      }
    }
  }
  const auto runs = static_cast<unsigned>(random_problems * all_planners().size());
  BOOST_TEST(solvable > runs / 2);  // or the test would show little
  BOOST_TEST(solvable < runs - runs / 10);
}

BOOST_AUTO_TEST_CASE(every_planner_repeats_itself) {
  for (const Planner& planner : all_planners()) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      Problem first = random_problem(seed), second = random_problem(seed);
      check_same(planner(first), planner(second));
    }
  }
}

BOOST_AUTO_TEST_CASE(memory_is_at_least_that_of_the_states_expanded) {
  for (const Planner& planner : all_planners()) {
    BOOST_TEST_CONTEXT(planner.name) {
      Problem problem = random_problem(3);
      const Statistics statistics = planner(problem).statistics;
      BOOST_TEST(statistics.memory >= statistics.expansions * sizeof(CandidateTable::State));
      BOOST_TEST(statistics.memory < 1'000'000u);
    }
  }
}

BOOST_AUTO_TEST_CASE(every_planner_finds_the_path_through_the_corridor) {
  for (const Planner& planner : all_planners()) {
    Problem problem = corridor();
    const Result result = planner(problem);
    check_result(problem, result, planner.bound);
    BOOST_TEST(result.cost == 4.0);
    BOOST_TEST((result.path == std::vector<StateId>{0, 1, 2, 3, 4}));
  }
}

BOOST_AUTO_TEST_CASE(the_next_candidate_takes_over_from_a_false_shortcut) {
  for (const Planner& planner : all_planners()) {
    for (const double truth : {9.0, infinity}) {
      Problem problem = false_shortcut(truth);
      const Result result = planner(problem);
      check_result(problem, result, planner.bound);
      if (truth == infinity || planner.bound < 2.0) BOOST_TEST(result.cost == 3.5);
    }
    Problem problem = false_shortcut(1.0);
    BOOST_TEST(planner(problem).cost == 2.0);
  }
}

BOOST_AUTO_TEST_CASE(every_planner_says_exhausted) {
  for (const Planner& planner : all_planners()) {
    Problem bridge = broken_bridge();
    check_result(bridge, planner(bridge), planner.bound);
    BOOST_TEST(bridge.graph.max_evaluations() == 1);
    Problem island{TestGraph(2), {0}, {infinity, 0.0}};  // pruned at the start
    island.graph.goals[1] = 1;
    BOOST_TEST((planner(island).status == Status::exhausted));
  }
}

BOOST_AUTO_TEST_CASE(a_start_at_the_goal_is_a_path) {
  for (const Planner& planner : all_planners()) {
    Problem problem = corridor();
    problem.starts = {4};
    const Result result = planner(problem);
    BOOST_TEST((result.status == Status::solved));
    BOOST_TEST((result.path == std::vector<StateId>{4}));
    BOOST_TEST(result.cost == 0.0);
    BOOST_TEST(result.bound == 1.0);
    BOOST_TEST(result.statistics.evaluations == 0u);
  }
}

BOOST_AUTO_TEST_CASE(the_nearest_of_several_starts_wins) {
  for (const Planner& planner : all_planners()) {
    Problem problem = corridor();
    problem.starts = {0, 2, 3, 3, 1};
    const Result result = planner(problem);
    check_result(problem, result, planner.bound);
    BOOST_TEST((result.path == std::vector<StateId>{3, 4}));
  }
}

BOOST_AUTO_TEST_CASE(every_planner_stops_at_the_deadline_and_when_cancelled) {
  for (const Planner& planner : all_planners()) {
    Problem problem = corridor();
    const Result late = planner(problem, Deadline(0.0));
    BOOST_TEST((late.status == Status::timed_out));
    BOOST_TEST(late.path.empty());
    BOOST_TEST(late.statistics.expansions == 0u);
    const Result cancelled = planner(problem, Deadline(1e9, [] { return true; }));
    BOOST_TEST((cancelled.status == Status::cancelled));
    BOOST_TEST(cancelled.statistics.expansions == 0u);
  }
}

BOOST_AUTO_TEST_CASE(the_deadline_is_polled_after_every_evaluation) {
  for (const Planner& planner : all_planners()) {
    Problem problem = corridor();
    const Deadline deadline(0.005);
    AnyGraph graph = any(problem.graph);
    graph.evaluate = [&](std::span<const Edge> edges, std::span<double> costs) {
      while (!deadline.expired()) {
      }
      problem.graph.evaluate(edges, costs);
    };
    AnyHeuristic heuristic = std::cref(problem);
    const Result result = planner.plan(graph, problem.starts, heuristic, deadline);
    BOOST_TEST((result.status == Status::timed_out));
    BOOST_TEST(result.statistics.evaluations <= 1u);
  }
}

BOOST_AUTO_TEST_CASE(every_planner_refuses_bad_heuristics) {
  for (const Planner& planner : all_planners()) {
    for (const double bad : {std::nan(""), -1.0, -infinity}) {
      for (const StateId where : {0u, 1u, 2u}) {
        Problem problem = corridor();
        problem.h[where] = bad;
        check_throws<InvalidArgument>([&] { planner(problem); },
                                      "heuristic of state " + std::to_string(where) + " is " + to_text(bad));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(every_planner_refuses_bad_edges_and_starts) {
  for (const Planner& planner : all_planners()) {
    for (const double bad : {std::nan(""), 0.0, -1.0, infinity}) {
      Problem problem = corridor();
      problem.graph.find(1, 2)->lower = bad;
      check_throws<InvalidArgument>([&] { planner(problem); }, "edge from state 1 to 2 has cost " + to_text(bad));
    }
    for (const double bad : {std::nan(""), 0.5, -infinity}) {
      Problem problem = corridor();
      problem.graph.find(1, 2)->cost = bad;
      check_throws<InvalidArgument>([&] { planner(problem); }, "was evaluated to " + to_text(bad));
    }
    Problem problem = corridor();
    problem.starts = {};
    check_throws<InvalidArgument>([&] { planner(problem); }, "at least one start");
    problem.starts = {0, no_state};
    check_throws<InvalidArgument>([&] { planner(problem); }, "no_state");
  }
}

BOOST_AUTO_TEST_CASE(every_planner_refuses_bad_options) {
  Problem problem = corridor();
  for (const double bad : {std::nan(""), 0.99, -1.0, infinity}) {
    const std::string text = " is " + to_text(bad);
    check_throws<InvalidArgument>([&] { astar_with(bad)(problem); }, "weight" + text);
    check_throws<InvalidArgument>([&] { wpase_with(bad, 1)(problem); }, "weight" + text);
    check_throws<InvalidArgument>([&] { ara_with(bad, 1.0, 1.0)(problem); }, "initial_weight" + text);
    check_throws<InvalidArgument>([&] { ara_with(5.0, 1.0, bad)(problem); }, "final_weight" + text);
    check_throws<InvalidArgument>([&] { mha_with(bad, 1.0, {})(problem); }, "w1" + text);
    check_throws<InvalidArgument>([&] { mha_with(1.0, bad, {})(problem); }, "w2" + text);
  }
  for (const double bad : {std::nan(""), 0.0, -1.0}) {
    check_throws<InvalidArgument>([&] { ara_with(5.0, bad, 1.0)(problem); }, "weight_delta");
  }
  check_throws<InvalidArgument>([&] { ara_with(2.0, 1.0, 3.0)(problem); }, "less than final_weight 3");
  check_throws<InvalidArgument>([&] { wpase_with(1.0, 0)(problem); }, "batch_size is 0");
  check_throws<InvalidArgument>([&] { mha_with(1.0, 1.0, {{}})(problem); }, "inadmissible heuristic 0 is empty");
}
