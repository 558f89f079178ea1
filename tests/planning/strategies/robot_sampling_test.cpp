#include "srmp/planning/strategies/robot_sampling.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"

using namespace srmp;
using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

const Vector2d start(2.5, 0.0), goal(-2.5, 0.0);

/// Two bars, the first of which turns without limits; a sphere is in the way of the tip half-way, at half a turn.
PlannerInterface with_sphere(const PlannerOptions& options) {
  PlannerInterface planner;
  planner.add_articulation(robots::planar_description("continuous"));
  planner.add_sphere("sphere", 0.2, {.p = {-2.0, 0.0, 0.0}});
  planner.make_planner({"planar"}, options);
  return planner;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(robot_trees)

BOOST_AUTO_TEST_CASE(max_samples_are_near_the_ends_and_all_within_limits) {
  const auto robot = robots::planar();
  const search::RrtSpace space = rrt_space(*robot, Vector2d(0.1, -2.9), {Vector2d(0.3, -2.5)});
  BOOST_TEST((space.wraps == std::vector<char>{0, 0}));
  search::RandomSequence random(1);
  int near = 0;
  for (int i = 0; i < 1000; ++i) {
    const VectorXd q = space.sample(random);
    BOOST_TEST(!robot->limit_violation(q).has_value());
    near += q[0] > 0.1 - M_PI / 2 && q[0] < 0.3 + M_PI / 2 && q[1] < -2.5 + M_PI / 2;
  }
  BOOST_TEST(near > 750);
  BOOST_TEST(near < 950);
}

BOOST_AUTO_TEST_CASE(a_joint_without_limits_goes_the_short_way_round) {
  PlannerInterface planner = with_sphere(Auto{});
  const Trajectory trajectory = planner.plan("planar", start, GoalConstraint::joints(goal));
  const RowMatrix& path = trajectory.waypoints;
  BOOST_TEST(path.rows() > 2);
  for (Eigen::Index i = 1; i < path.rows(); ++i) BOOST_TEST(std::abs(path(i, 0) - path(i - 1, 0)) < M_PI);
  BOOST_TEST((path.row(0).transpose() == start));
  BOOST_TEST(path(path.rows() - 1, 0) == goal[0] + 2 * M_PI, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(path(path.rows() - 1, 1) == goal[1]);
  BOOST_TEST(planner.get_planning_stats().bound_graph == "every path");
}

BOOST_AUTO_TEST_CASE(what_trees_find_is_taken_only_within_the_weight) {
  Auto options;
  options.weight = 1.02;
  options.common.resolution = 8.0;
  PlannerInterface planner = with_sphere(options);
  planner.plan("planar", start, GoalConstraint::joints(goal));
  BOOST_TEST(planner.get_planning_stats().bound <= options.weight);
  BOOST_TEST(planner.get_planning_stats().bound_graph != "every path");
}

BOOST_AUTO_TEST_CASE(who_asks_for_a_heuristic_or_a_direction_gets_lattices) {
  for (const bool directed : {true, false}) {
    Auto options;
    if (directed) options.common.direction = "backward";
    if (!directed) options.common.heuristic = "joint_sum";
    PlannerInterface planner = with_sphere(options);
    planner.plan("planar", start, GoalConstraint::joints(goal));
    BOOST_TEST(planner.get_planning_stats().states > 0u);
  }
  PlannerInterface planner = with_sphere(Auto{});
  planner.plan("planar", start, GoalConstraint::joints(goal));
  BOOST_TEST(planner.get_planning_stats().states == 0u);
}

BOOST_AUTO_TEST_SUITE_END()
