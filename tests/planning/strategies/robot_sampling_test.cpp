#include "srmp/planning/strategies/robot_sampling.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "srmp/planner_interface.hpp"
#include "support/data.hpp"
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

BOOST_AUTO_TEST_CASE(the_margin_grows) {
  const auto robot = robots::planar();
  const Vector2d at(0.0, 0.0);
  const RobotSamplingOptions options{
      .first_margin = 0.25, .near_margin = 1.0, .growing_samples = 100, .far_fraction = 0.0};
  const search::RrtSpace space = rrt_space(*robot, at, {at}, options);
  search::RandomSequence random(1);
  double farthest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double distance = space.sample(random).lpNorm<Eigen::Infinity>();
    farthest = std::max(farthest, distance);
    BOOST_TEST(distance <= 0.25 + 0.75 * std::min(1.0, i / 100.0));
  }
  BOOST_TEST(farthest > 0.99);
}

BOOST_AUTO_TEST_CASE(the_first_samples_are_near_the_straight_motions_and_within_limits) {
  const auto robot = robots::planar();
  const Vector2d from(0.1, -2.9), goals[] = {{0.3, -2.5}, {-2.0, 2.5}};
  const RobotSamplingOptions options{.far_fraction = 1.0, .direct_samples = 500, .direct_distance = 0.1};
  const search::RrtSpace space = rrt_space(*robot, from, {goals[0], goals[1]}, options);
  const auto distance = [&from](const VectorXd& q, const Vector2d& goal) {
    const Vector2d motion = goal - from;
    return (q - from - std::clamp(motion.dot(q - from) / motion.squaredNorm(), 0.0, 1.0) * motion).norm();
  };
  const double widest = 2 * M_PI * std::sqrt(2.0);  // of the limits
  search::RandomSequence random(1);
  int near_first = 0, near_second = 0, far = 0;
  for (int i = 0; i < 1000; ++i) {
    const VectorXd q = space.sample(random);
    BOOST_TEST(!robot->limit_violation(q).has_value());
    const double to_first = distance(q, goals[0]), to_second = distance(q, goals[1]);
    if (i < 500) BOOST_TEST(std::min(to_first, to_second) <= 0.1 * widest);
    near_first += i < 500 && to_first < to_second;
    near_second += i < 500 && to_second < to_first;
    far += i >= 500 && std::min(to_first, to_second) > 0.1 * widest;
  }
  BOOST_TEST(near_first > 100);
  BOOST_TEST(near_second > 100);
  BOOST_TEST(far > 200);
}

BOOST_AUTO_TEST_CASE(samples_are_where_short_paths_pass) {
  const auto robot = robots::planar();
  const Vector2d from(0.1, -2.9), goals[] = {{0.3, -2.5}, {-2.0, 2.5}};
  const double longest = 7.0;
  const search::RrtSpace space =
      rrt_space(*robot, from, {goals[0], goals[1]}, {.max_length = longest, .informed_draws = 1'000'000});
  search::RandomSequence random(1);
  int only_first = 0, only_second = 0;
  for (int i = 0; i < 1000; ++i) {
    const VectorXd q = space.sample(random);
    const bool to_first = (q - from).norm() + (goals[0] - q).norm() <= longest,
               to_second = (q - from).norm() + (goals[1] - q).norm() <= longest;
    BOOST_TEST((to_first || to_second));
    only_first += to_first && !to_second;
    only_second += to_second && !to_first;
  }
  BOOST_TEST(only_first > 50);
  BOOST_TEST(only_second > 50);
}

BOOST_AUTO_TEST_CASE(samples_end_where_no_path_is_short) {
  const auto robot = robots::planar();
  const search::RrtSpace space = rrt_space(*robot, Vector2d(0.1, -2.9), {Vector2d(0.3, -2.5)}, {.max_length = 0.0});
  search::RandomSequence random(1);
  BOOST_TEST(!robot->limit_violation(space.sample(random)).has_value());
}

BOOST_AUTO_TEST_CASE(direct_samples_of_a_joint_without_limits_are_on_the_short_way_round) {
  const auto robot = robots::planar("continuous");
  const search::RrtSpace space = rrt_space(*robot, start, {goal}, {.direct_samples = 100, .direct_distance = 0.0});
  const auto copied = space.sample;
  search::RandomSequence random(1), same(1);
  for (int i = 0; i < 100; ++i) {
    const VectorXd q = space.sample(random);
    BOOST_TEST(q[0] >= start[0]);
    BOOST_TEST(q[0] <= goal[0] + 2 * M_PI);
    BOOST_TEST((copied(same) == q));
  }
}

BOOST_AUTO_TEST_CASE(tool_directions_move_the_end_effector_straight_along_its_axes) {
  const auto robot = RobotModel::load(arm7());
  const VectorXd at{{0.1, 0.4, -0.2, -1.5, 0.1, 1.9, 0.3}};
  search::RrtSpace space = rrt_space(*robot, at, {at});
  add_tool_directions(space, *robot, VectorXd(), 0.02);
  BOOST_REQUIRE(space.directions == 6u);
  const Pose before = robot->compute_fk(at, "");
  for (std::size_t direction = 0; direction < space.directions; ++direction) {
    VectorXd q = at;
    BOOST_REQUIRE(space.advance(q, direction));
    const Pose moved = before.inverse() * robot->compute_fk(q, "");
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    along[static_cast<Eigen::Index>(direction / 2)] = direction % 2 == 0 ? -0.02 : 0.02;
    BOOST_TEST((moved.p - along).norm() < 0.002);
    BOOST_TEST(moved.q.angularDistance(Eigen::Quaterniond::Identity()) < 0.02);
  }
}

BOOST_AUTO_TEST_CASE(tool_directions_are_refused_where_the_joints_cannot_move_so) {
  const auto robot = robots::planar();  // it moves in the plane z = 0
  const Vector2d at(0.3, 1.0);
  search::RrtSpace space = rrt_space(*robot, at, {at});
  add_tool_directions(space, *robot, VectorXd());
  int possible = 0;
  for (std::size_t direction = 0; direction < space.directions; ++direction) {
    VectorXd q = at;
    if (!space.advance(q, direction)) continue;
    ++possible;
    BOOST_TEST(!robot->limit_violation(q));
    BOOST_TEST((q - at).norm() > 0.0);
  }
  BOOST_TEST(possible <= 4);
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
