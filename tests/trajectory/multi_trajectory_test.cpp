#include "srmp/trajectory/multi_trajectory.hpp"

#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "support/rows.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

/// Joint a, from 0 to 1 and to rest by t = 1: 3 t^2 - 2 t^3.
Trajectory quick() {
  return {{"a"},
          rows({{0}, {0.5}, {1}}),
          rows({{0}, {1.5}, {0}}),
          rows({{6}, {0}, {-6}}),
          Eigen::Vector3d(0, 0.5, 1),
          rows({{0}, {1}})};
}

/// Joints a and b, for 2 s.
Trajectory slow() {
  return {{"a", "b"},
          rows({{0, 1}, {4, -1}}),
          rows({{0, 0}, {0, 0}}),
          rows({{6, -3}, {-6, 3}}),
          Eigen::Vector2d(0, 2),
          rows({{0, 1}, {4, -1}})};
}

Trajectory untimed() { return {{"a"}, rows({{0}, {1}, {3}}), {}, {}, {}, rows({{0}, {1}, {3}})}; }

}  // namespace

BOOST_AUTO_TEST_CASE(robots_are_found_by_name) {
  const MultiTrajectory both{{{"left", quick()}, {"right", slow()}}};
  BOOST_TEST(both.duration() == 2.0);
  BOOST_TEST(both.at("left").dof() == 1u);
  check_throws<InvalidArgument>([&] { both.at("lft"); }, "there is no trajectory of robot 'lft', did you mean 'left'?");
  BOOST_TEST(MultiTrajectory{}.duration() == 0.0);
}

BOOST_AUTO_TEST_CASE(merged_is_every_robots_motion_and_no_motion_after_its_end) {
  const Trajectory merged = MultiTrajectory{{{"right", slow()}, {"left", quick()}}}.merged();
  const std::vector<std::string> names{"left/a", "right/a", "right/b"};
  BOOST_TEST(merged.joint_names == names);
  BOOST_CHECK(merged.times == Eigen::Vector4d(0, 0.5, 1, 2));
  BOOST_TEST(!merged.certificate);
  for (double t = 0.0; t <= 2.0; t += 0.01) {
    const MotionState all = merged.state(t), left = quick().state(std::min(t, 1.0)), right = slow().state(t);
    BOOST_CHECK_SMALL(std::abs(all.position[0] - left.position[0]), 1e-12);
    BOOST_CHECK_SMALL((all.position.tail(2) - right.position).norm(), 1e-12);
    if (t > 1.0) BOOST_CHECK_SMALL(all.velocity[0], 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(without_times_rows_go_together_and_who_has_fewer_stays) {
  Trajectory short_one = untimed();
  short_one.positions = rows({{7}});
  const Trajectory merged = MultiTrajectory{{{"left", untimed()}, {"right", short_one}}}.merged();
  BOOST_TEST(!merged.timed());
  BOOST_CHECK(merged.positions == rows({{0, 7}, {1, 7}, {3, 7}}));
}

BOOST_AUTO_TEST_CASE(what_cannot_be_merged_is_refused) {
  check_throws<InvalidArgument>([] { MultiTrajectory{}.merged(); }, "there is no robot to merge the trajectories of");
  check_throws<InvalidArgument>([] { MultiTrajectory{{{"a", quick()}, {"b", untimed()}}}.merged(); },
                                "some of the trajectories have times and others have not");
}
