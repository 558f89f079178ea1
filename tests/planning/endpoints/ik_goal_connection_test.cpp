#include "srmp/planning/endpoints/ik_goal_connection.hpp"

#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"

using namespace srmp;

namespace {

const Eigen::Vector3d steps = Eigen::Vector3d::Constant(0.25);
const Eigen::Vector3d bent(0.4, 1.2, -1.4);

Eigen::Vector3d tip_at(const Eigen::Vector3d& q) { return robots::planar3()->compute_fk(q).p; }

/// Three bars among three spheres. The one configuration that inverse kinematics finds for the goal is walled in;
/// others, which put the tip there too, are not.
PlannerInterface among_spheres(const PlannerOptions& options) {
  PlannerInterface planner;
  planner.add_articulation(robots::planar3()->description());
  for (const auto& [name, x, y] : {std::tuple{"a", 0.19, 0.96}, {"b", 1.07, -1.83}, {"c", -2.06, 0.74}})
    planner.add_sphere(name, 0.15, {.p = {x, y, 0.0}});
  planner.make_planner({"planar3"}, options);
  return planner;
}
const Eigen::Vector3d start(1.74, 1.61, 0.86), beyond(0.45, 2.6, 0.0);

}  // namespace

BOOST_AUTO_TEST_SUITE(ik_goal_connection)

BOOST_AUTO_TEST_CASE(from_a_state_near_a_target_to_a_configuration_that_meets_it) {
  const auto robot = robots::planar3();
  const Pose base = Pose::from_rpy({0.3, -0.2, 0.1}, {0.0, 0.0, 0.7});
  const auto world = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return base * p; };
  const std::vector<GoalConstraint> goals{GoalConstraint::joints(Eigen::Vector3d::Zero()),
                                          GoalConstraint::position(world({0.0, -2.0, 0.0})),
                                          GoalConstraint::position(world(tip_at(bent)))};
  const GoalConnection connection = make_ik_goal_connection({robot, base}, goals, steps);
  const Eigen::Vector3d near = bent + Eigen::Vector3d(0.15, -0.1, 0.2);
  const auto found = connection(near);
  BOOST_REQUIRE_EQUAL(found.size(), 1);
  BOOST_CHECK_EQUAL(found[0].goal, 2);
  BOOST_CHECK_LT((tip_at(found[0].q) - tip_at(bent)).norm(), 2e-5);
  BOOST_CHECK_LE((found[0].q - near).cwiseAbs().maxCoeff(), 0.5);
  BOOST_CHECK(connection(near)[0].q == found[0].q);
  BOOST_CHECK(connection(bent + Eigen::Vector3d(1.0, 0.0, 0.0)).empty());  // too far
}

BOOST_AUTO_TEST_CASE(poses_want_the_orientation_too_unless_it_is_free) {
  const auto robot = robots::planar3();
  const Pose there = robot->compute_fk(bent);
  GoalConstraint goal = GoalConstraint::pose(there);
  // The same point, with the last bar turned by 1.2 rad.
  const double angle = bent.sum() + 1.2;
  const Eigen::Vector2d wrist = there.p.head<2>() - Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const double elbow = 2.0 * std::acos(wrist.norm() / 2.0), first = std::atan2(wrist.y(), wrist.x()) - elbow / 2.0;
  const Eigen::Vector3d turned(first, elbow, angle - first - elbow);
  BOOST_REQUIRE_LT((tip_at(turned) - there.p).norm(), 1e-9);
  BOOST_CHECK(make_ik_goal_connection({robot}, {goal}, steps)(turned).empty());
  goal.rotation_tolerance = {0.01, 0.01, search::infinity};
  BOOST_CHECK_EQUAL(make_ik_goal_connection({robot}, {goal}, steps)(turned).size(), 1);
  const auto near = make_ik_goal_connection({robot}, {GoalConstraint::pose(there)}, steps)(bent + steps / 3);
  BOOST_REQUIRE_EQUAL(near.size(), 1);
  BOOST_CHECK_LT((near[0].q - bent).norm(), 1e-3);  // three joints for three axes: no other is near
}

BOOST_AUTO_TEST_CASE(joint_goals_have_none) {
  BOOST_CHECK(!make_ik_goal_connection({robots::planar3()}, {GoalConstraint::joints(bent)}, steps));
}

BOOST_AUTO_TEST_CASE(a_search_ends_where_the_known_configurations_cannot_be_reached) {
  CommonOptions common{.time_limit = 60, .resolution = 30, .direction = "forward", .ik_solutions = 1};
  common.ik_goal_connection = false;
  PlannerInterface without = among_spheres(WAStar{common});
  BOOST_CHECK_THROW(without.plan("planar3", start, GoalConstraint::position(beyond)), PlanningError);
  BOOST_CHECK(without.get_planning_stats().status == Status::exhausted);
  common.ik_goal_connection = true;
  const std::vector<PlannerOptions> all{WAStar{common}, ARAStar{.common = common, .final_weight = 10},
                                        MHAStar{.common = common, .inadmissible_heuristics = {"joint_euclidean"}},
                                        WPASE{common}, Auto{common}};
  for (const PlannerOptions& options : all) {
    PlannerInterface with = among_spheres(options);
    const std::vector<GoalConstraint> goals{GoalConstraint::position({5.0, 0.0, 0.0}),
                                            GoalConstraint::position(beyond)};
    const Trajectory t = with.plan("planar3", start, goals);
    BOOST_CHECK_LT((tip_at(t.waypoints.row(t.waypoints.rows() - 1).transpose()) - beyond).norm(), 2e-5);
    for (Eigen::Index i = 1; i < t.waypoints.rows(); ++i)
      BOOST_CHECK(with.is_motion_free("planar3", t.waypoints.row(i - 1).transpose(), t.waypoints.row(i).transpose()));
    BOOST_CHECK_EQUAL(with.get_planning_stats().goal_index, 1);
    BOOST_CHECK(t.positions == with.plan("planar3", start, goals).positions);
  }
}

BOOST_AUTO_TEST_SUITE_END()
