#include "srmp/planning/strategies/rrt_connect.hpp"

#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using Eigen::Vector2d;
using srmp::PlannerInterface;

namespace {

/// The planar arm beside a post that it must pass; the straight motion between the two configurations collides.
PlannerInterface planar_beside_post(double time_limit = 5.0) {
  PlannerInterface planner;
  planner.add_articulation(robots::planar_description());
  planner.add_cylinder("post", 0.05, 1.0, {.p = {1.5, 0.0, 0.0}});
  planner.make_planner({"planar"}, srmp::RRTConnect{{.time_limit = time_limit}});
  return planner;
}
const Vector2d below(-1.0, 0.0), above(1.0, 0.0);

}  // namespace

BOOST_AUTO_TEST_SUITE(rrt_connect_planner)

BOOST_AUTO_TEST_CASE(it_finds_a_proved_path_and_is_the_one_that_searched) {
  PlannerInterface planner = planar_beside_post();
  const srmp::Trajectory trajectory = planner.plan("planar", below, srmp::GoalConstraint::joints(above));
  BOOST_TEST(trajectory.certificate->proved_free());
  const srmp::PlanStatistics& statistics = planner.get_planning_stats();
  BOOST_TEST(statistics.found_by == "RRT-Connect");
  BOOST_TEST(statistics.states == 0u);         // no lattice
  BOOST_TEST(statistics.path_cost_rad > 2.0);  // longer than the straight line, which is the only bound there is
  BOOST_CHECK_CLOSE(statistics.bound, statistics.path_cost_rad / 2.0, 1e-9);
}

BOOST_AUTO_TEST_CASE(the_path_is_the_same_every_time) {
  const auto waypoints = [] {
    return planar_beside_post().plan("planar", below, srmp::GoalConstraint::joints(above)).waypoints;
  };
  BOOST_TEST((waypoints() == waypoints()));
}

BOOST_AUTO_TEST_CASE(a_start_that_is_the_goal_is_a_path) {
  PlannerInterface planner = planar_beside_post();
  const srmp::Trajectory trajectory = planner.plan("planar", below, srmp::GoalConstraint::joints(below));
  BOOST_TEST((trajectory.positions.bottomRows(1).transpose() == below));
  BOOST_TEST(planner.get_planning_stats().path_cost_rad == 0.0);
}

BOOST_AUTO_TEST_CASE(it_never_proves_that_there_is_no_path_but_stops_at_the_time_limit) {
  PlannerInterface planner = planar_beside_post(0.5);
  planner.add_box("wall", {0.1, 4.0, 1.0}, {.p = {-0.7, 0.0, 0.0}});
  planner.add_box("other_wall", {4.0, 0.02, 1.0}, {.p = {2.3, 0.0, 0.0}});
  const auto goal = srmp::GoalConstraint::pose(planner.compute_fk("planar", above));  // other configurations may do
  check_throws<srmp::PlanningError>([&] { planner.plan("planar", below, goal); },
                                    "no path within the time limit of 0.5 s");
  BOOST_TEST((planner.get_planning_stats().status == srmp::Status::timed_out));
}

BOOST_AUTO_TEST_SUITE_END()
