#include "srmp/trajectory/parameterize.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

std::vector<std::string> names(Eigen::Index dof) {
  std::vector<std::string> result;
  for (Eigen::Index j = 0; j < dof; ++j) result.push_back("j" + std::to_string(j));
  return result;
}

MotionLimits uniform_limits(Eigen::Index dof, double v, double a, double j) {
  return {Eigen::VectorXd::Constant(dof, v), Eigen::VectorXd::Constant(dof, a), Eigen::VectorXd::Constant(dof, j), {}};
}

/// Numbers from a fixed sequence that is the same with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
  /// Spread evenly over orders of magnitude.
  double scale(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  Eigen::Index integer(Eigen::Index low, Eigen::Index high) {
    return low + static_cast<Eigen::Index>(engine_() % static_cast<unsigned>(high - low + 1));
  }

 private:
  std::mt19937 engine_;
};

struct Problem {
  RowMatrix waypoints;
  MotionLimits limits;
};

/// Steps of all sizes: none, 1e-9, small and large; one joint or many; there and back again.
Problem random_problem(Random& random, Eigen::Index max_waypoints = 7) {
  const Eigen::Index dof = random.integer(1, 8), count = random.integer(2, max_waypoints);
  Problem problem{RowMatrix(count, dof), uniform_limits(dof, 1, 1, 1)};
  for (Eigen::Index j = 0; j < dof; ++j) {
    problem.limits.velocity[j] = random.scale(0.1, 5);
    problem.limits.acceleration[j] = random.scale(0.3, 30);
    problem.limits.jerk[j] = random.scale(1, 1000);
    problem.waypoints(0, j) = random.uniform(-3, 3);
  }
  for (Eigen::Index i = 1; i < count; ++i) {
    problem.waypoints.row(i) = problem.waypoints.row(i - 1);
    const double kind = random.uniform(0, 1);
    if (kind < 0.1) continue;  // a waypoint twice
    if (kind < 0.2 && i > 1) {
      problem.waypoints.row(i) = problem.waypoints.row(i - 2);
      continue;
    }
    const double size = kind < 0.3 ? 1e-9 : kind < 0.5 ? random.scale(1e-6, 1e-2) : random.uniform(0.05, 1.5);
    for (Eigen::Index j = 0; j < dof; ++j)
      if (random.uniform(0, 1) < 0.7) problem.waypoints(i, j) += size * random.uniform(-1, 1);
  }
  return problem;
}

double distance_to_path(const Eigen::RowVectorXd& q, const RowMatrix& path) {
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Eigen::RowVectorXd edge = path.row(i + 1) - path.row(i), offset = q - path.row(i);
    const double along = edge.squaredNorm() > 0 ? std::clamp(offset.dot(edge) / edge.squaredNorm(), 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (offset - along * edge).norm());
  }
  return nearest;
}

/// Largest |value| / limit over all rows and joints.
double use_of(const RowMatrix& values, const Eigen::VectorXd& limit) {
  return (values.cwiseAbs().array().rowwise() / limit.transpose().array()).maxCoeff();
}

struct Uses {
  double velocity{}, acceleration{}, jerk{};
};

/// Of the polynomials between the rows, at their extrema. A rounded position moves a second difference by eps/h^2.
Uses uses_of(const Trajectory& t, const MotionLimits& limits) {
  Uses most;
  const auto take = [](double& most_of, double value, double limit, double rounding) {
    most_of = std::max(most_of, (std::abs(value) - rounding) / limit);
  };
  for (Eigen::Index i = 0; i + 1 < t.times.size(); ++i)
    for (Eigen::Index j = 0; j < t.positions.cols(); ++j) {
      const double h = t.times[i + 1] - t.times[i], eps = 4e-16 * (1.0 + std::abs(t.positions(i, j)));
      const auto segment =
          detail::hermite(t.positions(i, j), t.velocities(i, j), t.positions(i + 1, j), t.velocities(i + 1, j), h);
      for (const double u : {0.0, segment.velocity_extremum(), h})
        take(most.velocity, segment.velocity(u), limits.velocity[j], 2 * eps / h);
      for (const double u : {0.0, h})
        take(most.acceleration, segment.acceleration(u), limits.acceleration[j], 12 * eps / h / h);
      take(most.jerk, segment.jerk(), limits.jerk[j], 36 * eps / h / h / h);
    }
  return most;
}

void check_trajectory(const Trajectory& t, const Problem& problem, const TimingOptions& options) {
  const Eigen::Index n = t.positions.rows(), last = n - 1, end = problem.waypoints.rows() - 1;
  BOOST_REQUIRE(t.times.size() == n);
  BOOST_TEST((t.positions.allFinite() && t.velocities.allFinite() && t.accelerations.allFinite()));
  BOOST_TEST(((t.times.tail(last) - t.times.head(last)).array() > 0.0).all());
  BOOST_TEST((t.positions.row(0) == problem.waypoints.row(0)));
  BOOST_TEST((t.positions.row(last) == problem.waypoints.row(end)));
  BOOST_TEST((t.velocities.row(0).isZero(1e-12) && t.velocities.row(last).isZero(1e-12)));
  BOOST_TEST((t.waypoints == problem.waypoints));

  const Uses uses = uses_of(t, problem.limits);
  BOOST_TEST(uses.velocity <= 1.0 + 1e-6);
  BOOST_TEST(uses.acceleration <= 1.0 + 1e-6);
  if (options.method == TimingMethod::ruckig) BOOST_TEST(uses.jerk <= 1.0 + 1e-6);
  BOOST_TEST(use_of(t.velocities, problem.limits.velocity) <= 1.0 + 1e-9);

  double off_path = 0.0, at_milliseconds = 0.0;
  for (double time = 0.0; time < t.duration(); time += std::max(1e-3, t.duration() / 1000)) {
    const MotionState state = t.state(time);
    off_path = std::max(off_path, distance_to_path(state.position.transpose(), problem.waypoints));
    at_milliseconds =
        std::max(at_milliseconds, (state.velocity.array().abs() / problem.limits.velocity.array()).maxCoeff());
  }
  BOOST_TEST(off_path <= (options.method == TimingMethod::ruckig ? 2e-7 : options.blend_deviation * 1.01 + 2e-7));
  BOOST_TEST(at_milliseconds <= 1.0 + 1e-6);
}

TimingOptions with(TimingMethod method, double sample_period) {
  return {.method = method, .sample_period = sample_period};
}

constexpr TimingMethod both_methods[] = {TimingMethod::toppra, TimingMethod::ruckig};

}  // namespace

BOOST_AUTO_TEST_CASE(a_thousand_random_paths_obey_every_limit_at_every_instant) {
  Random random(20);
  for (int i = 0; i < 1000; ++i) {
    const Problem problem = random_problem(random, i % 20 == 0 ? 200 : 7);
    for (const TimingMethod method : both_methods) BOOST_TEST_CONTEXT("path " << i << ", method " << int(method)) {
        const TimingOptions options = with(method, 0.02);
        check_trajectory(time_parameterize(problem.waypoints, names(problem.waypoints.cols()), problem.limits, options),
                         problem, options);
      }
  }
}

BOOST_AUTO_TEST_CASE(extreme_limits_and_lengths_are_solved) {
  Random random(21);
  for (int i = 0; i < 2000; ++i) {
    BOOST_TEST_CONTEXT("path " << i) {
      RowMatrix path(2, 1);
      path << 0.5, 0.5 + random.scale(1e-12, 1e3);
      const MotionLimits limits =
          uniform_limits(1, random.scale(1e-4, 1e4), random.scale(1e-4, 1e6), random.scale(1e-4, 1e8));
      const double length = path(1) - path(0);
      const double shortest = std::max({length / limits.velocity[0], std::sqrt(4 * length / limits.acceleration[0]),
                                        std::cbrt(32 * length / limits.jerk[0])});
      const Trajectory t =
          time_parameterize(path, {"j"}, limits, with(TimingMethod::ruckig, std::max(1e-3, shortest / 100)));
      const Uses uses = uses_of(t, limits);
      BOOST_TEST(uses.velocity <= 1.0 + 1e-6);
      BOOST_TEST(uses.acceleration <= 1.0 + 1e-6);
      BOOST_TEST(uses.jerk <= 1.0 + 1e-6);
      BOOST_TEST(t.duration() >= shortest * (1 - 1e-6));  // no limit alone allows less …
      BOOST_TEST(t.duration() <= 3 * shortest + 2e-3);    // … and all together not much more
    }
  }
}

BOOST_AUTO_TEST_CASE(straight_motions_are_as_fast_as_velocity_and_acceleration_allow) {
  Random random(22);
  for (int i = 0; i < 2000; ++i) {
    BOOST_TEST_CONTEXT("path " << i) {
      RowMatrix path(2, 2);
      path << 0.0, 1.0, random.scale(1e-6, 1e2), 1.0;
      const double length = path(1, 0), v = random.scale(1e-4, 1e4), a = random.scale(1e-3, 1e5);
      const double fastest = v * v < a * length ? length / v + v / a : 2.0 * std::sqrt(length / a);  // trapezoids
      const Trajectory t = time_parameterize(path, {"a", "b"}, uniform_limits(2, v, a, 1),
                                             with(TimingMethod::toppra, std::max(1e-3, fastest / 100)));
      BOOST_TEST(t.duration() >= fastest * (1.0 - 1e-6));
      BOOST_TEST(t.duration() <= 1.01 * fastest + 1e-3);  // no motion is shorter than a millisecond
    }
  }
}

BOOST_AUTO_TEST_CASE(slow_motions_that_begin_in_motion_are_timed) {
  Random random(24);
  for (int i = 0; i < 500; ++i) {
    BOOST_TEST_CONTEXT("path " << i) {
      RowMatrix path(random.integer(3, 8), 1);
      path(0) = 0.0;
      for (Eigen::Index k = 1; k < path.rows(); ++k) path(k) = path(k - 1) + random.uniform(0.1, 2.0);
      const double v = random.scale(1e-4, 1e-3);
      TimingOptions options = with(TimingMethod::toppra, 1e3);
      options.start_velocity = Eigen::VectorXd::Constant(1, v * random.uniform(0.0, 1.0));
      BOOST_CHECK_NO_THROW(time_parameterize(path, {"j"}, uniform_limits(1, v, random.uniform(1.0, 20.0), 1), options));
    }
  }
}

BOOST_AUTO_TEST_CASE(limits_of_all_sizes_are_kept_together) {
  Random random(23);
  for (int i = 0; i < 1000; ++i) {
    BOOST_TEST_CONTEXT("path " << i) {
      Problem problem = random_problem(random);
      for (Eigen::Index j = 0; j < problem.waypoints.cols(); ++j) {
        problem.limits.velocity[j] = random.scale(1e-3, 1e8);
        problem.limits.acceleration[j] = random.scale(1e-5, 1e5);
      }
      const Trajectory t = time_parameterize(problem.waypoints, names(problem.waypoints.cols()), problem.limits,
                                             with(TimingMethod::toppra, 1e3));
      const Uses uses = uses_of(t, problem.limits);
      BOOST_TEST(uses.velocity <= 1.0 + 1e-6);
      BOOST_TEST(uses.acceleration <= 1.0 + 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_duration_is_the_min_that_the_limits_allow) {
  RowMatrix path(2, 2);
  path << 0, 0, 2, 1;
  // Joint 0 decides: v = 1, a = 2, j = 20: ramps of v/a + a/j = 0.6 s, so 2/1 + 0.6 s in all.
  const Trajectory t =
      time_parameterize(path, {"a", "b"}, default_limits(Eigen::Vector2d(1, 1)), with(TimingMethod::ruckig, 0.01));
  BOOST_TEST(t.duration() == 2.6, boost::test_tools::tolerance(1e-7));
  BOOST_TEST(use_of(t.velocities, Eigen::Vector2d(1, 1)) > 1 - 1e-6);
}

BOOST_AUTO_TEST_CASE(samples_are_at_every_period_and_at_every_corner) {
  RowMatrix path(3, 1);
  path << 0, 0.3, 0.1;
  const Trajectory t = time_parameterize(path, {"j"}, uniform_limits(1, 1, 2, 20), with(TimingMethod::ruckig, 0.05));
  bool corner = false;
  int multiples = 0;
  for (Eigen::Index i = 0; i < t.times.size(); ++i) {
    corner = corner || std::abs(t.positions(i, 0) - 0.3) < 1e-15;
    const double ticks = t.times[i] / 0.05;
    multiples += std::abs(ticks - std::round(ticks)) < 1e-2;
  }
  BOOST_TEST(corner);
  BOOST_TEST(multiples >= 1 + static_cast<int>(t.duration() / 0.05));
}

BOOST_AUTO_TEST_CASE(a_long_period_still_gives_all_corners) {
  RowMatrix path(4, 2);
  path << 0, 0, 1, 0, 1, 1, 0, 1;
  const Trajectory t =
      time_parameterize(path, {"a", "b"}, uniform_limits(2, 1, 2, 20), with(TimingMethod::ruckig, 1e6));
  for (Eigen::Index corner = 0; corner < 4; ++corner)
    BOOST_TEST((t.positions.rowwise() - path.row(corner)).rowwise().norm().minCoeff() < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_path_of_one_place_takes_no_time) {
  for (const Eigen::Index count : {1, 2, 5}) {
    const Trajectory t = time_parameterize(RowMatrix::Constant(count, 3, 0.25), names(3), uniform_limits(3, 1, 2, 20));
    BOOST_TEST(t.duration() == 0.0);
    BOOST_TEST(t.size() == 1u);
    BOOST_TEST(t.velocities.isZero(0.0));
    BOOST_TEST((t.sample(7.0) == Eigen::Vector3d::Constant(0.25)));
  }
}

BOOST_AUTO_TEST_CASE(the_smallest_steps_take_time_too) {
  RowMatrix path(4, 1);
  path << 1.0, std::nextafter(1.0, 2.0), 1.0, 0.0;
  path.conservativeResize(6, 1);
  path(4) = std::numeric_limits<double>::denorm_min();
  path(5) = 0.0;
  const Problem problem{path, uniform_limits(1, 1, 2, 20)};
  for (const TimingMethod method : both_methods)
    check_trajectory(time_parameterize(path, {"j"}, problem.limits, with(method, 1e-3)), problem, with(method, 1e-3));
}

BOOST_AUTO_TEST_CASE(the_slowest_joints_move_too) {
  RowMatrix path(2, 1);
  path << 0.0, 100.0;
  const Trajectory t = time_parameterize(path, {"j"}, uniform_limits(1, 1e-6, 1, 10), {.sample_period = 1e6});
  BOOST_TEST(t.duration() == 1e8, boost::test_tools::tolerance(0.05));  // speeds up along a grid interval
}

BOOST_AUTO_TEST_CASE(short_paths_and_close_waypoints_keep_the_limits_in_their_rows) {
  const MotionLimits limits = uniform_limits(3, 1, 2, 20);
  const auto check = [&](const RowMatrix& path) {
    const Trajectory t = time_parameterize(path, names(3), limits);
    BOOST_TEST(use_of(t.accelerations, limits.acceleration) <= 1.0 + 1e-4);
    return t;
  };
  for (double length = 1.0; length > 1e-18; length /= 10.0) {
    RowMatrix path = RowMatrix::Zero(2, 3);
    path.row(1).setConstant(length);
    BOOST_TEST_CONTEXT("length " << length) { BOOST_TEST(check(path).duration() >= 1e-3); }
  }
  Random random(22);
  for (const int count : {100, 1'000, 5'000}) BOOST_TEST_CONTEXT(count << " waypoints") {  // of a circle, unevenly
      RowMatrix path(count, 3);
      for (Eigen::Index i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * (static_cast<double>(i) + random.uniform(0.0, 0.9)) / count;
        path.row(i) << 0.3 * std::cos(angle), 0.3 * std::sin(angle), 0.1 * angle;
      }
      const Trajectory t = check(path);
      BOOST_TEST(t.duration() < 6.0);
      BOOST_TEST(t.size() < 4u * static_cast<unsigned>(count) + 1'500u);
    }
}

BOOST_AUTO_TEST_CASE(the_same_path_gives_the_same_bits) {
  Random random(3);
  const Problem problem = random_problem(random);
  const auto run = [&] {
    return time_parameterize(problem.waypoints, names(problem.waypoints.cols()), problem.limits);
  };
  const Trajectory a = run(), b = run();
  BOOST_TEST((a.positions == b.positions && a.velocities == b.velocities && a.accelerations == b.accelerations &&
              a.times == b.times));
}

BOOST_AUTO_TEST_CASE(default_limits_fill_in_what_a_urdf_leaves_out) {
  const double inf = std::numeric_limits<double>::infinity();
  const MotionLimits limits = default_limits(Eigen::Vector4d(2, 0, inf, std::numeric_limits<double>::max()));
  BOOST_TEST((limits.velocity == Eigen::Vector4d(2, 1, 1, 1)));
  BOOST_TEST((limits.acceleration == Eigen::Vector4d(4, 2, 2, 2)));
  BOOST_TEST((limits.jerk == Eigen::Vector4d(40, 20, 20, 20)));
  check_throws<InvalidArgument>([] { default_limits(Eigen::Vector2d(1, -1)); }, "velocity limit of joint 1 is -1");
  check_throws<InvalidArgument>([] { default_limits(Eigen::Vector2d(NAN, 1)); }, "NaN");
}

BOOST_AUTO_TEST_CASE(bad_input_is_refused_with_the_joint) {
  const MotionLimits good = uniform_limits(2, 1, 2, 20);
  const RowMatrix path = RowMatrix::Identity(2, 2);
  const std::vector<std::string> two{"shoulder", "elbow"};
  const auto run = [&](const RowMatrix& waypoints, const MotionLimits& limits, double period) {
    return [=] { time_parameterize(waypoints, two, limits, {.sample_period = period}); };
  };
  check_throws<InvalidArgument>(run(RowMatrix(0, 2), good, 0.01), "at least one waypoint");
  check_throws<InvalidArgument>(run(RowMatrix::Zero(2, 3), good, 0.01), "3 entries, but there are 2 joint names");
  RowMatrix broken = path;
  broken(1, 1) = NAN;
  check_throws<InvalidArgument>(run(broken, good, 0.01), "waypoint 1: elbow is NaN");

  for (const double bad : {0.0, -1.0, double{NAN}, std::numeric_limits<double>::infinity()}) {
    MotionLimits limits = good;
    limits.velocity[1] = bad;
    check_throws<InvalidArgument>(run(path, limits, 0.01), "elbow: the velocity limit is");
    limits = good;
    limits.acceleration[0] = bad;
    check_throws<InvalidArgument>(run(path, limits, 0.01), "shoulder: the acceleration limit is");
    limits = good;
    limits.jerk[0] = bad;
    check_throws<InvalidArgument>(run(path, limits, 0.01), "shoulder: the jerk limit is");
    check_throws<InvalidArgument>(run(path, good, bad), "sample period is");
  }
  check_throws<InvalidArgument>(run(path, uniform_limits(3, 1, 2, 20), 0.01), "velocity limits: got 3");
  check_throws<InvalidArgument>(run(path, good, 1e-9), "more than 10000000 rows");

  MotionLimits round = good;
  round.continuous = {true, false};
  check_throws<InvalidArgument>(run(4 * path, round, 0.01), "shoulder: the continuous joint moves by");
}

BOOST_AUTO_TEST_CASE(long_timings_can_be_interrupted) {
  Random random(23);
  RowMatrix path(20'000, 3);
  for (Eigen::Index i = 0; i < path.rows(); ++i)
    for (Eigen::Index j = 0; j < 3; ++j) path(i, j) = random.uniform(-1, 1);
  int checks = 0;
  const InterruptionScope scope([&] {
    if (++checks == 3) throw PlanningError(Status::cancelled, "cancelled");
  });
  BOOST_CHECK_EXCEPTION(time_parameterize(path, names(3), uniform_limits(3, 1, 2, 20)), PlanningError,
                        [](const PlanningError& error) { return error.status() == Status::cancelled; });
  BOOST_TEST(checks == 3);
}

BOOST_AUTO_TEST_CASE(timing_stops_at_the_deadline) {
  RowMatrix path(3, 2);
  path << 0, 0, 1, 0, 1, 1;
  const MotionLimits limits = uniform_limits(2, 1, 2, 20);
  const auto status = [&](const Deadline& deadline, double sample_period = 1e-4) {
    try {
      time_parameterize(path, names(2), limits, {.sample_period = sample_period, .deadline = &deadline});
    } catch (const PlanningError& error) {
      return error.status();
    }
    return Status::solved;
  };
  BOOST_CHECK(status(Deadline(0.0)) == Status::timed_out);
  BOOST_CHECK(status(Deadline(1e9, [] { return true; })) == Status::cancelled);
  BOOST_CHECK(status(Deadline(1e9)) == Status::solved);
  BOOST_CHECK(status(Deadline(0.0), 0.01) == Status::solved);  // what is done at once is not lost
}

BOOST_AUTO_TEST_CASE(corners_are_rounded_within_the_deviation_and_save_time) {
  RowMatrix path(3, 2);
  path << 0, 0, 1, 0, 1, 1;
  const MotionLimits limits = uniform_limits(2, 1, 2, 20);
  double duration = 0.0;
  for (const double deviation : {0.1, 0.02, 0.005, 0.0}) {
    const Trajectory t = time_parameterize(path, names(2), limits, {.blend_deviation = deviation});
    double off = 0.0;
    for (double time = 0.0; time < t.duration(); time += 1e-3)
      off = std::max(off, distance_to_path(t.sample(time).transpose(), path));
    BOOST_TEST(off <= deviation + 1e-9);
    BOOST_TEST(t.duration() > duration);
    duration = t.duration();
  }
  BOOST_TEST(duration == 3.0, boost::test_tools::tolerance(1e-3));  // twice 1/1 + 1/2 s, with a stop between
}

BOOST_AUTO_TEST_CASE(a_joint_that_reaches_far_has_tighter_corners) {
  RowMatrix path(3, 2);
  path << 0, 0, 1, 0, 1, 1;
  const MotionLimits limits = uniform_limits(2, 1, 2, 20);
  const auto duration = [&](double reach) {
    return time_parameterize(path, names(2), limits, {.reach = Eigen::Vector2d(reach, reach)}).duration();
  };
  BOOST_TEST(duration(0.1) < duration(1.0));
  BOOST_TEST(duration(1.0) < duration(10.0));
}

BOOST_AUTO_TEST_CASE(corners_shrink_until_they_are_free) {
  RowMatrix path(3, 2);
  path << 0, 0, 1, 0, 1, 1;
  const MotionLimits limits = uniform_limits(2, 1, 2, 20);
  TimingOptions options{.blend_deviation = 0.1};
  const auto nearest_to = [&](const Eigen::Vector2d& place) {
    const Trajectory t = time_parameterize(path, names(2), limits, options);
    double nearest = 10.0;
    for (double time = 0.0; time < t.duration(); time += 1e-3)
      nearest = std::min(nearest, (t.sample(time) - place).norm());
    return nearest;
  };
  const Eigen::Vector2d obstacle(0.95, 0.05);
  BOOST_TEST(nearest_to(obstacle) < 0.02);
  options.is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a - obstacle).norm() > 0.02 && (b - obstacle).norm() > 0.02;
  };
  BOOST_TEST(nearest_to(obstacle) > 0.02);
  options.is_free = [](const auto&, const auto&) { return false; };  // a stop in the corner
  BOOST_TEST(nearest_to(Eigen::Vector2d(1, 0)) < 1e-3);
}

BOOST_AUTO_TEST_CASE(velocities_at_the_ends_are_kept) {
  RowMatrix path(3, 2);
  path << 0, 0, 1, 0, 1, 1;
  const MotionLimits limits = uniform_limits(2, 1, 2, 20);
  for (const TimingMethod method : both_methods) {
    TimingOptions options{
        .method = method, .start_velocity = Eigen::Vector2d(0.5, 0), .end_velocity = Eigen::Vector2d(0, 0.25)};
    const Trajectory t = time_parameterize(path, names(2), limits, options);
    BOOST_TEST((t.velocities.row(0).transpose() - options.start_velocity).norm() < 1e-9);
    BOOST_TEST((t.velocities.bottomRows(1).transpose() - options.end_velocity).norm() < 1e-9);
    const Uses uses = uses_of(t, limits);
    BOOST_TEST(uses.velocity <= 1.0 + 1e-6);
    BOOST_TEST(uses.acceleration <= 1.0 + 1e-6);
    const auto run = [&] { time_parameterize(path, names(2), limits, options); };
    options.start_velocity = Eigen::Vector2d(0.5, 0.1);
    check_throws<InvalidArgument>(run, "start velocity does not point along the path's first segment");
    options.start_velocity = Eigen::Vector2d(-0.5, 0);
    check_throws<InvalidArgument>(run, "start velocity does not point along");
    options.start_velocity = Eigen::Vector2d(1.5, 0);
    check_throws<InvalidArgument>(run, "j0: the start velocity 1.5 is above the limit 1");
    options.start_velocity = Eigen::Vector3d::Zero();
    check_throws<InvalidArgument>(run, "start velocity has 3 entries, but there are 2 joints");
  }
  path << 0, 0, 0.01, 0, 0.01, 0.01;
  check_throws<InvalidArgument>(
      [&] {
        time_parameterize(path, names(2), limits, {.blend_deviation = 0.0, .start_velocity = Eigen::Vector2d(0.9, 0)});
      },
      "the limits do not allow to start at the given velocity");
  check_throws<InvalidArgument>(
      [&] { time_parameterize(RowMatrix::Zero(2, 2), names(2), limits, {.end_velocity = Eigen::Vector2d(0.1, 0)}); },
      "the path is a single point");
}

BOOST_AUTO_TEST_CASE(options_out_of_range_are_refused) {
  const RowMatrix path = RowMatrix::Identity(2, 2);
  const auto run = [&](const TimingOptions& options) {
    return [=] { time_parameterize(path, names(2), uniform_limits(2, 1, 2, 20), options); };
  };
  check_throws<InvalidArgument>(run({.blend_deviation = -1}), "blend deviation is -1");
  check_throws<InvalidArgument>(run({.blend_deviation = NAN}), "blend deviation is NaN");
  check_throws<InvalidArgument>(run({.reach = Eigen::Vector3d::Ones()}), "reach has 3 entries, but there are 2 joints");
  check_throws<InvalidArgument>(run({.reach = Eigen::Vector2d(1, -1)}), "reach must be 0 m or above");
}
