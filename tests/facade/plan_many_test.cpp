#include <boost/test/unit_test.hpp>
#include <thread>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

namespace {

using srmp::GoalConstraint;
using srmp::PlanRequest;

/// The planar arm; a post stands in the way of its upper bar at 90 degrees.
srmp::PlannerInterface planar_world() {
  srmp::PlannerInterface planner;
  planner.add_articulation(robots::planar_description());
  planner.add_sphere("post", 0.1, {.p = {0.0, 1.2, 0.0}});
  planner.make_planner({"planar"}, srmp::WAStar{});
  return planner;
}

PlanRequest request(double from, double to) {
  return {"planar", Eigen::Vector2d(from, 0.5), {GoalConstraint::joints(Eigen::Vector2d(to, 0.5))}};
}

/// Round the post, straight, into the post (no such goal), and with planners of their own.
std::vector<PlanRequest> requests() {
  std::vector<PlanRequest> all{request(0.0, 2.5), request(0.0, 0.3), request(0.0, 1.37), request(2.5, 0.0)};
  all[2].goals = {GoalConstraint::joints(Eigen::Vector2d(M_PI / 2, 0.0))};
  for (const srmp::PlannerOptions& options : {srmp::PlannerOptions(srmp::Auto{}), srmp::PlannerOptions(srmp::WPASE{})})
    all.push_back({all[0].robot, all[0].start, all[0].goals, options});
  return all;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(plan_many)

BOOST_AUTO_TEST_CASE(every_result_is_what_plan_alone_would_have_found) {
  auto planner = planar_world();
  const auto all = requests();
  for (const int threads : {1, 2, 4, 9}) {
    const auto results = planner.plan_many(all, threads);
    BOOST_REQUIRE_EQUAL(results.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      auto alone = planar_world();
      if (all[i].options) alone.make_planner({"planar"}, *all[i].options);
      if (i == 2) {
        BOOST_CHECK_THROW(alone.plan("planar", all[i].start, all[i].goals), srmp::PlanningError);
      } else {
        BOOST_CHECK(alone.plan("planar", all[i].start, all[i].goals).positions == results[i].trajectory().positions);
      }
      const srmp::PlanStatistics &here = results[i].statistics(), &there = alone.get_planning_stats();
      BOOST_CHECK(here.status == there.status);
      BOOST_CHECK_EQUAL(here.reason, there.reason);
      BOOST_CHECK_EQUAL(here.expansions, there.expansions);
      BOOST_CHECK_EQUAL(here.edge_checks, there.edge_checks);
    }
  }
  BOOST_CHECK(planner.get_planning_stats().expansions == 0);  // of plan alone
}

BOOST_AUTO_TEST_CASE(a_result_without_a_trajectory_cannot_be_misread) {
  const auto results = planar_world().plan_many(requests(), 2);
  BOOST_CHECK(!results[2].solved());
  BOOST_CHECK(results[2].status() == srmp::Status::goal_invalid);
  check_throws<srmp::PlanningError>([&] { results[2].trajectory(); }, "'post'");
  BOOST_CHECK(results[3].solved());
  BOOST_CHECK_EQUAL(results[3].reason(), "");
}

BOOST_AUTO_TEST_CASE(nothing_asked_nothing_answered) { BOOST_CHECK(planar_world().plan_many({}, 3).empty()); }

BOOST_AUTO_TEST_CASE(wrong_requests_are_refused_with_their_number) {
  auto planner = planar_world();
  std::vector<PlanRequest> all = requests();
  const auto refused = [&](const std::string& sentence) {
    check_throws<srmp::InvalidArgument>([&] { planner.plan_many(all, 2); }, sentence);
    all = requests();
  };
  all[3].robot = "plnar";
  refused("request 3: ");
  all[1].start = Eigen::Vector3d::Zero();
  refused("request 1: ");
  all[4].goals.clear();
  refused("request 4: plan needs at least one goal");
  all[4].options = srmp::WAStar{.weight = 0.5};
  refused("request 4: ");
  all[4].options = all[5].options = srmp::WAStar{.common = {.heuristic = "bfs", .bfs_resolution = 1e-4}};
  refused("request 4: bfs_resolution");  // noticed while planning: the first is told
  check_throws<srmp::InvalidArgument>([&] { planner.plan_many(all, 0); }, "threads is 0; it must be at least 1");
  all[5].options = srmp::XECBS{};
  check_throws<srmp::NotSupported>([&] { planner.plan_many(all, 2); }, "request 5: ");
}

BOOST_AUTO_TEST_CASE(progress_is_told_in_the_callers_thread_and_rises_to_all) {
  auto planner = planar_world();
  const auto caller = std::this_thread::get_id();
  std::size_t last = 0;
  planner.plan_many(requests(), 2, {}, [&](std::size_t done, std::size_t all) {
    BOOST_CHECK(std::this_thread::get_id() == caller);
    BOOST_CHECK(done > last);
    BOOST_CHECK_EQUAL(all, 6);
    last = done;
  });
  BOOST_CHECK_EQUAL(last, 6);
}

BOOST_AUTO_TEST_CASE(an_interrupt_cancels_what_is_not_finished) {
  auto planner = planar_world();
  const srmp::AStar fine{{.time_limit = 60, .resolution = 0.02}};
  const std::vector<PlanRequest> all(5, {"planar", Eigen::Vector2d(0.0, 0.5), requests()[0].goals, fine});
  const auto results = planner.plan_many(all, 2, [] { return true; });
  for (const auto& result : results) BOOST_CHECK(result.status() == srmp::Status::cancelled);
  const auto fail = [](std::size_t, std::size_t) { throw std::runtime_error("enough"); };
  BOOST_CHECK_THROW(planner.plan_many(requests(), 2, {}, fail), std::runtime_error);
}

BOOST_AUTO_TEST_SUITE_END()
