#include "srmp/planning/endpoints/search_endpoints.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <random>
#include <set>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"

using Eigen::Vector2d;
using srmp::GoalConstraint;
using srmp::PlannerInterface;

namespace {

/// The planar arm beside a post that it must pass.
struct World {
  PlannerInterface planner;

  explicit World(const srmp::PlannerOptions& options) {
    planner.add_articulation(robots::planar_description());
    planner.add_cylinder("post", 0.05, 1.0, {.p = {1.5, 0.0, 0.0}});
    planner.make_planner({"planar"}, options);
  }
  srmp::Trajectory plan(const Vector2d& from, const Vector2d& to) {
    return planner.plan("planar", from, GoalConstraint::joints(to));
  }
};

const Vector2d below(-1.0, 0.0), above(1.0, 0.0);

std::vector<srmp::PlannerOptions> rounding() { return {srmp::Auto{}, srmp::WAStar{}, srmp::MHAStar{}, srmp::WPASE{}}; }

}  // namespace

BOOST_AUTO_TEST_SUITE(search_endpoints)

BOOST_AUTO_TEST_CASE(paths_have_their_own_ends_and_are_free_and_within_their_bounds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> near(-0.3, 0.3);
  for (const srmp::PlannerOptions& options : rounding()) {
    World world(options);
    for (int i = 0; i < 25; ++i) {
      const Vector2d from = below + Vector2d(near(random), near(random)),
                     to = above + Vector2d(near(random), near(random));
      const srmp::Trajectory trajectory = world.plan(from, to);
      const srmp::RowMatrix& path = trajectory.waypoints;
      BOOST_TEST((path.row(0).transpose() == from));
      BOOST_TEST((path.bottomRows(1).transpose() == to));
      const srmp::PlanStatistics& statistics = world.planner.get_planning_stats();
      BOOST_TEST(trajectory.certificate->proved_free());
      BOOST_TEST(statistics.search_cost_rad >= (to - from).norm());
      BOOST_TEST(statistics.path_cost_rad <= statistics.search_cost_rad * (1.0 + 1e-12));
      BOOST_TEST(statistics.bound <= 50.0);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_weight_of_one_proves_the_optimum_of_the_lattice_with_its_motions_to_the_ends) {
  World world(srmp::WAStar{.common = {.shortcut = false}, .weight = 1.0});
  const Vector2d to = above + Vector2d(0.03, -0.05);
  world.plan(below, to);
  const srmp::PlanStatistics& statistics = world.planner.get_planning_stats();
  BOOST_CHECK_CLOSE(statistics.bound, 1.0, 1e-9);
  BOOST_CHECK_CLOSE(statistics.path_cost_rad, statistics.search_cost_rad, 1e-9);
}

BOOST_AUTO_TEST_CASE(similar_problems_are_one_search) {
  for (const srmp::PlannerOptions& options : rounding()) {
    World world(options);
    std::set<std::uint64_t> expansions;
    for (const double by : {-0.02, 0.0, 0.02}) {
      world.plan(below + Vector2d(0.0, by), above + Vector2d(by, 0.0));
      expansions.insert(world.planner.get_planning_stats().expansions);
    }
    BOOST_TEST(expansions.size() == 1u, srmp::planner_id(options));
  }
}

BOOST_AUTO_TEST_CASE(ends_in_one_cell_have_a_straight_path) {
  for (const srmp::PlannerOptions& options : rounding()) {
    World world(options);
    const Vector2d to = below + Vector2d(0.01, -0.01);
    BOOST_TEST(world.plan(below, to).waypoints.rows() == 2);
    BOOST_TEST((world.plan(below, below).positions.bottomRows(1).transpose() == below));
    BOOST_TEST(world.planner.get_planning_stats().path_cost_rad == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(without_a_free_motion_to_the_grid_an_end_stays_as_it_is) {
  World world(srmp::Auto{});
  world.planner.add_box("wall", {0.02, 3.0, 1.0}, {.p = {1.93, 1.8, 0.0}});  // beside `above`
  const srmp::RowMatrix path = world.plan(below, above).waypoints;
  BOOST_TEST((path.bottomRows(1).transpose() == above));
}

BOOST_AUTO_TEST_SUITE_END()
