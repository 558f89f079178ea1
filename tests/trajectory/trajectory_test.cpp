#include "srmp/trajectory/trajectory.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/path.hpp"
#include "support/robots.hpp"
#include "support/rows.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

constexpr double pi = std::numbers::pi;

Trajectory ramp() {
  Trajectory t;
  t.joint_names = {"a", "b"};
  t.positions.resize(3, 2);
  t.positions << 0, 0, 3, 4, 3, 5;
  t.times = Eigen::Vector3d(0, 1, 3);
  return t;
}

/// Joint a: t^3 - 2 t, joint b: 1 + 3 t^2; a cubic is what a trajectory follows, so it is exact at any time.
MotionState analytic(double t) {
  return {Eigen::Vector2d(t * t * t - 2 * t, 1 + 3 * t * t), Eigen::Vector2d(3 * t * t - 2, 6 * t),
          Eigen::Vector2d(6 * t, 6), Eigen::Vector2d(6, 0)};
}

Trajectory cubic_motion(const std::vector<double>& times = {0.5, 0.75, 1.5, 2.0, 3.0}) {
  const auto n = static_cast<Eigen::Index>(times.size());
  Trajectory t{{"a", "b"}, RowMatrix(n, 2), RowMatrix(n, 2), RowMatrix(n, 2), Eigen::VectorXd(n), rows({{0, 1}})};
  for (Eigen::Index i = 0; i < n; ++i) {
    t.times[i] = times[static_cast<std::size_t>(i)];
    const MotionState state = analytic(t.times[i]);
    t.positions.row(i) = state.position.transpose();
    t.velocities.row(i) = state.velocity.transpose();
    t.accelerations.row(i) = state.acceleration.transpose();
  }
  t.waypoints = t.positions;
  return t;
}

/// Rows that nothing but their positions and velocities ties together: accelerations and jerks jump at each.
Trajectory jumpy_motion() {
  Trajectory t{{"a", "b"},
               rows({{0, 0}, {0.3, -0.2}, {0.1, 0.4}, {0.1, 0.5}, {-0.5, 0.2}}),
               rows({{0, 0}, {0.5, 0.1}, {-0.7, 0.3}, {0, 0}, {-0.2, -0.1}}),
               {},
               Eigen::VectorXd(5),
               rows({{0, 0}, {-0.5, 0.2}})};
  t.times << 0, 0.4, 0.5, 1.3, 1.5;
  return t;
}

double difference(const MotionState& a, const MotionState& b) {
  return std::max({(a.position - b.position).cwiseAbs().maxCoeff(), (a.velocity - b.velocity).cwiseAbs().maxCoeff(),
                   (a.acceleration - b.acceleration).cwiseAbs().maxCoeff(), (a.jerk - b.jerk).cwiseAbs().maxCoeff()});
}

/// Largest difference of states between `from` and `to`, away from rows, where acceleration and jerk may jump.
double largest_difference(const Trajectory& a, const Trajectory& b, double from, double to) {
  double largest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double t = from + (to - from) * (i + 0.5) / 1000;
    if ((a.times.array() - t).abs().minCoeff() > 1e-6) largest = std::max(largest, difference(a.state(t), b.state(t)));
  }
  return largest;
}

/// Where the tip of robots::planar() is.
Eigen::Vector3d planar_tip(double a, double b) {
  return {std::cos(a) + std::cos(a + b), std::sin(a) + std::sin(a + b), 0};
}

PlacedRobot placed_planar() { return {robots::planar(), {}, Eigen::VectorXd(0)}; }

}  // namespace

BOOST_AUTO_TEST_CASE(a_trajectory_knows_its_length_and_duration) {
  BOOST_TEST(ramp().length() == 6.0);
  BOOST_TEST(ramp().duration() == 3.0);
  BOOST_TEST(ramp().size() == 3u);
  BOOST_TEST(ramp().dof() == 2u);
  BOOST_TEST(ramp().timed());
  BOOST_TEST(cubic_motion().duration() == 2.5);  // not from 0
  BOOST_TEST(Trajectory{}.duration() == 0.0);
  BOOST_TEST(Trajectory{}.length() == 0.0);
  BOOST_TEST(!Trajectory{}.timed());
}

BOOST_AUTO_TEST_CASE(without_velocities_the_motion_is_straight_and_stays_at_the_ends) {
  const Trajectory t = ramp();
  BOOST_TEST((t.sample(0.5) - Eigen::Vector2d(1.5, 2)).norm() < 1e-15);
  BOOST_TEST((t.sample(2.0) - Eigen::Vector2d(3, 4.5)).norm() < 1e-15);
  BOOST_TEST((t.sample(1.0) == Eigen::Vector2d(3, 4)));
  BOOST_TEST((t.sample(-1.0) == Eigen::Vector2d(0, 0)));
  BOOST_TEST((t.sample(3.0) == Eigen::Vector2d(3, 5)));
  BOOST_TEST((t.sample(std::numeric_limits<double>::infinity()) == Eigen::Vector2d(3, 5)));
  BOOST_TEST((t.state(1.0).velocity == Eigen::Vector2d(0, 0.5)));  // just after
  BOOST_TEST((t.state(3.0).velocity == Eigen::Vector2d(0, 0.5)));
  BOOST_TEST((t.state(0.3).acceleration.isZero(0) && t.jerks().isZero(0)));
}

BOOST_AUTO_TEST_CASE(states_are_those_of_the_polynomial) {
  const Trajectory t = cubic_motion();
  for (int i = 0; i <= 5000; ++i) {
    const double time = 0.5 + 2.5 * i / 5000;
    BOOST_TEST(difference(t.state(time), analytic(time)) < 1e-12 * 1e3);  // jerk: divided by 0.25^3
    BOOST_TEST((t.state(time).position - analytic(time).position).norm() < 1e-13);
  }
  BOOST_TEST((t.jerks() - rows({{6, 0}, {6, 0}, {6, 0}, {6, 0}, {6, 0}})).norm() < 1e-10);
  BOOST_TEST((t.state(9).position == analytic(3).position));
  BOOST_TEST((t.state(-9).velocity == analytic(0.5).velocity));
}

BOOST_AUTO_TEST_CASE(at_rows_the_motion_is_what_the_row_says_bit_for_bit) {
  Trajectory t = cubic_motion();
  t.accelerations(2, 0) = 77;  // also where the row says something else
  for (Eigen::Index i = 0; i < 5; ++i) {
    const MotionState state = t.state(t.times[i]);
    BOOST_TEST((state.position.transpose() == t.positions.row(i)));
    BOOST_TEST((state.velocity.transpose() == t.velocities.row(i)));
    BOOST_TEST((state.acceleration.transpose() == t.accelerations.row(i)));
  }
}

BOOST_AUTO_TEST_CASE(where_accelerations_and_jerks_jump_the_state_is_that_just_after) {
  const Trajectory t = jumpy_motion();
  const RowMatrix jerks = t.jerks();
  for (Eigen::Index i = 0; i < 4; ++i) {
    const MotionState at = t.state(t.times[i]), after = t.state(t.times[i] + 1e-9);
    BOOST_TEST((at.acceleration - after.acceleration).norm() < 1e-5);
    BOOST_TEST((at.jerk == after.jerk));
    BOOST_TEST((at.jerk.transpose() == jerks.row(i)));
  }
  BOOST_TEST((jerks.row(4) == jerks.row(3)));
  BOOST_TEST((t.state(1.5).jerk.transpose() == jerks.row(4)));
}

BOOST_AUTO_TEST_CASE(one_row_is_a_motion_that_stands) {
  Trajectory t = cubic_motion({1.0});
  const MotionState state = t.state(5);
  BOOST_TEST((state.position == analytic(1).position));
  BOOST_TEST((state.velocity == analytic(1).velocity));
  BOOST_TEST(state.jerk.isZero(0));
  BOOST_TEST(t.jerks().isZero(0));
  BOOST_TEST(t.resample(0.1).size() == 1u);
  BOOST_TEST(t.slice(0, 2).size() == 1u);
  BOOST_TEST(t.followed_by(cubic_motion({1.0, 2.0})).size() == 2u);
}

BOOST_AUTO_TEST_CASE(extrema_of_a_segment_are_found) {
  // Against 10 000 samples; straight lines, parabolas and segments without an extremum inside among them.
  const double q[] = {0, 1, -0.5, 0.25}, v[] = {0, 1, -2, 0.3};
  for (const double q0 : q)
    for (const double q1 : q)
      for (const double v0 : v)
        for (const double v1 : v)
          for (const double h : {0.1, 1.0, 3.0}) {
            const detail::Cubic segment = detail::hermite(q0, v0, q1, v1, h);
            BOOST_TEST(std::abs(segment.position(h) - q1) < 1e-14);
            BOOST_TEST(std::abs(segment.velocity(h) - v1) < 1e-12);
            double lowest = 1e9, highest = -1e9, fastest = 0;
            for (int i = 0; i <= 10000; ++i) {
              const double u = h * i / 10000;
              lowest = std::min(lowest, segment.position(u));
              highest = std::max(highest, segment.position(u));
              fastest = std::max(fastest, std::abs(segment.velocity(u)));
            }
            double low = std::min(q0, q1), high = std::max(q0, q1);
            for (const double u : segment.position_extrema()) {
              BOOST_TEST((u >= 0 && u <= h));
              low = std::min(low, segment.position(u));
              high = std::max(high, segment.position(u));
            }
            const double speed =
                std::max({std::abs(v0), std::abs(v1), std::abs(segment.velocity(segment.velocity_extremum()))});
            BOOST_TEST((low <= lowest + 1e-12 && low >= lowest - 1e-6));
            BOOST_TEST((high >= highest - 1e-12 && high <= highest + 1e-6));
            BOOST_TEST((speed >= fastest - 1e-9 && speed <= fastest * (1 + 1e-6)));
          }
}

BOOST_AUTO_TEST_CASE(resampling_has_a_row_at_every_multiple_and_at_the_end) {
  const Trajectory t = cubic_motion().resample(0.4);
  Eigen::VectorXd expected(8);
  expected << 0.5, 0.9, 1.3, 1.7, 2.1, 2.5, 2.9, 3.0;
  BOOST_TEST((t.times - expected).norm() < 1e-14);
  BOOST_TEST((t.waypoints == cubic_motion().waypoints));
  // One cubic stays the same one; others agree at the new rows only.
  BOOST_TEST(largest_difference(t, cubic_motion(), 0.5, 3) < 1e-9);
  const Trajectory jumpy = jumpy_motion(), fine = jumpy.resample(0.07);
  BOOST_TEST(fine.accelerations.rows() == 0);
  for (Eigen::Index i = 0; i < fine.times.size(); ++i) {
    BOOST_TEST((fine.positions.row(i).transpose() == jumpy.state(fine.times[i]).position));
    BOOST_TEST((fine.velocities.row(i).transpose() == jumpy.state(fine.times[i]).velocity));
  }
  BOOST_TEST(largest_difference(fine, jumpy, 0, 1.5) > 1e-3);
  BOOST_TEST(ramp().resample(1.0).velocities.rows() == 0);
  BOOST_TEST((ramp().resample(1.0).positions == rows({{0, 0}, {3, 4}, {3, 4.5}, {3, 5}})));
}

BOOST_AUTO_TEST_CASE(resampling_leaves_no_splinter_at_the_end) {
  // 2.5 s = 250 periods and a bit: the tick before the end would be nearly there.
  BOOST_TEST(cubic_motion().resample(0.01).size() == 251u);
  BOOST_TEST(cubic_motion({0, 1 + 1e-6}).resample(0.01).size() == 101u);
  BOOST_TEST(cubic_motion({0, 1.001}).resample(0.01).size() == 102u);
  BOOST_TEST(cubic_motion({0, 1.0}).resample(5.0).size() == 2u);
}

BOOST_AUTO_TEST_CASE(a_slice_is_the_same_motion) {
  for (const Trajectory& t : {cubic_motion(), jumpy_motion(), ramp()}) {
    const double first = t.times[0], length = t.duration();
    for (const double begin : {0.0, 0.07, 0.4})
      for (const double end : {0.5, 0.83, 1.0}) {
        const double from = first + begin * length, to = first + end * length;
        const Trajectory part = t.slice(from, to);
        BOOST_TEST(part.times[0] == from, boost::test_tools::tolerance(1e-15));
        BOOST_TEST(part.times[part.times.size() - 1] == to, boost::test_tools::tolerance(1e-15));
        BOOST_TEST(largest_difference(t, part, from, to) < 1e-8);
        BOOST_TEST((begin + end == 1.0 || part.waypoints == part.positions));
        BOOST_TEST(part.velocities.rows() == (t.velocities.rows() ? part.positions.rows() : 0));
        BOOST_TEST(part.accelerations.rows() == (t.accelerations.rows() ? part.positions.rows() : 0));
        BOOST_CHECK_NO_THROW(part.validate());
      }
  }
}

BOOST_AUTO_TEST_CASE(a_slice_keeps_path_and_certificate_only_when_nothing_is_cut_off) {
  Trajectory t = jumpy_motion();
  t.certificate = std::make_shared<const Certificate>();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Trajectory& whole : {t.slice(-infinity, infinity), t.slice(0, 1.5), t.rows(0, 5)}) {
    BOOST_TEST((whole.certificate == t.certificate));
    BOOST_TEST((whole.waypoints == t.waypoints));
  }
  for (const Trajectory& part : {t.slice(0, 1.4), t.slice(0.1, 2), t.rows(1, 5)}) {
    BOOST_TEST(!part.certificate);
    BOOST_TEST((part.waypoints == part.positions));
  }
  BOOST_TEST(!t.resample(0.1).certificate);
}

BOOST_AUTO_TEST_CASE(a_slice_is_cut_at_rows_that_are_near) {
  const Trajectory part = jumpy_motion().slice(0.4 + 1e-7, 1.3 - 1e-9);
  BOOST_TEST((part.times == Eigen::Vector3d(0.4, 0.5, 1.3)));
  BOOST_TEST(jumpy_motion().slice(0.4 + 1e-5, 1.3).size() == 3u);  // a row of its own, and one fewer
  BOOST_TEST(jumpy_motion().slice(1.5, 7).size() == 1u);
  BOOST_TEST(jumpy_motion().slice(0.4 - 1e-7, 0.4 + 1e-7).size() == 1u);
}

BOOST_AUTO_TEST_CASE(rows_are_the_same_motion_between_them) {
  const Trajectory t = cubic_motion(), part = t.rows(1, 4);
  BOOST_TEST((part.positions == t.positions.middleRows(1, 3)));
  BOOST_TEST((part.accelerations == t.accelerations.middleRows(1, 3)));
  BOOST_TEST((part.times == t.times.segment(1, 3)));
  BOOST_TEST(largest_difference(t, part, t.times[1], t.times[3]) == 0.0);
  Trajectory path{{"a", "b"}, rows({{0, 0}, {1, 1}, {2, 0}}), {}, {}, {}, {}};
  BOOST_TEST((path.rows(1, 3).positions == rows({{1, 1}, {2, 0}})));  // paths have rows too
  check_throws<InvalidArgument>([&] { t.rows(2, 2); }, "rows 2 to 2 hold nothing");
  check_throws<InvalidArgument>([&] { t.rows(0, 6); }, "more than its 5 rows");
}

BOOST_AUTO_TEST_CASE(joined_slices_are_the_motion_again) {
  for (const Trajectory& t : {cubic_motion(), jumpy_motion(), ramp()})
    for (const double fraction : {0.21, 0.5, 0.99}) {
      const double cut = t.times[0] + fraction * t.duration(), last = t.times[t.times.size() - 1];
      const Trajectory whole = t.slice(t.times[0], cut).followed_by(t.slice(cut, last));
      BOOST_TEST(whole.duration() == t.duration(), boost::test_tools::tolerance(1e-14));
      BOOST_TEST(largest_difference(t, whole, t.times[0], last) < 1e-8);
      BOOST_TEST((whole.waypoints == whole.positions));
      BOOST_CHECK_NO_THROW(whole.validate());
    }
}

BOOST_AUTO_TEST_CASE(the_next_motion_follows_in_time) {
  Trajectory first = cubic_motion({0, 1}), next = cubic_motion({1, 1.5, 3});
  next.times.array() += 100;
  next.accelerations(0, 1) = 5;
  const Trajectory both = first.followed_by(next);
  BOOST_TEST((both.times == Eigen::Vector4d(0, 1, 1.5, 3)));
  BOOST_TEST((both.positions == cubic_motion({0, 1, 1.5, 3}).positions));
  BOOST_TEST((both.waypoints == both.positions));  // the common point appears once
  BOOST_TEST(both.accelerations(1, 1) == 5);       // where it jumps: just after the row
  next.accelerations.resize(0, 2);
  BOOST_TEST(first.followed_by(next).accelerations.rows() == 0);
  first.waypoints.resize(0, 0);  // none known: its rows are a path
  BOOST_TEST((first.followed_by(next).waypoints == both.positions));
  first.certificate = std::make_shared<const Certificate>();
  BOOST_TEST(!first.followed_by(next).certificate);
}

BOOST_AUTO_TEST_CASE(motions_with_a_jump_between_them_are_not_joined) {
  const Trajectory t = cubic_motion({0, 1});
  const auto refused = [&](auto&& change, const std::string& why) {
    Trajectory next = cubic_motion({1, 2});
    change(next);
    check_throws<InvalidArgument>([&] { t.followed_by(next); }, why);
  };
  refused([](Trajectory& n) { n.joint_names = {"b", "a"}; }, "the next one moves 'b' and 'a', this one 'a' and 'b'");
  refused([](Trajectory& n) { n.positions(0, 1) += 2e-9; }, "another position than this one ends with: b jumps by 2");
  refused([](Trajectory& n) { n.velocities(0, 0) -= 2e-6; },
          "another velocity than this one ends with: a jumps by -1.9");
  refused([](Trajectory& n) { n.positions(0, 1) = NAN; }, "b jumps by NaN");
  refused([](Trajectory& n) { n.velocities.resize(0, 2); }, "one of the two has velocities, the other has none");
  refused([](Trajectory& n) { n.times.resize(0); }, "it has no times");
  Trajectory shifted = t, slow = cubic_motion({1, 1 + 1e-7});
  shifted.times.array() += 1e10;
  check_throws<InvalidArgument>([&] { shifted.followed_by(slow); }, "times must increase");
  Trajectory next = cubic_motion({1, 2});
  next.positions(0, 0) += 5e-10;
  next.velocities(0, 0) += 5e-7;
  BOOST_CHECK_NO_THROW(t.followed_by(next));
}

BOOST_AUTO_TEST_CASE(arguments_that_make_no_sense_are_refused) {
  const Trajectory t = cubic_motion();
  check_throws<InvalidArgument>([&] { t.sample(NAN); }, "NaN");
  check_throws<InvalidArgument>([&] { t.state(NAN); }, "the time to sample is NaN");
  for (const double dt : {0.0, -0.1, double(NAN), double(INFINITY)})
    check_throws<InvalidArgument>([&] { t.resample(dt); }, "must be a finite number above 0");
  check_throws<InvalidArgument>([&] { t.resample(1e-8); }, "more than ten million rows of this 2.5 s motion");
  Trajectory shifted = cubic_motion({0, 1e-6});
  shifted.times.array() += 1e9;
  shifted.times[1] = 1e9 + 1e-3;
  check_throws<InvalidArgument>([&] { shifted.resample(1e-7); }, "is lost beside times of 1000000000.001 s");
  check_throws<InvalidArgument>([&] { t.slice(1, 1); }, "a slice from 1 s to 1 s holds nothing of a motion from 0.5 s");
  check_throws<InvalidArgument>([&] { t.slice(2, 1); }, "holds nothing");
  check_throws<InvalidArgument>([&] { t.slice(4, 5); }, "holds nothing");
  check_throws<InvalidArgument>([&] { t.slice(0, 0.4); }, "holds nothing");
  check_throws<InvalidArgument>([&] { t.slice(NAN, 1); }, "the begin of the slice is NaN");
  check_throws<InvalidArgument>([&] { t.slice(0, NAN); }, "the end of the slice is NaN");
}

BOOST_AUTO_TEST_CASE(arrays_that_do_not_fit_are_refused) {
  const auto refused = [](auto&& change, const std::string& why) {
    Trajectory t = cubic_motion();
    change(t);
    for (const std::function<void()>& call : std::vector<std::function<void()>>{
             [&] { t.sample(1); }, [&] { t.state(1); }, [&] { t.jerks(); }, [&] { t.resample(0.1); },
             [&] { t.slice(1, 2); }, [&] { t.followed_by(cubic_motion()); }, [&] { cubic_motion().followed_by(t); }})
      check_throws<InvalidArgument>(call, why);
    if (why.find("no times") == std::string::npos) {
      check_throws<InvalidArgument>([&] { t.validate(); }, why);
      check_throws<InvalidArgument>([&] { t.rows(0, 1); }, why);
    }
  };
  refused([](Trajectory& t) { t.positions.resize(0, 2); }, "it has no rows");
  refused([](Trajectory& t) { t.joint_names.clear(); }, "it has no joints");
  refused([](Trajectory& t) { t.joint_names.pop_back(); }, "positions have the shape (5, 2), but there are 1 joint");
  refused([](Trajectory& t) { t.velocities.conservativeResize(4, 2); }, "velocities have the shape (4, 2), but posit");
  refused([](Trajectory& t) { t.accelerations.conservativeResize(5, 1); }, "accelerations have the shape (5, 1)");
  refused([](Trajectory& t) { t.times.conservativeResize(3); }, "it has 5 rows, but 3 times");
  refused([](Trajectory& t) { t.waypoints.resize(2, 3); }, "waypoints have the shape (2, 3)");
  refused([](Trajectory& t) { t.times.resize(0); }, "it has no times");
  check_throws<InvalidArgument>([] { Trajectory{}.sample(0.0); }, "no rows");
}

BOOST_AUTO_TEST_CASE(validation_finds_what_is_wrong_and_where) {
  BOOST_CHECK_NO_THROW(cubic_motion().validate());
  BOOST_CHECK_NO_THROW(jumpy_motion().validate());
  BOOST_CHECK_NO_THROW(ramp().validate());
  const auto refused = [](auto&& change, const std::string& why) {
    Trajectory t = cubic_motion();
    change(t);
    check_throws<InvalidArgument>([&] { t.validate(); }, why);
  };
  refused([](Trajectory& t) { t.joint_names[1] = "a"; }, "joint 'a' is named twice");
  refused([](Trajectory& t) { t.joint_names[1] = ""; }, "a joint name is empty");
  refused([](Trajectory& t) { t.positions(2, 1) = NAN; }, "positions, row 2: b is NaN");
  refused([](Trajectory& t) { t.velocities(0, 0) = INFINITY; }, "velocities, row 0: a is infinity");
  refused([](Trajectory& t) { t.accelerations(4, 0) = -INFINITY; }, "accelerations, row 4: a is -infinity");
  refused([](Trajectory& t) { t.waypoints(1, 0) = NAN; }, "waypoints, row 1: a is NaN");
  refused([](Trajectory& t) { t.times[0] = NAN; }, "the time of row 0 is NaN");
  refused([](Trajectory& t) { t.times[4] = INFINITY; }, "the time of row 4 is infinity");
  refused([](Trajectory& t) { t.times[2] = t.times[1]; }, "times must increase, but row 2 is at 0.75 s, after 0.75 s");
  refused([](Trajectory& t) { t.times[3] = 0.1; }, "times must increase, but row 3 is at 0.1 s, after 1.5 s");
  refused([](Trajectory& t) { t.times.resize(0); }, "it has velocities, but no times");
  refused([](Trajectory& t) { t.velocities.resize(0, 2); }, "it has accelerations, but no velocities");
  Trajectory hasty = ramp();
  hasty.times[0] = 0, hasty.times[1] = 1e-310;
  check_throws<InvalidArgument>([&] { hasty.validate(); }, "too little for the motion of a between them");
}

BOOST_AUTO_TEST_CASE(the_end_effector_goes_where_the_robot_puts_it) {
  const PlacedRobot robot = placed_planar();
  const Trajectory t = jumpy_motion();
  const RowMatrix path = t.end_effector_path(robot);
  for (Eigen::Index i = 0; i < 5; ++i)
    BOOST_TEST((path.row(i).transpose() - planar_tip(t.positions(i, 0), t.positions(i, 1))).norm() < 1e-14);
  const RowMatrix elbow = t.end_effector_path(robot, "lower");
  BOOST_TEST((elbow.row(1).transpose() - Eigen::Vector3d(std::cos(0.3), std::sin(0.3), 0)).norm() < 1e-14);
  // A base that stands elsewhere, and joints in another order.
  PlacedRobot moved = robot;
  moved.base = Pose::from_rpy({1, 2, 3}, {0, 0, pi / 2});
  BOOST_TEST((t.end_effector_path(moved).row(0).transpose() - Eigen::Vector3d(1, 4, 3)).norm() < 1e-14);
  Trajectory swapped = t;
  swapped.joint_names = {"b", "a"};
  swapped.positions = t.positions.rowwise().reverse();
  swapped.velocities = t.velocities.rowwise().reverse();
  swapped.waypoints.resize(0, 2);
  BOOST_TEST((swapped.end_effector_path(robot) == path));
  BOOST_TEST(swapped.end_effector_length(robot) == t.end_effector_length(robot));
}

BOOST_AUTO_TEST_CASE(the_end_effectors_way_is_measured_along_the_motion) {
  const PlacedRobot robot = placed_planar();
  // Half a turn of the stretched robot, in two rows: an arc of 2 m radius.
  Trajectory turn{{"a", "b"}, rows({{0, 0}, {pi, 0}}), rows({{0, 0}, {0, 0}}), {}, Eigen::Vector2d(0, 4), {}};
  BOOST_TEST(turn.end_effector_length(robot) == 2 * pi, boost::test_tools::tolerance(1e-4));
  BOOST_TEST(turn.end_effector_length(robot, "lower") == pi, boost::test_tools::tolerance(1e-4));
  const Trajectory path{{"a", "b"}, turn.positions, {}, {}, {}, {}};
  BOOST_TEST(path.end_effector_length(robot) == 2 * pi, boost::test_tools::tolerance(1e-4));
  // Rows in one place, but the motion between them goes out and back.
  const Trajectory there_and_back{{"a", "b"}, rows({{0, 0}, {0, 0}}), rows({{1, 0}, {-1, 0}}),
                                  {},         Eigen::Vector2d(0, 2),  {}};
  BOOST_TEST(there_and_back.end_effector_length(robot) == 2.0, boost::test_tools::tolerance(1e-4));
  BOOST_TEST(path.rows(0, 1).end_effector_length(robot) == 0.0);
}

BOOST_AUTO_TEST_CASE(an_end_effector_of_another_robot_is_refused) {
  const PlacedRobot robot = placed_planar();
  Trajectory t = jumpy_motion();
  check_throws<InvalidArgument>([&] { t.end_effector_path(); }, "it does not know its robot");
  check_throws<InvalidArgument>([&] { t.end_effector_length(); }, "it does not know its robot");
  check_throws<InvalidArgument>([&] { t.end_effector_path({}, ""); }, "it does not know its robot");
  check_throws<InvalidArgument>([&] { t.end_effector_path(robot, "lowre"); }, "did you mean 'lower'");
  const Trajectory one = {{"a"}, rows({{0}}), {}, {}, {}, {}};
  check_throws<InvalidArgument>([&] { one.end_effector_path(robot); }, "does not say where 'b' of robot 'planar' is");
  t.joint_names = {"a", "bb"};
  check_throws<InvalidArgument>([&] { t.end_effector_path(robot); },
                                "no planned joint of robot 'planar', did you mean");
  t = jumpy_motion();
  t.times *= 1e6;
  check_throws<InvalidArgument>([&] { t.end_effector_length(robot); }, "more than ten million points");
  t.positions(1, 1) = NAN;
  check_throws<InvalidArgument>([&] { t.end_effector_path(robot); }, "row 1: b is NaN");
}

BOOST_AUTO_TEST_CASE(a_plan_knows_its_robot_and_parts_and_joins_do_too) {
  PlannerInterface planner;
  planner.add_articulation(robots::planar_description(), Pose::from_rpy({0, 0, 1}, {0, 0, 0}));
  planner.make_planner({"planar"}, OptionMap{{"planner_id", std::string("wAstar")}});
  const auto plan = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    return planner.plan("planar", from, GoalConstraint::joints(to));
  };
  const Trajectory t = plan({0, 1}, {0.5, 1});
  BOOST_REQUIRE(t.robot);
  BOOST_TEST(t.end_effector_length() == 0.5 * std::sqrt(2 + 2 * std::cos(1)), boost::test_tools::tolerance(1e-3));
  BOOST_TEST((t.end_effector_path().row(0).transpose() - (planar_tip(0, 1) + Eigen::Vector3d(0, 0, 1))).norm() < 1e-14);
  for (const Trajectory& part : {t.slice(0.1, 0.2), t.rows(0, 2), t.resample(0.1)}) BOOST_TEST((part.robot == t.robot));
  const Trajectory next = plan({0.5, 1}, {0.2, 1});
  BOOST_TEST((t.followed_by(next).robot == t.robot));
  const auto many =
      planner.plan_many({{"planar", Eigen::Vector2d(0, 1), {GoalConstraint::joints(Eigen::Vector2d(1, 1))}}});
  BOOST_TEST((many[0].trajectory().robot && *many[0].trajectory().robot == *t.robot));
  planner.set_base_pose("planar", {});  // another place: the join has two
  const Trajectory elsewhere = plan({0.5, 1}, {0.2, 1});
  BOOST_TEST(!t.followed_by(elsewhere).robot);
  BOOST_TEST(t.end_effector_path()(0, 2) == 1.0);  // where it stood when it was planned
}

BOOST_AUTO_TEST_CASE(redundant_waypoints_go_and_the_path_stays) {
  const RowMatrix path = rows({{0, 0}, {0, 0}, {1, 1}, {2, 2}, {2, 2}, {2, 3}, {2, 5}, {2, 4}});
  const RowMatrix kept = without_redundant_waypoints(path);
  BOOST_TEST((kept == rows({{0, 0}, {2, 2}, {2, 5}, {2, 4}})));  // the way back is not on the way
  BOOST_TEST(path_length(kept) == path_length(path), boost::test_tools::tolerance(1e-15));
}

BOOST_AUTO_TEST_CASE(nearly_collinear_waypoints_stay) {
  const RowMatrix bent = rows({{0, 0}, {1, 1e-11}, {2, 0}});
  BOOST_TEST((without_redundant_waypoints(bent) == bent));
  BOOST_TEST(without_redundant_waypoints(rows({{0, 0}, {1, 1e-13}, {2, 0}})).rows() == 2);
  // A slow curve must not be straightened bit by bit.
  RowMatrix curve(200, 2);
  for (Eigen::Index i = 0; i < 200; ++i) curve.row(i) << static_cast<double>(i), 1e-12 * static_cast<double>(i * i);
  const RowMatrix kept = without_redundant_waypoints(curve);
  for (Eigen::Index i = 0, k = 0; i < 200; ++i) {
    while (kept(k + 1, 0) < curve(i, 0)) ++k;
    const double fraction = (curve(i, 0) - kept(k, 0)) / (kept(k + 1, 0) - kept(k, 0));
    BOOST_TEST(std::abs(kept(k, 1) + fraction * (kept(k + 1, 1) - kept(k, 1)) - curve(i, 1)) < 3e-10);
  }
}

BOOST_AUTO_TEST_CASE(short_paths_are_left_alone) {
  BOOST_TEST(without_redundant_waypoints(RowMatrix(0, 3)).rows() == 0);
  BOOST_TEST((without_redundant_waypoints(rows({{1, 2}})) == rows({{1, 2}})));
  BOOST_TEST((without_redundant_waypoints(rows({{1, 2}, {1, 2}})) == rows({{1, 2}})));
  BOOST_TEST((without_redundant_waypoints(rows({{1, 2}, {2, 2}, {1, 2}})) == rows({{1, 2}, {2, 2}, {1, 2}})));
}

BOOST_AUTO_TEST_CASE(unwrapping_goes_the_short_way_and_keeps_other_joints) {
  const RowMatrix unwrapped = unwrap_waypoints(rows({{3, 3}, {-3, -3}, {3, 3}, {9, 0}}), {true, false});
  const RowMatrix expected = rows({{3, 3}, {-3 + 2 * pi, -3}, {3, 3}, {9 - 2 * pi, 0}});
  BOOST_TEST((unwrapped - expected).norm() < 1e-14);
  BOOST_CHECK_NO_THROW(require_short_way(unwrapped, {true, false}));
}

BOOST_AUTO_TEST_CASE(the_long_way_round_is_refused) {
  const std::vector<std::string> names{"wrist", "elbow"};
  check_throws<InvalidArgument>([&] { require_short_way(rows({{3, 0}, {-3, 0}}), {true, false}, names); },
                                "wrist: the continuous joint moves by -6 rad from waypoint 0 to 1");
  BOOST_CHECK_NO_THROW(require_short_way(rows({{0, 3}, {0, -3}}), {true, false}, names));
  check_throws<InvalidArgument>([&] { unwrap_waypoints(rows({{3, 0}}), {true}); }, "2 joints, but 1 flags");
}

BOOST_AUTO_TEST_CASE(stacking_refuses_mixed_sizes) {
  const std::vector<Eigen::VectorXd> good{Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4)};
  BOOST_TEST((stack_waypoints(good) == rows({{1, 2}, {3, 4}})));
  BOOST_TEST((unstack_waypoints(rows({{1, 2}, {3, 4}})) == good));
  const std::vector<Eigen::VectorXd> bad{Eigen::Vector2d(1, 2), Eigen::Vector3d(3, 4, 5)};
  check_throws<InvalidArgument>([&] { stack_waypoints(bad); }, "waypoint 1 has 3 entries");
}
