#include "srmp/trajectory/parameterize.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "srmp/core/error.hpp"
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

Problem random_problem(Random& random) {
  const Eigen::Index dof = random.integer(1, 8), count = random.integer(2, 7);
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
    const double size = kind < 0.3 ? 1e-9 : kind < 0.5 ? random.scale(1e-6, 1e-2) : random.uniform(0.05, 1.5);
    for (Eigen::Index j = 0; j < dof; ++j)
      if (random.uniform(0, 1) < 0.7) problem.waypoints(i, j) += size * random.uniform(-1, 1);
  }
  return problem;
}

double distance_to_path(const Eigen::RowVectorXd& q, const RowMatrix& path) {
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Eigen::RowVectorXd way = path.row(i + 1) - path.row(i), offset = q - path.row(i);
    const double along = way.squaredNorm() > 0 ? std::clamp(offset.dot(way) / way.squaredNorm(), 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (offset - along * way).norm());
  }
  return nearest;
}

/// Largest |value| / limit over all rows and joints.
double use_of(const RowMatrix& values, const Eigen::VectorXd& limit) {
  return (values.cwiseAbs().array().rowwise() / limit.transpose().array()).maxCoeff();
}

/// Largest |difference quotient| / limit, over steps long enough for rounding not to matter.
double slope_of(const RowMatrix& values, const Eigen::VectorXd& times, const Eigen::VectorXd& limit) {
  double largest = 0.0;
  for (Eigen::Index i = 1; i < times.size(); ++i) {
    const double step = times[i] - times[i - 1];
    if (step < 1e-4) continue;
    const Eigen::VectorXd slope = (values.row(i) - values.row(i - 1)).transpose() / step;
    largest = std::max(largest, (slope.cwiseAbs().array() / limit.array()).maxCoeff());
  }
  return largest;
}

/// Largest disagreement of positions and reported velocities (trapezoid), in units of what jerk can explain.
double inconsistency(const Trajectory& t, const Eigen::VectorXd& jerk) {
  double largest = 0.0;
  for (Eigen::Index i = 1; i < t.times.size(); ++i) {
    const double h = t.times[i] - t.times[i - 1];
    const Eigen::VectorXd moved = (t.positions.row(i) - t.positions.row(i - 1)).transpose();
    const Eigen::VectorXd integral = 0.5 * h * (t.velocities.row(i) + t.velocities.row(i - 1)).transpose();
    const Eigen::ArrayXd allowed = jerk.array() * h * h * h / 4 + 1e-12;
    largest = std::max(largest, ((moved - integral).cwiseAbs().array() / allowed).maxCoeff());
  }
  return largest;
}

void check_trajectory(const Trajectory& t, const Problem& problem) {
  const Eigen::Index n = t.positions.rows(), last = n - 1, end = problem.waypoints.rows() - 1;
  BOOST_REQUIRE(t.times.size() == n);
  BOOST_TEST((t.positions.allFinite() && t.velocities.allFinite() && t.accelerations.allFinite()));
  BOOST_TEST(((t.times.tail(last) - t.times.head(last)).array() > 0.0).all());
  BOOST_TEST((t.positions.row(0) == problem.waypoints.row(0)));
  BOOST_TEST((t.positions.row(last) == problem.waypoints.row(end)));
  for (const Eigen::Index i : {Eigen::Index{0}, last})
    BOOST_TEST((t.velocities.row(i).isZero(0.0) && t.accelerations.row(i).isZero(0.0)));

  BOOST_TEST(use_of(t.velocities, problem.limits.velocity) <= 1.0);
  BOOST_TEST(use_of(t.accelerations, problem.limits.acceleration) <= 1.0);
  BOOST_TEST(slope_of(t.positions, t.times, problem.limits.velocity) <= 1.0 + 1e-9);
  BOOST_TEST(slope_of(t.velocities, t.times, problem.limits.acceleration) <= 1.0 + 1e-9);
  BOOST_TEST(slope_of(t.accelerations, t.times, problem.limits.jerk) <= 1.0 + 1e-6);
  BOOST_TEST(inconsistency(t, problem.limits.jerk) <= 1.0);

  double off_path = 0.0;
  for (Eigen::Index i = 0; i < n; ++i)
    off_path = std::max(off_path, distance_to_path(t.positions.row(i), problem.waypoints));
  BOOST_TEST(off_path < 1e-9);
  BOOST_TEST((t.waypoints == problem.waypoints));
}

}  // namespace

BOOST_AUTO_TEST_CASE(random_paths_obey_every_limit_and_never_leave_the_path) {
  Random random(20);
  for (int i = 0; i < 400; ++i) {
    BOOST_TEST_CONTEXT("path " << i) {
      const Problem problem = random_problem(random);
      check_trajectory(time_parameterize(problem.waypoints, names(problem.waypoints.cols()), problem.limits, 1e-3),
                       problem);
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
      const double way = path(1) - path(0);
      const double least = std::max({way / limits.velocity[0], std::sqrt(4 * way / limits.acceleration[0]),
                                     std::cbrt(32 * way / limits.jerk[0])});
      const Trajectory t = time_parameterize(path, {"j"}, limits, std::max(1e-3, least / 100));
      BOOST_TEST(use_of(t.velocities, limits.velocity) <= 1.0);
      BOOST_TEST(use_of(t.accelerations, limits.acceleration) <= 1.0);
      BOOST_TEST(t.duration() >= least * (1 - 1e-6));  // no limit alone allows less …
      BOOST_TEST(t.duration() <= 3 * least + 2e-6);    // … and all together not much more
    }
  }
}

BOOST_AUTO_TEST_CASE(the_duration_is_the_least_that_the_limits_allow) {
  RowMatrix path(2, 2);
  path << 0, 0, 2, 1;
  // Joint 0 decides: v = 1, a = 2, j = 20: ramps of v/a + a/j = 0.6 s, so 2/1 + 0.6 s in all.
  const Trajectory t = time_parameterize(path, {"a", "b"}, default_limits(Eigen::Vector2d(1, 1)), 0.01);
  BOOST_TEST(t.duration() == 2.6, boost::test_tools::tolerance(1e-7));
  BOOST_TEST(use_of(t.velocities, Eigen::Vector2d(1, 1)) > 1 - 1e-6);
}

BOOST_AUTO_TEST_CASE(samples_are_at_every_period_and_at_every_corner) {
  RowMatrix path(3, 1);
  path << 0, 0.3, 0.1;
  const Trajectory t = time_parameterize(path, {"j"}, uniform_limits(1, 1, 2, 20), 0.05);
  bool corner = false;
  int multiples = 0;
  for (Eigen::Index i = 0; i < t.times.size(); ++i) {
    corner = corner || t.positions(i, 0) == 0.3;
    const double ticks = t.times[i] / 0.05;
    multiples += std::abs(ticks - std::round(ticks)) < 1e-9;
  }
  BOOST_TEST(corner);
  BOOST_TEST(multiples == 1 + static_cast<int>(t.duration() / 0.05));
  BOOST_TEST(t.times.size() <= multiples + 2);
}

BOOST_AUTO_TEST_CASE(a_long_period_still_gives_all_corners) {
  RowMatrix path(4, 2);
  path << 0, 0, 1, 0, 1, 1, 0, 1;
  const Trajectory t = time_parameterize(path, {"a", "b"}, uniform_limits(2, 1, 2, 20), 1e6);
  BOOST_TEST((t.positions == path));
}

BOOST_AUTO_TEST_CASE(a_path_of_one_place_takes_no_time) {
  for (const Eigen::Index count : {1, 2, 5}) {
    const Trajectory t =
        time_parameterize(RowMatrix::Constant(count, 3, 0.25), names(3), uniform_limits(3, 1, 2, 20), 0.01);
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
  check_trajectory(time_parameterize(path, {"j"}, problem.limits, 1e-3), problem);
}

BOOST_AUTO_TEST_CASE(the_same_path_gives_the_same_bits) {
  Random random(3);
  const Problem problem = random_problem(random);
  const auto run = [&] {
    return time_parameterize(problem.waypoints, names(problem.waypoints.cols()), problem.limits, 0.01);
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
    return [=] { time_parameterize(waypoints, two, limits, period); };
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
  check_throws<InvalidArgument>(run(path, good, 1e-9), "more than ten million samples");

  MotionLimits round = good;
  round.continuous = {true, false};
  check_throws<InvalidArgument>(run(4 * path, round, 0.01), "shoulder: the continuous joint moves by");
}
