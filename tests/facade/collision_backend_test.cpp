#include <atomic>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <thread>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using Eigen::Vector2d;
using srmp::PlannerInterface;

namespace {

PlannerInterface planar_beside_post() {
  PlannerInterface planner;
  planner.add_articulation(robots::planar_description());
  planner.add_cylinder("post", 0.05, 1.0, {.p = {1.5, 0.0, 0.0}});
  planner.make_planner({"planar"}, srmp::Auto{});
  return planner;
}
const Vector2d below(-1.0, 0.0), above(1.0, 0.0);

}  // namespace

BOOST_AUTO_TEST_SUITE(collision_backend)

BOOST_AUTO_TEST_CASE(plans_check_by_the_users_checkers_and_find_the_same_path) {
  PlannerInterface own = planar_beside_post(), other = planar_beside_post();
  std::atomic<int> made{0};
  other.set_collision_backend(
      [&](const srmp::Scene& scene, const std::string& robot, const srmp::CheckerOptions& options) {
        ++made;
        return srmp::make_checker(scene, robot, options);
      });
  const auto goal = srmp::GoalConstraint::joints(above);
  const srmp::Trajectory a = own.plan("planar", below, goal), b = other.plan("planar", below, goal);
  BOOST_TEST(made == 1);
  BOOST_TEST((a.waypoints == b.waypoints));
  BOOST_TEST(b.certificate->proved_free());
}

BOOST_AUTO_TEST_CASE(a_backend_that_sees_too_little_cannot_make_a_path_in_collision_look_valid) {
  PlannerInterface planner = planar_beside_post();
  planner.set_collision_backend(
      [](const srmp::Scene& scene, const std::string& robot, const srmp::CheckerOptions& options) {
        srmp::Scene empty = scene;
        empty.remove_object("post");
        return srmp::make_checker(empty, robot, options);
      });
  check_throws<srmp::Error>([&] { planner.plan("planar", below, srmp::GoalConstraint::joints(above)); },
                            "the trajectory found for 'planar' is wrong");
}

BOOST_AUTO_TEST_CASE(a_clearance_is_refused_with_a_backend_of_ones_own_which_may_not_keep_it) {
  PlannerInterface planner = planar_beside_post();
  const auto goal = srmp::GoalConstraint::joints(above);
  planner.make_planner({"planar"}, srmp::Auto{.common = {.clearance = 0.01}});
  BOOST_TEST(planner.plan("planar", below, goal).certificate->clearance_kept->violation == 0.0);
  planner.set_collision_backend(srmp::make_checker);
  check_throws<srmp::NotSupported>([&] { planner.plan("planar", below, goal); },
                                   "clearance is 0.01 m, but a collision backend of your own cannot keep a clearance");
}

srmp::CheckerFactory slow_backend(std::atomic<int>& made) {
  return [&made](const srmp::Scene& scene, const std::string& robot, const srmp::CheckerOptions& options) {
    ++made;
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    return srmp::make_checker(scene, robot, options);
  };
}

BOOST_AUTO_TEST_CASE(the_time_of_a_plan_begins_before_its_checkers_are_made) {
  PlannerInterface planner = planar_beside_post();
  std::atomic<int> made{0};
  planner.set_collision_backend(slow_backend(made));
  planner.plan("planar", below, srmp::GoalConstraint::joints(above));
  BOOST_TEST(made == 1);
  BOOST_TEST(planner.get_planning_stats().total_time_s >= 0.03);
}

BOOST_AUTO_TEST_CASE(checkers_are_not_made_when_the_time_is_over) {
  for (const int threads : {1, 2}) {
    PlannerInterface planner;
    srmp::RobotDescription description = robots::planar_description();
    std::map<std::string, Eigen::VectorXd> starts;
    std::map<std::string, srmp::GoalConstraint> goals;
    for (const std::string name : {"a", "b", "c", "d", "e", "f"}) {
      description.name = name;
      planner.add_articulation(description, {.p = {5.0 * static_cast<double>(starts.size()), 0.0, 0.0}});
      starts.emplace(name, below);
      goals.emplace(name, srmp::GoalConstraint::joints(above));
    }
    planner.make_planner({"a", "b", "c", "d", "e", "f"},
                         srmp::Auto{.common = {.time_limit = 0.01}, .num_threads = threads});
    std::atomic<int> made{0};
    planner.set_collision_backend(slow_backend(made));
    check_throws<srmp::PlanningError>([&] { planner.plan_multi(starts, goals); },
                                      "the time limit passed while collision checkers were made");
    BOOST_TEST(made <= threads);
    const srmp::PlanStatistics& statistics = planner.get_planning_stats();
    BOOST_TEST((statistics.status == srmp::Status::timed_out));
    BOOST_TEST(statistics.total_time_s >= 0.03);
    BOOST_TEST((planner.last_result().has_value() && planner.last_request().has_value()));
    made = 0;
    check_throws<srmp::PlanningError>([&] { planner.plan_multi(starts, goals, {}, [] { return true; }); },
                                      "the plan was cancelled while collision checkers were made");
    BOOST_TEST(made <= 1);
  }
}

BOOST_AUTO_TEST_CASE(an_empty_backend_is_refused) {
  PlannerInterface planner;
  check_throws<srmp::InvalidArgument>([&] { planner.set_collision_backend({}); },
                                      "the collision backend is an empty function");
}

BOOST_AUTO_TEST_SUITE_END()
