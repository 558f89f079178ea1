#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/collision/motion_proof.hpp"
#include "support/amount.hpp"

using namespace srmp;
using namespace worlds;

// The proof of a motion begins with distances of any two triangles of meshes, and ends with the own distance of the
// pair that it names, which no other pair is much nearer than.

BOOST_AUTO_TEST_CASE(among_meshes_about_the_nearest_is_found) {
  Dice dice(31);
  Scene scene;
  scene.add_robot(arm7());
  for (int i = 0; i < 20; ++i) scene.add_object("x" + std::to_string(i), dented(), dice.pose(0.3, 1.1));
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace(), other = checker.make_workspace();
  int free = 0;
  for (int i = 0; i < amount(200); ++i) {
    const Eigen::VectorXd q = dice.configuration(checker.robot());
    const RowMatrix still = q.transpose().replicate(2, 1);
    const Eigen::VectorXd times = Eigen::Vector2d(0.0, 1.0);
    const RowMatrix no_velocities(0, q.size());
    const MotionProof proof = prove_motion(checker, {times, still, no_velocities}, *workspace);
    if (!proof.free) continue;
    const auto nearest = checker.nearest(q, *other);
    BOOST_REQUIRE(nearest.has_value());
    ++free;
    BOOST_TEST((nearest->distance - 3e-6 < proof.clearance && proof.clearance < nearest->distance / 0.9 + 3e-6));
    const bool same = nearest->body_a == proof.body_a && nearest->body_b == proof.body_b;
    if (same) BOOST_TEST(std::abs(nearest->distance - proof.clearance) < 3e-6);
  }
  BOOST_TEST(free > amount(50));
}
