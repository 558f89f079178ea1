#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/parameterize.hpp"
#include "support/amount.hpp"
#include "support/data.hpp"
#include "support/numbers.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

/// A motion of three rows, with velocities at all of them.
Trajectory random_motion(const RobotModel& robot, std::size_t seed) {
  Trajectory motion;
  motion.joint_names = robot.joint_names();
  const double part = 0.05 + 0.05 * static_cast<double>(seed % 7);
  motion.times = Eigen::Vector3d(0.0, part, 3.0 * part);
  motion.positions.resize(3, static_cast<Eigen::Index>(robot.dof()));
  motion.velocities = motion.positions;
  for (Eigen::Index row = 0; row < 3; ++row) {
    const auto number = static_cast<std::size_t>(row);
    motion.positions.row(row) = 0.3 * sample_configuration(robot, seed + number * 1000).transpose();
    motion.velocities.row(row) = 0.5 * sample_configuration(robot, seed + 5000 + number * 1000).transpose();
  }
  return motion;
}

/// By differences of poses, at t of the motion.
std::pair<double, double> speeds_at(const Trajectory& motion, const RobotModel& robot, const LinkSpeedLimit& limit,
                                    double t) {
  constexpr double h = 1e-6;
  const Pose a = robot.compute_fk(motion.sample(t - h), limit.link),
             b = robot.compute_fk(motion.sample(t + h), limit.link);
  const Eigen::Quaterniond turn = a.q.conjugate() * b.q;
  return {(b * limit.point - a * limit.point).norm() / (2.0 * h),
          2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w())) / (2.0 * h)};
}

/// Revolute and prismatic joints in turn, one of which mimics another.
std::shared_ptr<const RobotModel> mixed_robot() {
  const std::string limit = "<limit lower='-1' upper='1' velocity='2' effort='1'/>";
  RobotDescription description;
  description.urdf_text =
      "<robot name='mixed'><link name='base'/>" + robots::bar("one") + robots::bar("two") + robots::bar("three") +
      "<link name='tip'/>" + robots::joint("a", "revolute", "base", "one", "0 0 0.2", "0 0 1", limit) +
      robots::joint("b", "prismatic", "one", "two", "0.5 0 0", "1 0 0", limit) +
      robots::joint("c", "revolute", "two", "three", "0.3 0 0", "0 1 0", limit) +
      robots::joint("d", "revolute", "three", "tip", "0.4 0 0", "1 0 0", limit + "<mimic joint='a' multiplier='-2'/>") +
      "</robot>";
  description.end_effector = "tip";
  return RobotModel::load(description);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(link_speeds)

BOOST_AUTO_TEST_CASE(what_is_proved_holds_at_all_samples_and_is_hardly_more) {
  for (const auto& robot : {RobotModel::load(arm7()), mixed_robot()})
    for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(60)); ++seed)
      BOOST_TEST_CONTEXT(robot->name() << ", seed " << seed) {
        const Trajectory motion = random_motion(*robot, seed);
        const LinkSpeedLimit limit{robot->end_effector(), 1.0, 1.0, {0.1, -0.05, 0.2}};
        LinkSpeeds speeds;
        speeds.add(*robot, robot->default_other_positions(), {limit});
        const LinkSpeedUse proved = speeds.prove(motion).front();
        double speed = 0.0, turning = 0.0;
        for (int i = 1; i < 2000; ++i) {
          const double t = motion.duration() * i / 2000.0;
          const auto [v, w] = speeds_at(motion, *robot, limit, t);
          speed = std::max(speed, v);
          turning = std::max(turning, w);
        }
        BOOST_TEST(speed <= proved.speed * (1.0 + 1e-6));
        BOOST_TEST(turning <= proved.angular_speed * (1.0 + 1e-6));
        BOOST_TEST(proved.speed <= 1.002 * speed);
        BOOST_TEST(proved.angular_speed <= 1.002 * turning);
        BOOST_TEST(std::abs(speeds_at(motion, *robot, limit, proved.speed_time).first - speed) <= 0.01 * speed);
      }
}

BOOST_AUTO_TEST_CASE(bounds_on_second_derivatives_hold) {
  for (const auto& robot : {RobotModel::load(arm7()), mixed_robot()})
    for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(60)); ++seed)
      BOOST_TEST_CONTEXT(robot->name() << ", seed " << seed) {
        const Trajectory motion = random_motion(*robot, seed);
        const LinkSpeedLimit limit{robot->end_effector(), 1.0, 1.0, {0.1, -0.05, 0.2}};
        RobotDataPtr data = robot->make_data();
        const LinkChain chain(*robot, *data, robot->link_index(limit.link), limit.point);
        std::vector<detail::Cubic> cubics;
        for (Eigen::Index j = 0; j < motion.positions.cols(); ++j) cubics.push_back(detail::segment_of(motion, 0, j));
        const double h = 1e-3, end = motion.times[1];
        const LinkChain::Curvature most = chain.curvature(cubics, 0.0, end);
        for (double t = 2.0 * h; t < end - 2.0 * h; t += h) {
          const auto at = [&](double time) -> Eigen::Vector3d {
            return robot->compute_fk(motion.sample(time), limit.link) * limit.point;
          };
          const Eigen::Vector3d third = at(t + 2 * h) - 2.0 * at(t + h) + 2.0 * at(t - h) - at(t - 2 * h);
          BOOST_TEST(third.norm() / (2.0 * h * h * h) <= most.velocity * 1.01 + 1e-3);
        }
      }
}

BOOST_AUTO_TEST_CASE(a_path_in_time_keeps_them_and_without_a_robot_it_is_refused) {
  const auto robot = RobotModel::load(arm7());
  MotionLimits limits = default_limits(*robot);
  limits.link_speeds = {{.speed = 0.2}, {.link = "arm7_forearm", .angular_speed = 0.3}};
  RowMatrix path(3, static_cast<Eigen::Index>(robot->dof()));
  for (Eigen::Index row = 0; row < 3; ++row)
    path.row(row) = 0.5 * sample_configuration(*robot, static_cast<std::size_t>(row) + 7).transpose();
  for (const TimingMethod method : {TimingMethod::toppra, TimingMethod::ruckig}) {
    TimingOptions options{.method = method};
    check_throws<InvalidArgument>([&] { time_parameterize(path, robot->joint_names(), limits, options); },
                                  "need the robot");
    options.robot = std::make_shared<const PlacedRobot>(PlacedRobot{robot});
    const Trajectory motion = time_parameterize(path, robot->joint_names(), limits, options);
    LinkSpeeds speeds;
    speeds.add(*robot, robot->default_other_positions(), limits.link_speeds);
    const double use = speeds.use(motion);
    BOOST_TEST(use <= 1.0);
    BOOST_TEST(use > 0.98);
  }
}

BOOST_AUTO_TEST_CASE(links_that_cannot_be_limited_are_refused) {
  const auto robot = RobotModel::load(arm7());
  MotionLimits limits = default_limits(*robot);
  const auto refused = [&](const LinkSpeedLimit& limit, const std::string& text) {
    limits.link_speeds = {limit};
    check_throws<InvalidArgument>(
        [&] {
          require_limits(limits, robot->joint_names());
          require_bounds_of_robot(limits, *robot);
        },
        text);
  };
  refused({.link = "arm7_hnad", .speed = 1.0}, "did you mean 'arm7_hand'");
  refused({.link = "arm7_base", .speed = 1.0}, "no planned joint moves it");
  refused({}, "neither the speed nor the angular speed of the end effector");
  refused({.link = "arm7_hand", .speed = 0.0}, "the speed limit of link 'arm7_hand' is 0");
  refused({.angular_speed = std::numeric_limits<double>::quiet_NaN()}, "NaN");
  refused({.speed = 1.0, .point = {0.0, std::numeric_limits<double>::infinity(), 0.0}}, "three finite numbers");
}

BOOST_AUTO_TEST_SUITE_END()
