#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/collision/motion_proof.hpp"
#include "support/amount.hpp"

using namespace srmp;
using namespace worlds;

/// A box that slides and tilts on a tabletop, within 0.1 mm.
BOOST_AUTO_TEST_CASE(what_a_workspace_was_used_for_before_does_not_count) {
  const auto joint = [](const char* name, const char* type, const char* parent, const char* child, const char* axis) {
    return robots::joint(name, type, parent, child, "0 0 0", axis,
                         "<limit lower='-2' upper='2' velocity='1' effort='1'/>");
  };
  RobotDescription box;
  box.end_effector = "box";
  box.urdf_text =
      "<robot name='r'><link name='base'/><link name='slider'/><link name='lift'/><link name='box'><collision>"
      "<geometry><box size='0.4 0.2 0.1'/></geometry></collision></link>" +
      joint("x", "prismatic", "base", "slider", "1 0 0") + joint("z", "prismatic", "slider", "lift", "0 0 1") +
      joint("a", "revolute", "lift", "box", "0 1 0") + "</robot>";
  Scene scene;
  scene.add_robot(RobotModel::load(box));
  scene.add_object("table", Box{{1, 1, 0.1}}, at(0, 0, -0.1));
  const SceneChecker checker(scene, "r", {.mode = CheckMode::coal});
  const auto lowest = [](double tilt) { return 0.2 * std::abs(std::sin(tilt)) + 0.05 * std::cos(tilt) - 0.05; };
  Dice dice(3);
  for (int i = 0; i < amount(1000); ++i) {
    const double tilt = dice.in(-0.02, 0.02), turned = tilt + dice.in(-1, 1) * std::pow(10, dice.in(-4.5, -1.5));
    const double height = dice.in(1e-5, 1.2e-4), to = dice.in(-0.05, 0.05);
    RowMatrix positions(2, 3);
    positions << 0, height + lowest(tilt), tilt, to, height + lowest(turned), turned;
    const auto fresh = checker.make_workspace(), used = checker.make_workspace();
    BOOST_TEST(!checker.is_motion_free(Eigen::Vector3d(0, 0.5, 0), Eigen::Vector3d(0, -0.6, 0), *used));
    const CubicMotion motion{Eigen::Vector2d(0, 1), positions, RowMatrix(0, 3)};
    const MotionProof expected = prove_motion(checker, motion, *fresh), found = prove_motion(checker, motion, *used);
    BOOST_TEST(found.free == expected.free);
    BOOST_TEST(found.clearance == expected.clearance);
    BOOST_TEST(found.proved == expected.proved);
  }
}
