#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "srmp/core/deadline.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/pose.hpp"
#include "support/throws.hpp"

using namespace srmp;

BOOST_AUTO_TEST_CASE(pose_round_trips_through_a_list) {
  const Pose pose = Pose::from_rpy({1, 2, 3}, {0.1, -0.2, 0.3});
  const Pose again = Pose::from_list(pose.to_list());
  BOOST_TEST((again.matrix() - pose.matrix()).norm() < 1e-12);
  BOOST_TEST((Pose::from_matrix(pose.matrix()).matrix() - pose.matrix()).norm() < 1e-12);
  BOOST_TEST(((pose * pose.inverse()).matrix() - Eigen::Matrix4d::Identity()).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(pose_gives_the_roll_pitch_yaw_that_made_it) {
  const double right = std::numbers::pi / 2;
  for (const double roll : {-3.0, -0.4, 0.0, 1.7})
    for (const double pitch : {-right, -1.2, 0.0, 0.3, right})
      for (const double yaw : {-2.9, 0.0, 0.8, 3.1}) {
        const Eigen::Vector3d turns(roll, pitch, yaw);
        const Pose pose = Pose::from_rpy({1, 2, 3}, turns);
        if (std::abs(pitch) < right) BOOST_TEST((pose.rpy() - turns).norm() < 1e-9);
        BOOST_TEST((Pose::from_rpy(pose.p, pose.rpy()).matrix() - pose.matrix()).norm() < 1e-7);
      }
}

BOOST_AUTO_TEST_CASE(pose_accepts_both_quaternion_orders) {
  const double s = std::sqrt(0.5);
  const Pose a = Pose::from_xyzw({0, 0, 0}, {0, 0, s, s}), b = Pose::from_wxyz({0, 0, 0}, {s, 0, 0, s});
  BOOST_TEST((a.matrix() - b.matrix()).norm() == 0.0);
  BOOST_TEST((a * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 1, 0)).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(quaternions_of_any_length_are_normalised) {
  for (const double length : {1e-8, 0.5, 1e99, 1e101, 1e160, std::numeric_limits<double>::max()}) {
    const Pose pose = Pose::from_xyzw({0, 0, 0}, {length, 0, 0, length});
    BOOST_TEST((pose.q.coeffs() - Eigen::Vector4d(1, 0, 0, 1) / std::sqrt(2.0)).norm() < 1e-15);
  }
}

BOOST_AUTO_TEST_CASE(pose_rejects_invalid_input) {
  check_throws<InvalidArgument>([] { Pose::from_xyzw({0, 0, 0}, {0, 0, 0, 0}); }, "quaternion is zero");
  check_throws<InvalidArgument>([] { Pose::from_xyzw({0, 0, 0}, {0, 1e-150, 0, 0}); }, "of length 1e-150;");
  check_throws<InvalidArgument>([] { Pose::from_xyzw({NAN, 0, 0}, {0, 0, 0, 1}); }, "NaN");
  check_throws<InvalidArgument>([] { Pose::from_list(std::array{1.0, 2.0}); }, "7 numbers");
  check_throws<InvalidArgument>([] { Pose::from_matrix(2 * Eigen::Matrix4d::Identity()); }, "not a rigid transform");
}

BOOST_AUTO_TEST_CASE(suggestions_give_the_nearest_name_only) {
  const std::vector<std::string> known{"panda_link7", "panda_hand", "shelf"};
  BOOST_TEST(did_you_mean("panda_hnad", known) == ", did you mean 'panda_hand'?");
  BOOST_TEST(did_you_mean("zzzzzzz", known) == "");
}

BOOST_AUTO_TEST_CASE(deadline_expires_and_cancels) {
  BOOST_TEST(!Deadline().expired());
  BOOST_TEST(Deadline(0.0).expired());
  const Deadline cancelled(1e9, [] { return true; });
  BOOST_TEST(cancelled.cancelled());
  BOOST_TEST(cancelled.stop_requested());
  BOOST_TEST(!cancelled.expired());
}

BOOST_AUTO_TEST_CASE(deadlines_made_of_another_pass_no_earlier_than_they_say) {
  const Deadline passed(0.0), open(1e9);
  BOOST_TEST(passed.within(1e9).expired());
  BOOST_TEST(open.within(0.0).expired());
  BOOST_TEST(!open.within(1e6).expired());
  BOOST_TEST(!Deadline().within(std::numeric_limits<double>::infinity()).expired());
  BOOST_TEST(!passed.extended(1e9).expired());
  BOOST_TEST(Deadline(-1.0).extended(0.5).expired());  // later than the limit, not than now
  BOOST_TEST(open.within(1e6).elapsed() >= 0.0);

  bool stop = false;
  const Deadline asked(1e9, [&] { return stop; });
  const Deadline part = asked.within(1e6), later = asked.extended(1.0),
                 other = asked.interrupted_by([] { return true; });
  BOOST_TEST(other.cancelled());
  stop = true;
  BOOST_TEST(part.cancelled());
  BOOST_TEST(later.cancelled());
}
