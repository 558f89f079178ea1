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
  srmp::GroupCheckers judge{scene, {"left", "right"}, {.mode = srmp::CheckMode::coal}};
  srmp::Checker::WorkspacePtr workspace = judge.pair(0, 1)->make_workspace();
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

  Trajectory in_time(const RowMatrix& rows) const { return srmp::time_parameterize(rows, {"a", "b"}, limits); }

  srmp::TimedTask task(const Trajectory& other, const Q& start, const Q& target) const {
    return {quick.alone(0),
            judge.alone(0),
            {{quick.pair(0, 1), judge.pair(0, 1), false, &other}},
            start,
            {target},
            {},
            limits,
            [this](const RowMatrix& rows) { return in_time(rows); }};
  }

  bool touch(const Q& left, const Eigen::VectorXd& right) const {
    Eigen::Vector4d both;
    both << left, right;
    return !judge.pair(0, 1)->is_free(both, *workspace);
  }
};

Trajectory motion(double duration, const Q& from, const Q& to) {
  Trajectory result{.joint_names = {"a", "b"}, .positions = RowMatrix(2, 2)};
  result.positions << from.transpose(), to.transpose();
  result.times = Eigen::Vector2d(0.0, duration);
  return result;
}

/// The first step at which the straight motion can begin, by looking at every millisecond (or so) of every one of them.
std::optional<int> first_departure(const Arms& arms, const Trajectory& other, const Q& start, const Q& target,
                                   double look = 1e-3) {
  RowMatrix ends(2, 2);
  ends << start.transpose(), target.transpose();
  const Trajectory moved = arms.in_time(ends);
  const double end = other.duration();
  for (int k = 0; k * step <= end + step; ++k) {
    bool free = true;
    for (double t = 0.0; t <= std::max(k * step + moved.duration(), end) && free; t += look)
      free = !arms.touch(moved.sample(std::max(t - k * step, 0.0)), other.sample(t));
    if (free) return k;
  }
  return std::nullopt;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(safe_intervals)

BOOST_AUTO_TEST_CASE(of_one_straight_motion_it_finds_the_first_departure_that_brute_force_finds) {
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
    BOOST_CHECK_LE(std::abs(found.stops.front().step - *expected), 1);  // it may not touch between milliseconds either
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

BOOST_AUTO_TEST_CASE(what_is_forbidden_for_a_while_is_forbidden_at_once) {
  const Arms arms;
  const Trajectory other = motion(3.1, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {1.2, 0.0});
  srmp::SafeIntervals map(task, never);
  const auto first = map.run(infinity, 10'000'000);
  BOOST_REQUIRE(first.status == srmp::Status::solved);
  const double touch = first.stops.front().leaves() + 0.01;
  map.forbid(first.stops, touch, touch + 0.5);
  const auto second = map.run(infinity, 10'000'000);
  BOOST_REQUIRE(second.status == srmp::Status::solved);
  BOOST_CHECK_EQUAL(second.stops.front().step, first.stops.front().step + 10);
}

BOOST_AUTO_TEST_CASE(once_time_is_up_it_says_so) {
  const Arms arms;
  const Trajectory other = motion(3.1, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::Deadline passed(0.0), cancelled(100.0, [] { return true; });
  srmp::SafeIntervals late(task, passed), stopped(task, cancelled);
  late.add_points(100'000'000);
  stopped.add_points(100'000'000);
  BOOST_CHECK(late.run(infinity, 10'000'000).status == srmp::Status::timed_out);
  BOOST_CHECK(stopped.run(infinity, 10'000'000).status == srmp::Status::cancelled);
}

BOOST_AUTO_TEST_CASE(a_target_at_which_it_cannot_stay_is_no_target) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {0.0, 0.0});  // ends in the middle, where this one is to end
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {0.0, 0.0});
  const auto found = srmp::SafeIntervals(task, never).run(infinity, 10'000'000);
  BOOST_CHECK(found.status == srmp::Status::exhausted);
  BOOST_CHECK_EQUAL(found.expansions, 0u);
}

BOOST_AUTO_TEST_CASE(a_plan_in_time_keeps_to_its_looks) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {0.3, 0.0}, {0.3, 0.0});
  const auto plan = [&](std::uint64_t& looks) { return srmp::plan_in_time(task, {infinity, 3, looks, never, never}); };
  std::uint64_t plenty = 10'000'000, none = 0, few = 2'000;
  const srmp::TimedAnswer answer = plan(plenty);
  BOOST_REQUIRE(answer.status == srmp::Status::solved);
  BOOST_CHECK_LT(plenty, 10'000'000u);
  BOOST_CHECK(answer.edge_checks > 0 && answer.memory_bytes > 0 && answer.expansions > 0);
  BOOST_CHECK(!srmp::Watch(task.others, never).find(answer.motion));
  BOOST_CHECK(plan(none).status == srmp::Status::timed_out);
  BOOST_CHECK_EQUAL(none, 0u);
  plan(few);
  BOOST_CHECK_EQUAL(few, 0u);
}

BOOST_AUTO_TEST_CASE(a_watch_says_who_touches_when_and_for_how_long) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const std::vector<srmp::MovingRobot> others{{nullptr, arms.judge.pair(0, 1), false, &other}};
  srmp::Watch watch(others, never);
  const Trajectory stays = motion(3.0, {0.0, 0.0}, {0.0, 0.0});
  const auto seen = watch.find(stays);
  BOOST_REQUIRE(seen && seen->touch);
  BOOST_CHECK(seen->body_a == "lower" && seen->body_b == "right/lower");
  BOOST_CHECK_EQUAL(seen->from, seen->to);
  const srmp::Meeting all = watch.extended(stays, *seen);
  BOOST_CHECK_LE(all.from, seen->from);
  BOOST_CHECK_GT(all.to, seen->to + step);
  BOOST_CHECK(arms.touch({0.0, 0.0}, other.sample(all.to)) && !arms.touch({0.0, 0.0}, other.sample(all.to + step)));
  const auto proved = watch.prove(stays);
  BOOST_REQUIRE(proved && proved->touch);
  BOOST_CHECK(arms.touch({0.0, 0.0}, other.sample(proved->from)));
  BOOST_CHECK(!watch.find(motion(3.0, {-2.0, 0.0}, {-2.0, 0.0})));
  BOOST_CHECK_GT(watch.looks(), 0u);
  // Once time is up nothing is proved.
  const srmp::Deadline passed(0.0);
  const auto open = srmp::Watch(others, passed).find(motion(3.0, {-1.0, 0.0}, {-1.0, 0.0}));
  BOOST_CHECK(open && !open->touch);
}

BOOST_AUTO_TEST_CASE(a_robot_has_arrived_when_it_rests_for_good) {
  RowMatrix rows(2, 2);
  rows << 0.0, 0.0, 1.0, 0.0;
  const Trajectory there = Arms().in_time(rows);
  const double end = srmp::end_of(there);
  BOOST_CHECK_EQUAL(srmp::arrival(there), end);
  BOOST_CHECK_CLOSE(srmp::arrival(srmp::delayed(there, 0.5)), end + 0.5, 1e-9);
  const Trajectory stays = srmp::rest({"a", "b"}, rows.bottomRows(1).replicate(2, 1), 3.0);
  BOOST_CHECK_EQUAL(srmp::arrival(there.followed_by(stays)), end);
  BOOST_CHECK_EQUAL(srmp::arrival(stays), 0.0);
}

BOOST_AUTO_TEST_CASE(nothing_later_than_asked_and_nothing_that_is_forbidden) {
  const Arms arms;
  const Trajectory other = motion(3.1, {-1.2, 0.0}, {1.2, 0.0});
  const srmp::TimedTask task = arms.task(other, {-1.2, 0.0}, {1.2, 0.0});
  srmp::SafeIntervals map(task, never);
  auto found = map.run(infinity, 10'000'000);
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  for (int k = 0; k < 5; ++k) {
    const int before = found.stops.front().step;
    const double touch = found.stops.front().leaves() + 0.01;
    map.forbid(found.stops, touch, touch);
    found = map.run(infinity, 10'000'000);
    BOOST_REQUIRE(found.status == srmp::Status::solved);
    BOOST_CHECK_GT(found.stops.front().step, before);
  }
  BOOST_CHECK(map.run(found.stops.front().leaves(), 10'000'000).status == srmp::Status::exhausted);
  BOOST_CHECK(map.run(infinity, 0).status == srmp::Status::timed_out);
  // It cannot wait for long at the start any more, nor go at once.
  map.forbid(found.stops, 0.12, 0.12);
  BOOST_CHECK(map.run(infinity, 10'000'000).status == srmp::Status::exhausted);
}

BOOST_AUTO_TEST_CASE(it_waits_only_where_nobody_comes_by) {
  const Arms arms;
  const Trajectory other = motion(3.0, {-1.2, 0.0}, {1.2, 0.0});
  const Q start(0.3, 0.0);
  const srmp::TimedTask task = arms.task(other, start, start);
  srmp::SafeIntervals map(task, never);
  BOOST_CHECK(map.run(infinity, 10'000'000).status == srmp::Status::exhausted);
  map.add_points(64);
  const auto found = map.run(infinity, 10'000'000);
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  BOOST_REQUIRE_GE(found.stops.size(), 3u);
  double arrived = 0.0;
  for (std::size_t k = 0; k < found.stops.size(); ++k) {
    const bool last = k + 1 == found.stops.size();
    const double until = last ? 4.0 : found.stops[k].leaves();
    BOOST_CHECK_LE(arrived, until + 1e-9);
    for (double t = arrived; t <= until; t += 1e-3) BOOST_CHECK(!arms.touch(found.stops[k].q, other.sample(t)));
    if (last) break;
    RowMatrix ends(2, 2);
    ends << found.stops[k].q.transpose(), found.stops[k + 1].q.transpose();
    const Trajectory moved = arms.in_time(ends);
    for (double t = 0.0; t <= moved.duration(); t += 1e-3)
      BOOST_CHECK(!arms.touch(moved.sample(t), other.sample(found.stops[k].leaves() + t)));
    arrived = found.stops[k].leaves() + moved.duration();
  }
  srmp::SafeIntervals again(task, never);
  again.add_points(64);
  const auto same = again.run(infinity, 10'000'000);
  BOOST_REQUIRE_EQUAL(same.stops.size(), found.stops.size());
  for (std::size_t k = 0; k < same.stops.size(); ++k)
    BOOST_CHECK(same.stops[k].q == found.stops[k].q && same.stops[k].step == found.stops[k].step);
}

BOOST_AUTO_TEST_SUITE_END()
