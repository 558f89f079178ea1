#include "srmp/planning/strategies/lattice_conflict_search.hpp"

#include <boost/test/unit_test.hpp>

#include "srmp/planning/world_subset.hpp"
#include "support/facing_arms.hpp"

namespace {

using Eigen::Vector2d;
using robots::FacingArms;

const std::vector<std::size_t> both{0, 1};

/// The optimum of the lattices that `graph` describes, by CBS.
srmp::multi::ConflictSearchResult optimum(const FacingArms& pair, const std::string& graph,
                                          const srmp::PlannerOptions& options) {
  for (const double scale : {4.0, 3.0, 1.5, 0.75}) {  // 6 would be more than 90 degrees
    srmp::MultiRobotWorld::Options like = pair.world->options();
    like.scale = scale;
    const auto world = srmp::world_like(*pair.world, {pair.world->task(0), pair.world->task(1)}, like);
    if (srmp::describe_graph(*world, options) != graph) continue;
    srmp::WorldSubset subset(*world, both);
    return srmp::multi::conflict_search(subset, {.max_evaluations = 20'000}, srmp::Deadline());
  }
  BOOST_FAIL("no lattice is '" + graph + "'");
  return {};
}

}  // namespace

BOOST_AUTO_TEST_SUITE(lattice_conflict_search)

BOOST_AUTO_TEST_CASE(costs_are_within_the_bound_of_the_lattices_that_are_named) {
  const srmp::ECBS ecbs{
      .common = {.resolution = 22.5}, .weight_low_level_heuristic = 1.0, .high_level_focal_suboptimality = 1.2};
  const srmp::PlannerOptions options = ecbs;
  int compared = 0;
  for (const double a : {-1.2, -0.9, -0.5})
    for (const double b : {-0.6, 0.0, 0.8}) {
      FacingArms pair(Vector2d(a, b));
      srmp::PlanStatistics statistics;
      srmp::LatticeConflictSearch search(*pair.world, both, options, statistics);
      srmp::Attempt found;
      for (int round = 0; round < 3 && found.status != srmp::Status::solved; ++round)
        found = search.attempt({.round = round}, srmp::Deadline());
      if (found.status != srmp::Status::solved) continue;
      pair.check_free(found.found.path);
      const auto best = optimum(pair, found.found.graph, options);
      if (best.status != srmp::Status::solved) continue;  // too many moves of the same cost
      ++compared;
      BOOST_TEST(found.lower == 0.0);  // of other lattices nothing is known
      BOOST_TEST(found.found.lower <= best.cost * (1.0 + 1e-9));
      BOOST_TEST(found.found.path.length() <= 1.2 * 1.3 * best.cost * (1.0 + 1e-9));
      BOOST_TEST(statistics.tree_nodes > 0u);
      BOOST_TEST(statistics.states > 0u);
    }
  BOOST_TEST(compared >= 4);
}

BOOST_AUTO_TEST_SUITE_END()
