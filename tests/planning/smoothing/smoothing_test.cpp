#include <boost/test/unit_test.hpp>

#include "srmp/planning/smoothing/joint_shortcut.hpp"
#include "srmp/planning/smoothing/large_neighbourhood_search.hpp"
#include "support/facing_arms.hpp"

namespace {

using Eigen::Vector2d;
using robots::FacingArms;
using srmp::JointPath;

const std::vector<std::size_t> both{0, 1};

}  // namespace

BOOST_AUTO_TEST_SUITE(smoothing)

BOOST_AUTO_TEST_CASE(a_robot_that_needs_no_detour_is_rerouted) {
  FacingArms pair;
  const Vector2d start(1.2, 0.0), goal(-1.2, 0.0), any(1.2, 2.0);
  // The left one goes first; the right one makes a needless detour to a retreat and waits there.
  JointPath path = srmp::joint_path(*pair.world, both, {{start, start, goal, goal}, {start, any, any, goal}});
  const double before = path.length(1);
  const JointPath better = srmp::reroute_one_robot(path, *pair.world, {});
  pair.check_free(better);
  BOOST_TEST(better.length(0) <= path.length(0) + 1e-9);
  BOOST_TEST(better.length(1) < 0.95 * before);
  BOOST_TEST((better.positions[1].row(0).transpose() == start));
  BOOST_TEST((better.positions[1].bottomRows(1).transpose() - goal).norm() < 1e-12);
  const JointPath unchanged = srmp::reroute_one_robot(path, *pair.world, srmp::Deadline(1e-9));
  BOOST_TEST(unchanged.length() == path.length());
}

BOOST_AUTO_TEST_CASE(a_robot_that_retreats_for_another_comes_back) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), any(1.2, 0.5);
  FacingArms pair({up, {down}, {up, down}},
                  {straight, {straight}, {straight}});  // the right one blocks the left one's path
  const JointPath path = srmp::joint_path(*pair.world, both, {{up, up, down, down}, {straight, any, any, straight}});
  pair.check_free(path);
  const JointPath better = srmp::reroute_one_robot(path, *pair.world, {});
  pair.check_free(better);
  BOOST_TEST((better.positions[1].bottomRows(1).transpose() == straight));
}

BOOST_AUTO_TEST_CASE(a_robot_is_rerouted_through_a_nearer_configuration) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), far(1.6, 1.0), near(1.2, 0.5);
  FacingArms pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});
  const JointPath path = srmp::joint_path(*pair.world, both, {{up, up, down, down}, {straight, far, far, straight}});
  pair.check_free(path);
  const JointPath better = srmp::reroute_one_robot(path, *pair.world, {}, {{}, {near}});
  pair.check_free(better);
  BOOST_TEST(better.length(1) < 0.95 * path.length(1));
  BOOST_TEST(better.length(1) < srmp::reroute_one_robot(path, *pair.world, {}).length(1));
}

BOOST_AUTO_TEST_CASE(tightened_paths_detour_no_more_than_necessary) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), far(1.6, 1.0);
  FacingArms pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});
  const JointPath path = srmp::joint_path(*pair.world, both, {{up, up, down, down}, {straight, far, far, straight}});
  const JointPath tight = srmp::tightened(path, *pair.world, {});
  pair.check_free(tight);
  BOOST_TEST(tight.length(0) <= path.length(0));
  BOOST_TEST(tight.length(1) < 0.95 * path.length(1));
  for (std::size_t robot : both) {
    BOOST_TEST((tight.positions[robot].row(0) == path.positions[robot].row(0)));
    BOOST_TEST((tight.positions[robot].bottomRows(1) == path.positions[robot].bottomRows(1)));
  }
  BOOST_TEST(srmp::tightened(path, *pair.world, srmp::Deadline(1e-9)).length() == path.length());
}

BOOST_AUTO_TEST_SUITE_END()
