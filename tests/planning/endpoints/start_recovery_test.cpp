#include "srmp/planning/endpoints/start_recovery.hpp"

#include <boost/test/unit_test.hpp>
#include <map>

#include "collision/worlds.hpp"
#include "srmp/collision/scene_checker.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/trajectory/path.hpp"
#include "support/throws.hpp"

using namespace srmp;
using worlds::at;

namespace {

using Path = std::vector<Eigen::VectorXd>;

/// The gripper in front of the arm, fingers down.
Eigen::VectorXd ready() { return (Eigen::VectorXd(7) << 0.0, 0.0, 0.0, M_PI / 2, 0.0, M_PI / 2, 0.0).finished(); }

/// How high a slab under the fingers must be for `q` to be in it by `depth` [m].
double table_height(const Eigen::VectorXd& q, double depth) {
  double free = 0.2, touched = 0.6;
  while (touched - free > 1e-7) {
    const double height = 0.5 * (free + touched);
    Scene scene;
    scene.add_robot(worlds::arm7());
    scene.add_object("table", Box{{0.4, 0.4, 0.02}}, at(0.35, 0.0, height));
    const SceneChecker checker(scene, "arm7", {CheckMode::coal});
    (checker.is_free(q, *checker.make_workspace()) ? free : touched) = height;
  }
  return free + depth;
}

Scene gripper_in_table(double depth) {
  Scene scene;
  scene.add_robot(worlds::arm7());
  scene.add_object("table", Box{{0.4, 0.4, 0.02}}, at(0.35, 0.0, table_height(ready(), depth)));
  return scene;
}

PlannerInterface gripper_in_table_planner(double depth, const PlannerOptions& options) {
  PlannerInterface planner;
  RobotDescription description = worlds::arm7()->description();
  planner.add_articulation(description);
  planner.add_box("table", {0.4, 0.4, 0.02}, at(0.35, 0.0, table_height(ready(), depth)));
  planner.make_planner({"arm7"}, options);
  return planner;
}

/// The rule, by independent code and at other samples than the search's.
void check_recovery(const Checker& checker, const Eigen::VectorXd& start, const Path& path) {
  BOOST_REQUIRE_GE(path.size(), 2);
  BOOST_CHECK(path.front() == start);
  const auto workspace = checker.make_workspace();
  std::map<std::string, double> least;
  for (const Contact& c : checker.contacts(start, *workspace)) least[c.body_a + "|" + c.body_b] = -c.distance;
  for (std::size_t i = 1; i < path.size(); ++i)
    for (int k = 1; k <= 503; ++k) {
      const Eigen::VectorXd q = path[i - 1] + (path[i] - path[i - 1]) * (k / 503.0);
      BOOST_REQUIRE(!checker.robot().limit_violation(q));
      std::map<std::string, double> now;
      for (const Contact& c : checker.contacts(q, *workspace)) {
        const std::string pair = c.body_a + "|" + c.body_b;
        BOOST_REQUIRE_MESSAGE(least.contains(pair), "new: " << c.describe());
        BOOST_REQUIRE_MESSAGE(-c.distance <= least[pair] + recovery_tolerance, "deeper: " << c.describe());
        now[pair] = std::min(least[pair], -c.distance);
      }
      least = now;
    }
  BOOST_CHECK(least.empty());
  BOOST_CHECK(checker.is_free(path.back(), *workspace));
  BOOST_CHECK_EQUAL(recovery_violation(checker, path, *workspace), "");
}

Path recovery_of(const Checker& checker, const Eigen::VectorXd& start) {
  return find_start_recovery(checker, start, *checker.make_workspace());
}

double length(const Path& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

/// The planar arm, straight along x; `boxes` are 0.1 m cubes.
Scene planar_among(const std::vector<Eigen::Vector2d>& boxes) {
  Scene scene;
  scene.add_robot(robots::planar());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    scene.add_object("box" + std::to_string(i), Box{{0.1, 0.1, 0.1}}, at(boxes[i].x(), boxes[i].y(), 0.0));
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(start_recovery)

BOOST_AUTO_TEST_CASE(a_gripper_leaves_a_table_by_a_short_path) {
  for (const double depth : {0.0001, 0.001, 0.002, 0.003, 0.005, 0.009}) {
    const SceneChecker checker(gripper_in_table(depth), "arm7");
    const Path path = recovery_of(checker, ready());
    check_recovery(checker, ready(), path);
    BOOST_CHECK_LT(length(path), 0.02 + 10.0 * depth);  // the fingers are a third of a metre from joints 2 and 4
  }
}

BOOST_AUTO_TEST_CASE(it_goes_a_millimetre_beyond_contact_where_there_is_room) {
  const SceneChecker checker(gripper_in_table(0.003), "arm7");
  const auto nearest = checker.nearest(recovery_of(checker, ready()).back(), *checker.make_workspace());
  BOOST_CHECK_GT(nearest->distance, 0.5e-3);
}

BOOST_AUTO_TEST_CASE(several_pairs_are_separated_at_once) {
  Scene scene = planar_among({{0.6, 0.097}, {1.5, 0.098}});
  const SceneChecker both(scene, "planar");
  check_recovery(both, Eigen::Vector2d::Zero(), recovery_of(both, Eigen::Vector2d::Zero()));
  const SceneChecker sides(planar_among({{0.6, 0.097}, {1.5, -0.096}}), "planar");
  check_recovery(sides, Eigen::Vector2d::Zero(), recovery_of(sides, Eigen::Vector2d::Zero()));
  const SceneChecker self(planar_among({}), "planar");
  const Eigen::Vector2d folded(0.2, 3.0);
  if (!self.is_free(folded, *self.make_workspace())) check_recovery(self, folded, recovery_of(self, folded));
}

BOOST_AUTO_TEST_CASE(every_kind_of_shape_can_be_left_and_padding_counts) {
  for (const auto& [kind, shape] : worlds::every_kind()) {
    Scene scene;
    scene.add_robot(robots::planar());
    double y = 0.18;  // lowered until it touches the arm
    for (;; y -= 0.004) {
      Scene trial = scene;
      trial.add_object(kind, shape, at(1.5, y, 0.0), 0.01);
      const SceneChecker checker(trial, "planar", {CheckMode::coal});
      if (checker.is_free(Eigen::Vector2d::Zero(), *checker.make_workspace())) continue;
      BOOST_TEST_CONTEXT(kind)
      check_recovery(checker, Eigen::Vector2d::Zero(), recovery_of(checker, Eigen::Vector2d::Zero()));
      break;
    }
  }
}

BOOST_AUTO_TEST_CASE(joints_at_their_limits_leave_the_separation_to_the_others) {
  const SceneChecker checker(planar_among({{2.0 * std::cos(3.0) + 0.3, 2.0 * std::sin(3.0) - 0.14}}), "planar");
  const Eigen::Vector2d start(3.0, 0.0);  // the box is on the side that joint a could only leave beyond its limit
  BOOST_REQUIRE(!checker.is_free(start, *checker.make_workspace()));
  check_recovery(checker, start, recovery_of(checker, start));
}

BOOST_AUTO_TEST_CASE(there_is_no_path_where_every_motion_deepens_a_contact) {
  // The upper bar is held from both sides by the same depth.
  const SceneChecker held(planar_among({{0.6, 0.095}, {0.6, -0.095}}), "planar");
  BOOST_CHECK(recovery_of(held, Eigen::Vector2d::Zero()).empty());
  // Every motion out of one box leads into another.
  const SceneChecker between(planar_among({{0.9, 0.095}, {0.6, -0.101}, {0.3, -0.101}}), "planar");
  BOOST_CHECK(recovery_of(between, Eigen::Vector2d::Zero()).empty());
  // A link that no joint moves cannot be separated from an object.
  Scene rigid = gripper_in_table(0.002);
  rigid.add_object("wall", Box{{0.1, 0.1, 0.1}}, at(0.0, 0.1, 0.05));
  const SceneChecker walled(rigid, "arm7");
  BOOST_CHECK(recovery_of(walled, ready()).empty());
}

BOOST_AUTO_TEST_CASE(the_rule_is_broken_by_depth_by_new_pairs_and_by_an_end_in_contact) {
  const SceneChecker checker(planar_among({{0.6, 0.097}, {1.5, -0.15}}), "planar");
  const auto workspace = checker.make_workspace();
  const Eigen::Vector2d start(0.0, 0.0);
  const Path out = recovery_of(checker, start);
  BOOST_CHECK_EQUAL(recovery_violation(checker, out, *workspace), "");
  const auto broken = [&](const Path& path, const std::string& pair) {
    const std::string why = recovery_violation(checker, path, *workspace);
    BOOST_TEST(why.find(pair) != std::string::npos, why);
  };
  broken({start, Eigen::Vector2d(0.01, 0.0), out.back()}, "link 'upper' and object 'box0'");  // deeper first
  broken({start, Eigen::Vector2d(-0.08, 0.0)}, "link 'lower' and object 'box1'");             // new
  broken({start, Eigen::Vector2d(-0.002, 0.0)}, "link 'upper' and object 'box0'");            // not out yet
  broken({start, out.back(), start, out.back()}, "link 'upper' and object 'box0'");           // back in again
}

BOOST_AUTO_TEST_CASE(the_path_is_the_same_every_time) {
  const SceneChecker exact(gripper_in_table(0.004), "arm7"), coal(gripper_in_table(0.004), "arm7", {CheckMode::coal});
  const auto used = exact.make_workspace();
  const Path first = find_start_recovery(exact, ready(), *used);
  for (int i = 0; i < 3; ++i) BOOST_CHECK(find_start_recovery(exact, ready(), *used) == first);
  BOOST_CHECK(recovery_of(exact, ready()) == first);
  BOOST_CHECK(recovery_of(coal, ready()) == first);
}

BOOST_AUTO_TEST_CASE(every_check_may_end_the_search) {
  const SceneChecker checker(gripper_in_table(0.004), "arm7");
  int checks = 0;
  const auto stop = [&] {
    if (++checks == 20) throw std::runtime_error("enough");
  };
  BOOST_CHECK_THROW(find_start_recovery(checker, ready(), *checker.make_workspace(), stop), std::runtime_error);
}

// --- plans

BOOST_AUTO_TEST_CASE(plans_begin_at_the_start_and_leave_it_by_the_rule) {
  const Eigen::VectorXd goal = ready() + (Eigen::VectorXd(7) << 1.5, 0, 0, 0, 0, 0, 0).finished();
  const CommonOptions common{.recover_start = true};
  const std::vector<PlannerOptions> all{Auto{common},    WAStar{common}, ARAStar{common, 50.0, 10.0, 20.0},
                                        MHAStar{common}, WPASE{common},  Auto{.common = common, .improve_time = 0.05}};
  for (const PlannerOptions& options : all) {
    PlannerInterface planner = gripper_in_table_planner(0.003, options);
    const Trajectory t = planner.plan("arm7", ready(), GoalConstraint::joints(goal));
    const PlanStatistics& statistics = planner.get_planning_stats();
    BOOST_CHECK(t.positions.row(0).transpose() == ready());
    BOOST_CHECK(t.positions.row(t.positions.rows() - 1).transpose() == goal);
    BOOST_REQUIRE_GE(statistics.recovery_waypoints, 1);
    BOOST_TEST(statistics.note.find("'table' overlap by 3 mm): the trajectory begins with the way out of it") !=
               std::string::npos);
    const Path recovery = unstack_waypoints(t.waypoints.topRows(statistics.recovery_waypoints + 1));
    check_recovery(*planner.collision_checker("arm7"), ready(), recovery);
    BOOST_CHECK_CLOSE(length(recovery), statistics.recovery_cost_rad, 1e-9);
    BOOST_CHECK_CLOSE(path_length(t.waypoints), statistics.recovery_cost_rad + statistics.path_cost_rad, 1e-6);
    for (Eigen::Index i = statistics.recovery_waypoints + 1; i < t.waypoints.rows(); ++i)
      BOOST_CHECK(planner.is_motion_free("arm7", t.waypoints.row(i - 1).transpose(), t.waypoints.row(i).transpose()));
    BOOST_CHECK(t.positions == planner.plan("arm7", ready(), GoalConstraint::joints(goal)).positions ||
                std::holds_alternative<Auto>(options));  // improve_time is a clock
  }
}

BOOST_AUTO_TEST_CASE(solutions_begin_where_the_recovery_ends) {
  const Eigen::VectorXd goal = ready() + (Eigen::VectorXd(7) << 1.5, 0, 0, 0, 0, 0, 0).finished();
  PlannerInterface planner = gripper_in_table_planner(0.003, WAStar{{.recover_start = true}});
  Eigen::VectorXd first;
  const auto see = [&](const Solution&, ConstRows waypoints) {
    first = waypoints.row(0).transpose();
    return true;
  };
  const Trajectory t = planner.plan("arm7", ready(), GoalConstraint::joints(goal), {}, see);
  BOOST_CHECK(first == t.waypoints.row(planner.get_planning_stats().recovery_waypoints).transpose());
}

BOOST_AUTO_TEST_CASE(a_free_start_is_left_alone) {
  PlannerInterface with = gripper_in_table_planner(-0.01, Auto{{.recover_start = true}}),
                   without = gripper_in_table_planner(-0.01, Auto{});
  const auto goal = GoalConstraint::joints(ready() + Eigen::VectorXd::Unit(7, 0));
  BOOST_CHECK(with.plan("arm7", ready(), goal).positions == without.plan("arm7", ready(), goal).positions);
  BOOST_CHECK_EQUAL(with.get_planning_stats().recovery_waypoints, 0);
  BOOST_CHECK_EQUAL(with.get_planning_stats().recovery_cost_rad, 0.0);
  BOOST_CHECK_EQUAL(with.get_planning_stats().note, "");
}

BOOST_AUTO_TEST_CASE(starts_are_recovered_on_request_only) {
  PlannerInterface planner = gripper_in_table_planner(0.003, Auto{});
  const auto goal = GoalConstraint::joints(ready() + Eigen::VectorXd::Unit(7, 0));
  check_throws<PlanningError>([&] { planner.plan("arm7", ready(), goal); }, "'table' overlap by 3 mm");
  BOOST_CHECK(planner.get_planning_stats().status == Status::start_invalid);
}

BOOST_AUTO_TEST_CASE(a_start_that_cannot_be_left_is_an_error) {
  PlannerInterface planner;
  planner.add_articulation(robots::planar_description());
  planner.add_box("above", {0.1, 0.1, 0.1}, at(0.6, 0.095, 0.0));
  planner.add_box("below", {0.1, 0.1, 0.1}, at(0.6, -0.095, 0.0));
  planner.make_planner({"planar"}, Auto{{.recover_start = true}});
  const auto goal = GoalConstraint::joints(Eigen::Vector2d(1.5, 0.0));
  check_throws<PlanningError>([&] { planner.plan("planar", Eigen::Vector2d::Zero(), goal); },
                              "overlap by 5 mm, and no way out was found along which no pair gets deeper");
  BOOST_CHECK(planner.get_planning_stats().status == Status::start_invalid);
  check_throws<PlanningError>([&] { planner.plan("planar", Eigen::Vector2d(3.1, 0.0), goal); },
                              "the start is invalid: a: 3.1");  // starts outside of limits are not recovered
}

BOOST_AUTO_TEST_CASE(the_deadline_and_cancellation_hold_during_the_recovery) {
  PlannerInterface planner = gripper_in_table_planner(0.003, Auto{{.time_limit = 1e-4, .recover_start = true}});
  const auto goal = GoalConstraint::joints(ready() + Eigen::VectorXd::Unit(7, 0));
  check_throws<PlanningError>([&] { planner.plan("arm7", ready(), goal); }, "passed during the recovery of the start");
  BOOST_CHECK(planner.get_planning_stats().status == Status::timed_out);
  planner.make_planner({"arm7"}, Auto{{.recover_start = true}});
  check_throws<PlanningError>([&] { planner.plan("arm7", ready(), goal, [] { return true; }); },
                              "cancelled during the recovery of the start");
  BOOST_CHECK(planner.get_planning_stats().status == Status::cancelled);
}

BOOST_AUTO_TEST_SUITE_END()
