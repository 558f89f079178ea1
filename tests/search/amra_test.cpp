#include "srmp/search/amra.hpp"

#include "search/graphs.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::search;
using namespace srmp::search::test;

namespace {

/// A random problem whose edges belong to three resolutions or are connections: those of the coarse ones are shortcuts
/// that the finest graph lacks.
struct Levelled {
  Problem problem;

  static std::size_t level_of(StateId from, StateId to) { return (from * 7 + to * 3) % 8; }  // 3: a connection

  std::size_t levels() const { return 3; }
  bool is_on(StateId s, std::size_t level) const { return s % (std::size_t{1} << level) == 0; }
  void successors(StateId s, std::size_t level, std::vector<Successor>& out) {
    for (const Arc& arc : problem.graph.arcs[s])
      if (const std::size_t of = level_of(s, arc.to); level == (of > 3 ? 0 : of)) out.push_back({arc.to, arc.lower});
  }
  void connections(StateId s, std::vector<Successor>& out) { successors(s, 3, out); }
  void successors(StateId s, std::vector<Successor>& out) {
    connections(s, out);
    successors(s, 0, out);
  }
  void evaluate(std::span<const Edge> edges, std::span<double> costs) { problem.graph.evaluate(edges, costs); }
  bool is_goal(StateId s) const { return problem.graph.is_goal(s); }

  /// Without the edges of the coarse resolutions.
  double finest_optimum() const {
    Problem finest = problem;
    for (StateId s = 0; s < finest.graph.arcs.size(); ++s)
      std::erase_if(finest.graph.arcs[s], [&](const Arc& arc) {
        const std::size_t level = level_of(s, arc.to);
        return level == 1 || level == 2;
      });
    return finest.optimum();
  }
};

InadmissibleHeuristics misleading(const Problem& problem) {
  return {3, [&problem](std::span<const StateId> states, std::span<double> out) {
            for (std::size_t i = 0; i < states.size(); ++i) {
              const double h = problem.h[states[i]] < infinity ? problem.h[states[i]] : 0.0;
              out[3 * i] = 100.0 / (0.01 + h);
              out[3 * i + 1] = static_cast<double>((states[i] * 2654435761u) % 1009u);
              out[3 * i + 2] = 30.0 * h;
            }
          }};
}

}  // namespace

BOOST_AUTO_TEST_CASE(amra_keeps_its_bounds_of_the_finest_graph) {
  unsigned solvable = 0, shortcuts = 0;
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Levelled graph{random_problem(seed)};
      Problem& problem = graph.problem;
      const double optimum = graph.finest_optimum();
      AmraOptions options{.w1 = 1.0 + 0.9 * (seed % 5), .w2 = 1.0 + 0.7 * (seed % 3), .final_weight = 1.0};
      double last_cost = infinity, last_bound = options.w1 * options.w2;
      options.on_solution = [&](const Result& better) {
        BOOST_TEST(better.cost <= last_cost);
        BOOST_TEST(better.bound <= last_bound);
        BOOST_TEST(better.cost <= better.bound * optimum * (1.0 + 1e-9));
        last_cost = better.cost;
        last_bound = better.bound;
        return true;
      };
      AmraStar<Levelled, Problem> search(graph, problem.starts, problem, misleading(problem), options);
      while (!search.finished()) BOOST_REQUIRE(!search.improve(Deadline(), 1 + seed % 4));
      const Result result = search.result(std::nullopt);
      BOOST_REQUIRE_LE(problem.graph.max_evaluations(), 1);
      if (optimum < infinity) {
        BOOST_TEST((result.status == Status::solved));
        BOOST_TEST(result.bound == 1.0);
        BOOST_TEST(result.cost <= optimum * (1.0 + 1e-9));
        ++solvable;
        shortcuts += result.cost < optimum * (1.0 - 1e-9);
      }
      if (result.status == Status::solved) BOOST_TEST(result.cost >= problem.optimum() * (1.0 - 1e-9));
    }
  }
  BOOST_TEST(solvable > random_problems / 4);
  BOOST_TEST(shortcuts > 3u);
}

BOOST_AUTO_TEST_CASE(amra_finds_the_same_in_slices_of_any_size) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const auto run = [&](std::uint64_t slice) {
      Levelled graph{random_problem(seed)};
      AmraStar<Levelled, Problem> search(graph, graph.problem.starts, graph.problem, misleading(graph.problem), {});
      while (!search.finished()) search.improve(Deadline(), slice);
      return search.result(std::nullopt);
    };
    check_same(run(1), run(unlimited));
  }
}

BOOST_AUTO_TEST_CASE(amra_without_inadmissible_heuristics_is_astar_on_the_finest_graph) {
  for (unsigned seed = 0; seed < random_problems; ++seed) {
    Levelled graph{random_problem(seed)};
    AmraStar<Levelled, Problem> search(graph, graph.problem.starts, graph.problem, {}, {.w1 = 1.0, .w2 = 1.0});
    search.improve(Deadline(), unlimited);
    const double optimum = graph.finest_optimum();
    BOOST_TEST(search.solved() == (optimum < infinity));
    if (search.solved()) BOOST_TEST(search.cost() == optimum, boost::test_tools::tolerance(1e-9));
  }
}

BOOST_AUTO_TEST_CASE(amra_refuses_invalid_options) {
  Levelled graph{random_problem(0)};
  const auto make = [&](const AmraOptions& options) {
    AmraStar<Levelled, Problem>(graph, graph.problem.starts, graph.problem, {}, options);
  };
  check_throws<InvalidArgument>([&] { make({.w1 = 0.5}); }, "w1");
  check_throws<InvalidArgument>([&] { make({.w2 = infinity}); }, "w2");
  check_throws<InvalidArgument>([&] { make({.final_weight = 0.0}); }, "final_weight");
}
