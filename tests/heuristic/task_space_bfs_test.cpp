#include "srmp/heuristic/task_space_bfs.hpp"

#include <boost/test/unit_test.hpp>

using srmp::Deadline;
using srmp::TaskSpaceBfs;

namespace {

/// A wall across a box of 2 m, with a gap at y > 0.5.
srmp::Scene wall() {
  srmp::Scene scene;
  scene.add_object("wall", srmp::Box{{0.1, 1.5, 2.0}}, {.p = {0.0, -0.25, 0.0}});
  return scene;
}

const Eigen::Vector3d one = Eigen::Vector3d::Ones();
const std::vector<Eigen::Vector3d> goals{{0.5, 0.0, 0.0}};

TaskSpaceBfs grid(double resolution, const Deadline& deadline = {}) {
  return TaskSpaceBfs(wall(), -one, one, goals, {resolution, 0.05}, deadline);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(task_space_bfs)

BOOST_AUTO_TEST_CASE(distance_goes_round_the_wall) {
  const TaskSpaceBfs bfs = grid(0.05);
  BOOST_TEST(bfs.distance(goals[0]) == 0.0);
  BOOST_TEST(bfs.distance({0.9, 0.0, 0.0}) < 0.5);
  BOOST_TEST(bfs.distance({-0.5, 0.0, 0.0}) > 1.4);  // over y = 0.55, not straight through
  BOOST_TEST(bfs.distance({-0.5, 0.0, 0.0}) < 2.0);
}

BOOST_AUTO_TEST_CASE(memory_grows_with_the_cells) {
  BOOST_TEST(grid(0.05).memory() >= 5u * 40 * 40 * 40);
  BOOST_TEST(grid(0.1).memory() < grid(0.05).memory());
}

BOOST_AUTO_TEST_CASE(a_passed_deadline_leaves_it_undone_but_whole) {
  const TaskSpaceBfs late = grid(0.01, Deadline(0.0));
  BOOST_TEST(late.distance(goals[0]) == 0.0);
  BOOST_TEST(late.distance({-0.5, 0.0, 0.0}) == 0.0);
  // Wherever time runs out, it can be asked.
  for (int polls = 1; polls < 6; ++polls) {
    int left = polls;
    const Deadline deadline(100.0, [&] { return --left <= 0; });
    BOOST_TEST(grid(0.01, deadline).distance({-0.5, 0.0, 0.0}) >= 0.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
