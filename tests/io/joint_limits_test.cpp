#include "srmp/io/joint_limits.hpp"

#include <boost/test/unit_test.hpp>

#include "io/temp_file.hpp"
#include "srmp/core/error.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using srmp::io::JointLimitsFile;

namespace {

// a: continuous, b: revolute from -3 to 3; both 2 rad/s
JointLimitsFile read(const std::string& text) {
  return srmp::io::read_joint_limits(TempFile(text).path(), *robots::planar("continuous"));
}

const std::string good = R"(# as MoveIt's setup assistant writes it
default_velocity_scaling_factor: 0.5
default_acceleration_scaling_factor: 0.1
joint_limits:
  finger:
    has_velocity_limits: true
    max_velocity: 0
    has_acceleration_limits: false
    max_acceleration: 0
  b:
    has_position_limits: true
    min_position: -3
    max_position: 3.1
    has_velocity_limits: true
    max_velocity: 1.5
    has_acceleration_limits: true
    max_acceleration: 7
    has_jerk_limits: true
    max_jerk: 90
    angle_wraparound: false
  wheel: {}
)";

void check_refused(const std::string& from, const std::string& to, const std::string& fragment) {
  check_throws<srmp::FileError>([&] { read(replaced(good, from, to)); }, fragment);
}

void check_unsupported(const std::string& from, const std::string& to, const std::string& fragment) {
  check_throws<srmp::NotSupported>([&] { read(replaced(good, from, to)); }, fragment);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(joint_limits)

BOOST_AUTO_TEST_CASE(limits_are_read_and_scaled) {
  const JointLimitsFile file = read(good);
  BOOST_TEST((file.limits.velocity == Eigen::Vector2d(0.5 * 2, 0.5 * 1.5)));
  BOOST_TEST((file.limits.acceleration == Eigen::Vector2d(0.1 * 4, 0.1 * 7)));
  BOOST_TEST((file.limits.jerk == Eigen::Vector2d(0.1 * 40, 0.1 * 90)));
  BOOST_TEST((file.limits.continuous == std::vector<bool>{true, false}));
  BOOST_TEST((file.unused == std::vector<std::string>{"finger", "wheel"}));
}

BOOST_AUTO_TEST_CASE(limits_that_are_not_given_are_the_defaults) {
  for (const char* text :
       {"joint_limits:\n", "joint_limits: {b: {}}", "default_velocity_scaling_factor: 1",
        "joint_limits: {b: {has_velocity_limits: false, max_velocity: 9, has_jerk_limits: false}}"}) {
    const JointLimitsFile file = read(text);
    BOOST_TEST((file.limits.velocity == Eigen::Vector2d(2, 2)));
    BOOST_TEST((file.limits.acceleration == Eigen::Vector2d(4, 4)));
    BOOST_TEST((file.limits.jerk == Eigen::Vector2d(40, 40)));
    BOOST_TEST(file.unused.empty());
  }
  BOOST_TEST(read("joint_limits: {b: {max_velocity: 9}}").limits.velocity[1] == 9.0);  // has_… may be left out
}

BOOST_AUTO_TEST_CASE(position_limits_are_those_of_the_urdf) {
  read(replaced(good, "max_position: 3.1", "max_position: 2.999995"));
  check_unsupported("max_position: 3.1", "max_position: 2.9",
                    ":13: b: max_position is 2.9, but the URDF's limit is 3; narrower position limits belong in");
  check_unsupported("min_position: -3", "min_position: -2", "b: min_position is -2, but the URDF's limit is -3");
  check_unsupported("  wheel: {}", "  a: {min_position: -3.2}",
                    "a: min_position is -3.2, but the URDF's limit is -inf");
  read(replaced(good, "has_position_limits: true\n    min_position: -3",
                "has_position_limits: false\n    min_position: 9"));
}

BOOST_AUTO_TEST_CASE(unsupported_limits_are_refused) {
  for (const std::string key : {"has_deceleration_limits", "has_effort_limits", "has_soft_limits"}) {
    check_unsupported("angle_wraparound: false", key + ": true", "b: " + key + " is true, but only limits of velocity");
    read(replaced(good, "angle_wraparound: false", key + ": false"));
  }
  check_unsupported("angle_wraparound: false", "angle_wraparound: true", "the URDF's joint is not continuous");
  check_unsupported("  wheel: {}", "  a: {angle_wraparound: false}", "the URDF's joint is continuous");
  check_unsupported("max_velocity: 1.5", "max_velocity: !degrees 90", "b: max_velocity has the tag !degrees");
}

BOOST_AUTO_TEST_CASE(wrong_files_are_refused) {
  check_throws<srmp::FileError>([&] { srmp::io::read_joint_limits("/nowhere.yaml", *robots::planar()); },
                                "no such file");
  check_throws<srmp::FileError>([&] { read(""); }, "the file is empty");
  check_throws<srmp::FileError>([&] { read("[1]"); }, "a joint limits file must be a map");
  check_throws<srmp::FileError>([&] { read("joint_limits: [1]"); }, "joint_limits must be a map of joint names");
  check_refused("joint_limits:", "joint_limit:", "unknown key 'joint_limit' in a joint limits file, did you mean");
  check_refused("max_jerk", "max_jrek", "unknown key 'max_jrek' in the limits of 'b', did you mean 'max_jerk'?");
  check_refused("  wheel: {}", "  wheel: {max_speed: 1}", "in the limits of 'wheel'");
  check_refused("  wheel: {}", "  b: {}", "joint 'b' appears twice");
  check_refused("max_velocity: 1.5", "max_velocity: 0", ":15: b: max_velocity is 0; it must be above 0");
  check_refused("max_acceleration: 7", "max_acceleration: -7", "b: max_acceleration is -7; it must be above 0");
  check_refused("max_jerk: 90", "max_jerk: .inf", "b: max_jerk is .inf; only finite numbers");
  check_refused("max_jerk: 90", "max_jerk: much", "b: max_jerk must be a number, not 'much'");
  check_refused("    max_jerk: 90\n", "", "b: has_jerk_limits is true, but there is no max_jerk");
  check_refused("has_jerk_limits: true", "has_jerk_limits: maybe", "b: has_jerk_limits must be true or false");
  check_refused("factor: 0.5", "factor: 0", "default_velocity_scaling_factor is 0; it must be above 0 and at most 1");
  check_refused("factor: 0.1", "factor: 1.1", "default_acceleration_scaling_factor is 1.1; it must be above 0");
}

BOOST_AUTO_TEST_SUITE_END()
