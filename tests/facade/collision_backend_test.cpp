#include <atomic>
#include <boost/test/unit_test.hpp>

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

BOOST_AUTO_TEST_CASE(an_empty_backend_is_refused) {
  PlannerInterface planner;
  check_throws<srmp::InvalidArgument>([&] { planner.set_collision_backend({}); },
                                      "the collision backend is an empty function");
}

BOOST_AUTO_TEST_SUITE_END()
