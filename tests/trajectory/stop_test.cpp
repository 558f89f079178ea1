#include "srmp/trajectory/stop.hpp"

#include <boost/test/unit_test.hpp>
#include <random>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/parameterize.hpp"

using namespace srmp;

// Stops on random motions, against what the limits allow at best.

namespace {

const std::vector<std::string> names{"a", "b", "c"};

MotionLimits limits_of(std::mt19937& random) {
  std::uniform_real_distribution<double> some(0.5, 3.0);
  MotionLimits limits;
  limits.velocity = Eigen::VectorXd::NullaryExpr(3, [&] { return some(random); });
  limits.acceleration = 3.0 * limits.velocity;
  limits.jerk = 20.0 * limits.acceleration;
  return limits;
}

RowMatrix waypoints_of(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> some(-2.0, 2.0);
  return RowMatrix::NullaryExpr(count, 3, [&] { return some(random); });
}

/// The largest fraction of its limit at many instants.
double largest_use(const Trajectory& motion, const MotionLimits& limits, bool jerk) {
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const MotionState at = motion.state(motion.duration() * (i + 0.5) / 2000.0);
    largest = std::max({largest, (at.velocity.array().abs() / limits.velocity.array()).maxCoeff(),
                        (at.acceleration.array().abs() / limits.acceleration.array()).maxCoeff()});
    if (jerk) largest = std::max(largest, (at.jerk.array().abs() / limits.jerk.array()).maxCoeff());
  }
  return largest;
}

/// The time in which the robot comes to rest on the path when it brakes as hard as the limits allow, in tiny steps.
double duration_in_tiny_steps(const Trajectory& motion, double t, const MotionLimits& limits) {
  double s = t, x = 1.0, time = 0.0;
  const double step = 2e-5, end = motion.times[motion.times.size() - 1];
  while (s < end && x > 1e-12) {
    const MotionState at = motion.state(s);
    if (at.velocity.norm() < 1e-4) break;  // a stop of the motion itself
    double braking = -1e9;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double v = at.velocity[j], a = at.acceleration[j] * x, limit = limits.acceleration[j];
      if (v != 0.0) braking = std::max(braking, v > 0.0 ? (-limit - a) / v : (limit - a) / v);
    }
    const double next = std::max(0.0, x + 2.0 * std::min(0.0, braking) * step);
    time += 2.0 * step / (std::sqrt(x) + std::sqrt(next));
    s += step, x = next;
  }
  return time;
}

}  // namespace

BOOST_AUTO_TEST_CASE(stops_are_as_fast_as_those_in_tiny_steps_and_keep_the_limits) {
  std::mt19937 random(1);
  for (int world = 0; world < 100; ++world) {
    const MotionLimits limits = limits_of(random);
    const Trajectory motion =
        time_parameterize(waypoints_of(random, 2 + world % 5), names, limits, {.blend_deviation = 0.05 * (world % 3)});
    for (int k = 0; k < 5; ++k) {
      const double t = motion.duration() * std::uniform_real_distribution<double>(0.0, 1.0)(random);
      const Trajectory stop = stop_on_path(motion, t, limits, {});
      const MotionState at = motion.state(t);
      BOOST_TEST((stop.positions.row(0).transpose() == at.position));
      BOOST_TEST(stop.velocities.bottomRows(1).isZero(0.0));
      if (stop.size() == 1) continue;
      BOOST_TEST((stop.velocities.row(0).transpose() == at.velocity));
      BOOST_TEST(largest_use(stop, limits, false) <= 1.0 + 1e-6);
      const double in_tiny_steps = duration_in_tiny_steps(motion, t, limits);
      BOOST_TEST(stop.duration() >= (at.velocity.array().abs() / limits.acceleration.array()).maxCoeff() - 1e-9);
      BOOST_TEST(stop.duration() <= 1.05 * in_tiny_steps + 2e-3,
                 "world " << world << ": " << stop.duration() << " s, " << in_tiny_steps << " s in tiny steps");
    }
  }
}

BOOST_AUTO_TEST_CASE(stops_beside_a_row_begin_there_and_keep_the_limits_in_their_rows) {
  std::mt19937 random(3);
  for (int world = 0; world < 30; ++world) {
    const MotionLimits limits = limits_of(random);
    const Trajectory motion = time_parameterize(waypoints_of(random, 3), names, limits);
    for (const double off : {-1e-6, -1e-9, -1e-12, -1e-16, 1e-12, 1e-9, 1e-6}) {
      const Eigen::Index row = 1 + (motion.times.size() / 3 + world) % (motion.times.size() - 2);
      const double t = motion.times[row] + 0.99 * off;
      const Trajectory stop = stop_on_path(motion, t, limits, {});
      BOOST_TEST((stop.positions.row(0) == motion.positions.row(row)));
      BOOST_TEST((stop.accelerations.array().abs().rowwise() / limits.acceleration.transpose().array()).maxCoeff() <=
                 1.0 + 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(stops_with_limited_jerk_keep_it_from_the_acceleration_on) {
  std::mt19937 random(2);
  for (int world = 0; world < 100; ++world) {
    const MotionLimits limits = limits_of(random);
    const Trajectory motion =
        time_parameterize(waypoints_of(random, 2 + world % 4), names, limits, {.method = TimingMethod::ruckig});
    BOOST_TEST(motion.velocities.row(0).isZero(0.0));
    BOOST_TEST(motion.velocities.bottomRows(1).isZero(0.0));
    BOOST_TEST(stop_on_path(motion, motion.duration(), limits, {.method = TimingMethod::ruckig}).size() == 1);
    const double t = motion.duration() * std::uniform_real_distribution<double>(0.0, 1.0)(random);
    const Trajectory stop = stop_on_path(motion, t, limits, {.method = TimingMethod::ruckig});
    if (stop.size() == 1) continue;
    BOOST_TEST((stop.accelerations.row(0).transpose() - motion.state(t).acceleration).cwiseAbs().maxCoeff() < 1e-6);
    BOOST_TEST(stop.velocities.bottomRows(1).isZero(0.0));
    BOOST_TEST(largest_use(stop, limits, true) <= 1.0 + 1e-6);
    BOOST_TEST(t + stop.duration() <= motion.duration() + 1e-2);
  }
}

BOOST_AUTO_TEST_CASE(a_motion_that_goes_on_begins_with_the_velocity_and_acceleration_that_are_given) {
  std::mt19937 random(3);
  for (int world = 0; world < 100; ++world) {
    const MotionLimits limits = limits_of(random);
    const RowMatrix path = waypoints_of(random, 2);
    const Eigen::VectorXd along = (path.row(1) - path.row(0)).transpose();
    for (const TimingMethod method : {TimingMethod::toppra, TimingMethod::ruckig}) {
      const Eigen::VectorXd velocity = 0.5 * along * (limits.velocity.array() / along.array().abs()).minCoeff();
      const Eigen::VectorXd acceleration =
          (world % 2 ? 0.3 : -0.3) * along * (limits.acceleration.array() / along.array().abs()).minCoeff();
      const Eigen::VectorXd lead = straight_stop(velocity, acceleration, limits, method);
      if (lead.norm() > 0.5 * along.norm()) continue;
      TimingOptions options{.method = method, .start_velocity = velocity, .start_acceleration = acceleration};
      const Trajectory motion = time_parameterize(path, names, limits, options);
      BOOST_TEST((motion.velocities.row(0).transpose() == velocity));
      BOOST_TEST(largest_use(motion, limits, method == TimingMethod::ruckig) <= 1.0 + 1e-6);
      if (method == TimingMethod::ruckig)
        BOOST_TEST((motion.accelerations.row(0).transpose() - acceleration).cwiseAbs().maxCoeff() < 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(motions_without_a_stop_are_refused) {
  std::mt19937 random(4);
  const MotionLimits limits = limits_of(random);
  const Trajectory motion = time_parameterize(waypoints_of(random, 3), names, limits);
  BOOST_CHECK_THROW(stop_on_path(motion, -0.1, limits, {}), InvalidArgument);
  BOOST_CHECK_THROW(stop_on_path(motion, motion.duration() + 0.1, limits, {}), InvalidArgument);
  BOOST_CHECK_THROW(stop_on_path(motion, std::nan(""), limits, {}), InvalidArgument);
  BOOST_CHECK_THROW(stop_on_path(motion.slice(0.0, 0.3), 0.29, limits, {}), InvalidArgument);
  MotionLimits slower = limits;
  slower.velocity *= 0.1;
  BOOST_CHECK_THROW(stop_on_path(motion, 0.5 * motion.duration(), slower, {}), InvalidArgument);
  // Somewhere in a rounded corner the path is not straight.
  bool refused = false;
  for (int i = 0; i < 50 && !refused; ++i) try {
      stop_on_path(motion, motion.duration() * i / 50.0, limits, {.method = TimingMethod::ruckig});
    } catch (const NotSupported&) {
      refused = true;
    }
  BOOST_TEST(refused);
}
