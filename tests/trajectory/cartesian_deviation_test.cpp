#include "srmp/trajectory/cartesian_deviation.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <random>

#include "support/amount.hpp"
#include "support/data.hpp"
#include "support/numbers.hpp"

using namespace srmp;

namespace {

Pose moved(const Pose& pose, const Eigen::Vector3d& by, double turn) {
  return {pose.p + by, pose.q * Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()))};
}

/// A motion of the arm between two configurations, with velocities at both ends.
Trajectory random_motion(const RobotModel& robot, std::size_t seed) {
  Trajectory motion;
  motion.joint_names = robot.joint_names();
  motion.times = Eigen::Vector2d(0.0, 0.1 + 0.05 * static_cast<double>(seed % 7));
  motion.positions.resize(2, static_cast<Eigen::Index>(robot.dof()));
  motion.positions.row(0) = 0.5 * sample_configuration(robot, seed).transpose();
  motion.positions.row(1) = motion.positions.row(0) + 0.05 * sample_configuration(robot, seed + 1000).transpose();
  motion.velocities.resize(2, motion.positions.cols());
  motion.velocities.row(0) = 0.3 * sample_configuration(robot, seed + 2000).transpose();
  motion.velocities.row(1) = 0.3 * sample_configuration(robot, seed + 3000).transpose();
  return motion;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(cartesian_deviation)

BOOST_AUTO_TEST_CASE(all_poses_are_near_the_thinned_path) {
  const CartesianTolerance closer{0.01, 0.02};
  std::mt19937 random(1);
  const auto number = [&](double most) { return most * (static_cast<double>(random()) / 4294967296.0); };
  for (std::size_t count = 2; count < 200; ++count) {
    std::vector<Pose> poses{Pose::from_rpy({0.3, 0.0, 0.5}, {0.1, 0.2, 0.3})};
    while (poses.size() < count)
      poses.push_back(moved(poses.back(), {number(0.02), number(0.02) - 0.01, 0.0}, number(0.04)));
    const CartesianPath whole(poses), thinned = whole.thinned(closer);
    BOOST_TEST((thinned.pose(0, 0.0).p == poses.front().p));
    BOOST_TEST((thinned.end().p == poses.back().p));
    for (const Pose& pose : poses) {
      const CartesianPath::Miss miss = thinned.miss(pose, 0, 1e9, closer);
      BOOST_TEST(std::max(miss.position / closer.position, miss.rotation / closer.rotation) <= 1.0);
    }
    double angle = 0.0;
    for (std::size_t i = 0; i < whole.segments(); ++i) angle += whole.angle(i);
    const double parts = whole.length() / closer.position + angle / closer.rotation;
    BOOST_TEST(static_cast<double>(thinned.segments()) <= 1.0 + parts);
  }
}

BOOST_AUTO_TEST_CASE(a_pose_on_the_path_misses_nothing) {
  const Pose a = Pose::from_rpy({0.3, 0.0, 0.5}, {0.1, 0.2, 0.3});
  const CartesianPath path({a, moved(a, {0.1, 0.0, 0.0}, 0.2), moved(a, {0.1, 0.0, 0.0}, 1.0)});
  BOOST_TEST(path.length() == 0.1, boost::test_tools::tolerance(1e-12));
  for (std::size_t segment = 0; segment < path.segments(); ++segment)
    for (const double fraction : {0.0, 0.3, 1.0}) {
      const auto miss = path.miss(path.pose(segment, fraction), segment, CartesianTolerance{});
      BOOST_TEST(miss.position < 1e-12);
      BOOST_TEST(miss.rotation < 1e-7);
    }
  const auto beside = path.miss(moved(path.pose(0, 0.5), {0.0, 0.02, 0.0}, 0.0), 0, CartesianTolerance{});
  BOOST_TEST(beside.position == 0.02, boost::test_tools::tolerance(1e-9));
  const auto turned = path.miss(moved(path.pose(1, 0.5), {}, 0.0), 0, 1e9, CartesianTolerance{});
  BOOST_TEST(turned.segment == 1u);
}

BOOST_AUTO_TEST_CASE(what_is_proved_holds_at_all_samples_and_is_little_more) {
  const auto robot = RobotModel::load(arm7());
  const CartesianTolerance tolerance;
  for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(300)); ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
      const Trajectory motion = random_motion(*robot, seed);
      const PlacedRobot placed{robot, Pose::from_rpy({0.2, -0.1, 0.4}, {0.0, 0.3, 1.0}), {}};
      const Pose from = placed.base * robot->compute_fk(motion.positions.row(0).transpose());
      const Pose to = placed.base * robot->compute_fk(motion.positions.row(1).transpose());
      const CartesianPath path({from, to});
      const CartesianDeviation proved = prove_cartesian_deviation(motion, placed, "", path, tolerance, Deadline());
      CartesianPath::Miss worst;
      for (int i = 0; i <= 1000; ++i) {
        const Eigen::VectorXd q = motion.sample(motion.duration() * i / 1000.0);
        const auto miss = path.miss(placed.base * robot->compute_fk(q), 0, tolerance);
        worst.position = std::max(worst.position, miss.position);
        worst.rotation = std::max(worst.rotation, miss.rotation);
      }
      BOOST_TEST(worst.position <= proved.position + 1e-9);
      BOOST_TEST(worst.rotation <= proved.rotation + 1e-7);
      BOOST_TEST(proved.position <= worst.position + 0.11 * tolerance.position);
      BOOST_TEST(proved.rotation <= 1.011 * worst.rotation + 0.11 * tolerance.rotation);
    }
}

BOOST_AUTO_TEST_CASE(motions_keep_a_tolerance_where_their_deviation_does) {
  const auto robot = RobotModel::load(arm7());
  const Deadline deadline;
  int kept = 0, left = 0;
  for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(300)); ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
      const Trajectory motion = random_motion(*robot, seed);
      const Eigen::VectorXd a = motion.positions.row(0).transpose(), b = motion.positions.row(1).transpose();
      const CartesianPath path({robot->compute_fk(a), robot->compute_fk(b)});
      const CartesianTolerance unit;
      double worst = 1e-6;  // in units
      for (int i = 0; i <= 1000; ++i) {
        const auto miss = path.miss(robot->compute_fk(a + i / 1000.0 * (b - a)), 0, unit);
        worst = std::max({worst, miss.position / unit.position, miss.rotation / unit.rotation});
      }
      for (const double fraction : {0.5, 0.9, 1.15, 2.0}) {
        const CartesianTolerance tolerance{fraction * worst * unit.position, fraction * worst * unit.rotation};
        const std::size_t link = robot->link_index(robot->end_effector());
        CartesianDeviationProof proof(*robot, {}, link, path, tolerance, deadline);
        const bool keeps = proof.keeps(a, b, 0);
        if (fraction < 1.0) BOOST_TEST(!keeps);
        if (fraction > 1.12) BOOST_TEST(keeps);
        ++(keeps ? kept : left);
      }
    }
  BOOST_TEST(kept > amount(100));
  BOOST_TEST(left > amount(100));
}

BOOST_AUTO_TEST_CASE(a_motion_that_ends_before_the_path_does_is_away_from_its_end) {
  const auto robot = RobotModel::load(arm7());
  const Trajectory motion = random_motion(*robot, 5);
  const PlacedRobot placed{robot, {}, {}};
  const Pose from = robot->compute_fk(motion.positions.row(0).transpose());
  const Pose to = robot->compute_fk(motion.positions.row(1).transpose());
  const CartesianPath farther({from, to, {to.p + Eigen::Vector3d(0.1, 0.0, 0.0), to.q}});
  BOOST_TEST(prove_cartesian_deviation(motion, placed, "", farther, {}, Deadline()).position >= 0.1 - 1e-9);
}

BOOST_AUTO_TEST_SUITE_END()
