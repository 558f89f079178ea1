#include "srmp/heuristic/task_space_bfs.hpp"

#include <coal/collision.h>
#include <coal/shape/geometric_shapes.h>

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"

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

BOOST_AUTO_TEST_CASE(distances_lead_around_the_wall) {
  const TaskSpaceBfs bfs = grid(0.05);
  BOOST_TEST(bfs.distance(goals[0]) == 0.0);
  BOOST_TEST(bfs.distance({0.9, 0.0, 0.0}) < 0.5);
  BOOST_TEST(bfs.distance({-0.5, 0.0, 0.0}) > 1.4);  // over y = 0.55, not straight through
  BOOST_TEST(bfs.distance({-0.5, 0.0, 0.0}) < 2.0);
}

/// Coal's result for a sphere of 0.05 m at the centre of each cell, except where rounding decides.
BOOST_AUTO_TEST_CASE(cells_are_occupied_as_coal_says) {
  const double radius = 0.05, resolution = 0.025;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.3);
  worlds::Dice dice(5);
  for (const auto& [name, shape] : worlds::every_kind()) {
    for (int sample = 0; sample < 3; ++sample) {
      srmp::Scene scene;
      const srmp::Pose pose = worlds::at(dice.in(-0.1, 0.1), dice.in(-0.1, 0.1), dice.in(-0.1, 0.1), dice.in(-3, 3),
                                         dice.in(-3, 3), dice.in(-3, 3));
      scene.add_object(name, shape, pose);
      const TaskSpaceBfs bfs(scene, -half, half, {}, {resolution, radius});
      const auto collides = [&](const Eigen::Vector3d& center, double r) {
        const coal::Sphere sphere(r);
        coal::CollisionResult result;
        const coal::Transform3s place(pose.q.toRotationMatrix(), pose.p);
        return coal::collide(&sphere, coal::Transform3s(center), scene.object(name).geometry.get(), place,
                             coal::CollisionRequest(coal::NO_REQUEST, 1), result) > 0;
      };
      int occupied = 0, compared = 0;
      for (int cell = 0; cell < 24 * 24 * 24; ++cell) {
        const Eigen::Vector3d center =
            -half + resolution * Eigen::Vector3d(cell % 24 + 0.5, cell / 24 % 24 + 0.5, cell / 576 + 0.5);
        const bool small = collides(center, radius - 1e-5), large = collides(center, radius + 1e-5);
        if (small != large) continue;
        ++compared;
        occupied += small;
        BOOST_TEST(bfs.occupied(center) == small, name << " sample " << sample << " cell " << cell);
      }
      BOOST_TEST(compared > 0.99 * 24 * 24 * 24);
      BOOST_TEST(occupied > 200);
    }
  }
}

BOOST_AUTO_TEST_CASE(memory_grows_with_the_cells) {
  BOOST_TEST(grid(0.05).memory() >= 4u * 40 * 40 * 40);
  BOOST_TEST(grid(0.1).memory() < grid(0.05).memory());
}

BOOST_AUTO_TEST_CASE(a_passed_deadline_leaves_a_grid_that_can_be_queried) {
  const TaskSpaceBfs late = grid(0.01, Deadline(0.0));
  BOOST_TEST(late.distance(goals[0]) == 0.0);
  BOOST_TEST(late.distance({-0.5, 0.0, 0.0}) == 0.0);
  // The same wherever the deadline passes.
  for (int polls = 1; polls < 6; ++polls) {
    int left = polls;
    const Deadline deadline(100.0, [&] { return --left <= 0; });
    BOOST_TEST(grid(0.01, deadline).distance({-0.5, 0.0, 0.0}) >= 0.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
