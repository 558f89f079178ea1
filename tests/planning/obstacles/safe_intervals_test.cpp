#include "srmp/planning/obstacles/safe_intervals.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "srmp/planning/group_checkers.hpp"
#include "srmp/planning/obstacles/plan_in_time.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/trajectory/parameterize.hpp"
#include "support/robots.hpp"

namespace {

using srmp::RowMatrix;
using srmp::Trajectory;
using Q = Eigen::Vector2d;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double step = 0.05;  // [s]
const srmp::Deadline never;

/// Two planar arms whose stretched arms reach into each other's half:   left ·──·──      ──·──· right
struct Arms {
  srmp::Scene scene = make_scene();
  srmp::GroupCheckers quick{scene, {"left", "right"}, {}};
  srmp::GroupCheckers exact{scene, {"left", "right"}, {.mode = srmp::CheckMode::coal}};
  srmp::Checker::WorkspacePtr workspace = exact.pair(0, 1)->make_workspace();
  srmp::MotionLimits limits = srmp::default_limits(quick.alone(0).robot());

  static srmp::Scene make_scene() {
    srmp::Scene scene;
    for (const std::string name : {"left", "right"}) {
      srmp::RobotDescription description = robots::planar_description();
      description.name = name;
      scene.add_robot(
          srmp::RobotModel::load(description),
          srmp::Pose::from_rpy({name == "left" ? 0.0 : 3.0, 0.0, 0.0}, {0.0, 0.0, name == "left" ? 0.0 : M_PI}));
    }
    return scene;
  }

  Trajectory parameterized(const RowMatrix& rows) const { return srmp::time_parameterize(rows, {"a", "b"}, limits); }

  srmp::TimedTask task(const Trajectory& other, const Q& start, const Q& target) const {
    return {quick.alone(0), exact.alone(0), {{quick.pair(0, 1), exact.pair(0, 1), false, &other}},
            start,          {target},       {},
            limits,         nullptr,        [this](const RowMatrix& rows) { return parameterized(rows); }};
  }

  bool collide(const Q& left, const Eigen::VectorXd& right) const {
    Eigen::Vector4d both;
    both << left, right;
    return !exact.pair(0, 1)->is_free(both, *workspace);
  }
};

Trajectory motion(double duration, const Q& from, const Q& to) {
  Trajectory result{.joint_names = {"a", "b"}, .positions = RowMatrix(2, 2)};
  result.positions << from.transpose(), to.transpose();
  result.times = Eigen::Vector2d(0.0, duration);
  return result;
}

/// The first step at which the straight motion can begin: brute force, every departure checked every `sample` seconds.
std::optional<int> first_departure(const Arms& arms, const Trajectory& other, const Q& start, const Q& target,
                                   double sample = 1e-3) {
  RowMatrix ends(2, 2);
  ends << start.transpose(), target.transpose();
  const Trajectory moved = arms.parameterized(ends);
  const double end = other.duration();
  for (int k = 0; k * step <= end + step; ++k) {
    bool free = true;
    for (double t = 0.0; t <= std::max(k * step + moved.duration(), end) && free; t += sample)
      free = !arms.collide(moved.sample(std::max(t - k * step, 0.0)), other.sample(t));
    if (free) return k;
  }
  return std::nullopt;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(safe_intervals)

BOOST_AUTO_TEST_CASE(the_departure_of_a_straight_motion_is_the_first_that_brute_force_finds) {
  const Arms arms;
  const Q start(-1.2, 0.0), target(1.2, 0.0);
  for (const double duration : {0.7, 1.9, 3.1, 6.3}) {
    const Trajectory other = motion(duration, {-1.2, 0.0}, {1.2, 0.0});
    const srmp::TimedTask task = arms.task(other, start, target);
    const auto found = srmp::SafeIntervals(task, never).run(infinity, 10'000'000);
    const auto expected = first_departure(arms, other, start, target);
    BOOST_REQUIRE(expected);
    BOOST_REQUIRE(found.status == srmp::Status::solved);
    BOOST_REQUIRE_EQUAL(found.stops.size(), 2u);
    BOOST_CHECK_LE(std::abs(found.stops.front().step - *expected), 1);  // it is collision-free between milliseconds too
    BOOST_CHECK_EQUAL(found.stops.front().leaves(), found.stops.front().step * step);
    BOOST_CHECK_EQUAL(found.stops.back().step, srmp::TimedStop::never);
  }
}

BOOST_AUTO_TEST_CASE(long_waits_are_tried_in_steps_of_a_64th) {
  const Arms arms;
  const Q start(-1.2, 0.0), target(1.2, 0.0);
  const Trajectory other = motion(20.0, {-0.2, 0.0}, {1.2, 0.0});  // long in the middle
  const srmp::TimedTask task = arms.task(other, start, target);
  const auto found = srmp::SafeIntervals(task, never).run(infinity, 10'000'000);
  const auto expected = first_departure(arms, other, start, target, 4e-3);
  BOOST_REQUIRE(expected);
  BOOST_REQUIRE_GT(*expected, 2 * 64);  // else every step is tried
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  BOOST_CHECK_GE(found.stops.front().step, *expected - 1);
  BOOST_CHECK_LE(found.stops.front().step, *expected + *expected / 64 + 1);
}

BOOST_AUTO_TEST_CASE(an_interval_is_forbidden_as_a_whole) {
  const Arms arms;
  const Trajectory other = motion(3.1, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {1.2, 0.0});
  srmp::SafeIntervals roadmap(task, never);
  const auto first = roadmap.run(infinity, 10'000'000);
  BOOST_REQUIRE(first.status == srmp::Status::solved);
  const double contact = first.stops.front().leaves() + 0.01;
  roadmap.forbid(first.stops, contact, contact + 0.5);
  const auto second = roadmap.run(infinity, 10'000'000);
  BOOST_REQUIRE(second.status == srmp::Status::solved);
  BOOST_CHECK_EQUAL(second.stops.front().step, first.stops.front().step + 10);
}

BOOST_AUTO_TEST_CASE(a_passed_deadline_is_reported) {
  const Arms arms;
  const Trajectory other = motion(3.1, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::Deadline passed(0.0), cancelled(100.0, [] { return true; });
  srmp::SafeIntervals late(task, passed), stopped(task, cancelled);
  late.add_vertices(100'000'000);
  stopped.add_vertices(100'000'000);
  BOOST_CHECK(late.run(infinity, 10'000'000).status == srmp::Status::timed_out);
  BOOST_CHECK(stopped.run(infinity, 10'000'000).status == srmp::Status::cancelled);
}

BOOST_AUTO_TEST_CASE(a_target_that_another_robot_crosses_later_is_no_goal) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {0.0, 0.0});  // ends in the middle, where this one is to end
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {0.0, 0.0});
  const auto found = srmp::SafeIntervals(task, never).run(infinity, 10'000'000);
  BOOST_CHECK(found.status == srmp::Status::exhausted);
  BOOST_CHECK_EQUAL(found.expansions, 0u);
}

BOOST_AUTO_TEST_CASE(plan_in_time_keeps_to_its_budget_of_checks) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {0.3, 0.0}, {0.3, 0.0});
  const auto plan = [&](std::uint64_t& checks) { return srmp::plan_in_time(task, {infinity, 3, checks, never}); };
  std::uint64_t plenty = 10'000'000, none = 0, few = 2'000;
  const srmp::TimedResult result = plan(plenty);
  BOOST_REQUIRE(result.status == srmp::Status::solved);
  BOOST_CHECK_LT(plenty, 10'000'000u);
  BOOST_CHECK(result.edge_checks > 0 && result.memory_bytes > 0 && result.expansions > 0);
  BOOST_CHECK(!srmp::CollisionMonitor(task.other_robots, never).find(result.motion));
  BOOST_CHECK(plan(none).status == srmp::Status::timed_out);
  BOOST_CHECK_EQUAL(none, 0u);
  plan(few);
  BOOST_CHECK_EQUAL(few, 0u);
}

BOOST_AUTO_TEST_CASE(improvements_have_a_counted_budget) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {0.3, 0.0}, {0.3, 0.0});
  const auto checks_with = [&](std::uint64_t improvement_checks) {
    constexpr std::uint64_t plenty = 10'000'000;
    std::uint64_t left = plenty;
    srmp::PlanInTimeOptions options;
    options.improvement_checks = improvement_checks;
    BOOST_CHECK(srmp::plan_in_time(task, {infinity, 3, left, never}, options).status == srmp::Status::solved);
    return plenty - left;
  };
  const std::uint64_t enough = checks_with(1'000'000);
  BOOST_CHECK_EQUAL(checks_with(2'000'000), enough);  // it ends when nothing more is gained
  BOOST_CHECK_LE(checks_with(0), enough);
}

BOOST_AUTO_TEST_CASE(a_monitor_says_which_bodies_collide_when_and_for_how_long) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const std::vector<srmp::MovingRobot> others{{nullptr, arms.exact.pair(0, 1), false, &other}};
  srmp::CollisionMonitor monitor(others, never);
  const Trajectory stays = motion(3.0, {0.0, 0.0}, {0.0, 0.0});
  const auto seen = monitor.find(stays);
  BOOST_REQUIRE(seen && seen->contact);
  BOOST_CHECK(seen->body_a == "lower" && seen->body_b == "right/lower");
  BOOST_CHECK_EQUAL(seen->from, seen->to);
  const srmp::CollisionInterval whole = monitor.extended(stays, *seen);
  BOOST_CHECK_LE(whole.from, seen->from);
  BOOST_CHECK_GT(whole.to, seen->to + step);
  BOOST_CHECK(arms.collide({0.0, 0.0}, other.sample(whole.to)) &&
              !arms.collide({0.0, 0.0}, other.sample(whole.to + step)));
  const auto proved = monitor.prove(stays);
  BOOST_REQUIRE(proved && proved->contact);
  BOOST_CHECK(arms.collide({0.0, 0.0}, other.sample(proved->from)));
  BOOST_CHECK(!monitor.find(motion(3.0, {-2.0, 0.0}, {-2.0, 0.0})));
  BOOST_CHECK_GT(monitor.checks(), 0u);
  // Once the deadline has passed, nothing is proved.
  const srmp::Deadline passed(0.0);
  const auto open = srmp::CollisionMonitor(others, passed).find(motion(3.0, {-1.0, 0.0}, {-1.0, 0.0}));
  BOOST_CHECK(open && !open->contact);
}

BOOST_AUTO_TEST_CASE(a_robot_has_arrived_once_it_is_stationary_for_good) {
  RowMatrix rows(2, 2);
  rows << 0.0, 0.0, 1.0, 0.0;
  const Trajectory there = Arms().parameterized(rows);
  const double end = srmp::end_of(there);
  BOOST_CHECK_EQUAL(srmp::arrival_time(there), end);
  BOOST_CHECK_CLOSE(srmp::arrival_time(srmp::delayed(there, 0.5)), end + 0.5, 1e-9);
  const Trajectory stays = srmp::stationary({"a", "b"}, rows.bottomRows(1).replicate(2, 1), 3.0);
  BOOST_CHECK_EQUAL(srmp::arrival_time(there.followed_by(stays)), end);
  BOOST_CHECK_EQUAL(srmp::arrival_time(stays), 0.0);
}

BOOST_AUTO_TEST_CASE(paths_are_earlier_than_max_arrival_and_avoid_what_is_forbidden) {
  const Arms arms;
  const Trajectory other = motion(3.1, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {1.2, 0.0});
  srmp::SafeIntervals roadmap(task, never);
  auto found = roadmap.run(infinity, 10'000'000);
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  for (int k = 0; k < 5; ++k) {
    const int before = found.stops.front().step;
    const double contact = found.stops.front().leaves() + 0.01;
    roadmap.forbid(found.stops, contact, contact);
    found = roadmap.run(infinity, 10'000'000);
    BOOST_REQUIRE(found.status == srmp::Status::solved);
    BOOST_CHECK_GT(found.stops.front().step, before);
  }
  BOOST_CHECK(roadmap.run(found.stops.front().leaves(), 10'000'000).status == srmp::Status::exhausted);
  BOOST_CHECK(roadmap.run(infinity, 0).status == srmp::Status::timed_out);
  // Now it can neither wait long at the start nor leave at once.
  roadmap.forbid(found.stops, 0.12, 0.12);
  BOOST_CHECK(roadmap.run(infinity, 10'000'000).status == srmp::Status::exhausted);
}

BOOST_AUTO_TEST_CASE(it_waits_only_at_vertices_that_others_do_not_cross) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const Q start(0.3, 0.0);
  const srmp::TimedTask task = arms.task(other, start, start);
  srmp::SafeIntervals roadmap(task, never);
  BOOST_CHECK(roadmap.run(infinity, 10'000'000).status == srmp::Status::exhausted);
  roadmap.add_vertices(64);
  const auto found = roadmap.run(infinity, 10'000'000);
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  BOOST_REQUIRE_GE(found.stops.size(), 3u);
  double arrived = 0.0;
  for (std::size_t k = 0; k < found.stops.size(); ++k) {
    const bool last = k + 1 == found.stops.size();
    const double until = last ? 4.0 : found.stops[k].leaves();
    BOOST_CHECK_LE(arrived, until + 1e-9);
    for (double t = arrived; t <= until; t += 1e-3) BOOST_CHECK(!arms.collide(found.stops[k].q, other.sample(t)));
    if (last) break;
    RowMatrix ends(2, 2);
    ends << found.stops[k].q.transpose(), found.stops[k + 1].q.transpose();
    const Trajectory moved = arms.parameterized(ends);
    for (double t = 0.0; t <= moved.duration(); t += 1e-3)
      BOOST_CHECK(!arms.collide(moved.sample(t), other.sample(found.stops[k].leaves() + t)));
    arrived = found.stops[k].leaves() + moved.duration();
  }
  srmp::SafeIntervals again(task, never);
  again.add_vertices(64);
  const auto same = again.run(infinity, 10'000'000);
  BOOST_REQUIRE_EQUAL(same.stops.size(), found.stops.size());
  for (std::size_t k = 0; k < same.stops.size(); ++k)
    BOOST_CHECK(same.stops[k].q == found.stops[k].q && same.stops[k].step == found.stops[k].step);
}

BOOST_AUTO_TEST_SUITE_END()
