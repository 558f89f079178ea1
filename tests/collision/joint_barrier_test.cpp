// find_joint_barrier, by configurations all along the joint.
#include "srmp/collision/joint_barrier.hpp"

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"

using namespace srmp;
using namespace worlds;

namespace {

/// The robot of spheres in the plane; the first joint moves its upper link alone.
Scene planar(const std::vector<std::pair<Eigen::Vector3d, Pose>>& boxes) {
  Scene scene;
  scene.add_robot(spheres());
  for (const auto& [size, pose] : boxes)
    scene.add_object("box" + std::to_string(scene.objects().size()), Box{size}, pose);
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_barrier_is_a_contact_wherever_the_other_joints_are_and_none_is_missed) {
  int found = 0, none = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Dice dice(seed);
    std::vector<std::pair<Eigen::Vector3d, Pose>> boxes;
    for (int i = 0; i < 2; ++i) boxes.push_back({{dice.in(0.02, 0.2), dice.in(0.02, 0.2), 0.2}, dice.pose(0.3, 1.3)});
    for (auto& [size, pose] : boxes) pose = at(pose.p.x(), pose.p.y(), 0.0, 0, 0, dice.in(-3, 3));
    const Scene scene = planar(boxes);
    const auto checker = make_checker(scene, "planar");
    const auto workspace = checker->make_workspace();
    const Eigen::Vector2d from(dice.in(-3, 3), 0.4), to(dice.in(-3, 3), -0.2);
    const auto barrier = find_joint_barrier(*checker, from, to, *workspace);
    if (!barrier) {
      ++none;
      for (double s = 0.0; s <= 1.0; s += 1e-3)  // the upper link alone depends on one joint
        for (const std::string& pair : contacts_at(*checker, from + s * Eigen::Vector2d(to - from), *workspace))
          BOOST_CHECK_MESSAGE(pair.find("upper") == std::string::npos, "seed " << seed << ": " << pair);
      continue;
    }
    ++found;
    BOOST_CHECK_EQUAL(barrier->joint, 0u);
    BOOST_CHECK(barrier->position >= std::min(from[0], to[0]) && barrier->position <= std::max(from[0], to[0]));
    const std::string pair = barrier->contact.body_a + " and " + barrier->contact.body_b;
    for (int i = 0; i < 20; ++i)
      BOOST_CHECK(contacts_at(*checker, Eigen::Vector2d(barrier->position, dice.in(-3, 3)), *workspace).count(pair));
  }
  BOOST_CHECK_GT(found, 50);
  BOOST_CHECK_GT(none, 50);
}

BOOST_AUTO_TEST_CASE(what_only_touches_is_a_barrier_and_what_is_near_is_none) {
  // The sphere at the upper link's end gets as far as y = 0.95.
  for (const double gap : {0.0, 1e-4}) {
    const Scene scene = planar({{{0.4, 0.1, 0.2}, at(0.0, 0.95 + gap + 0.05, 0.0)}});
    const auto checker = make_checker(scene, "planar");
    const auto workspace = checker->make_workspace();
    const auto barrier =
        find_joint_barrier(*checker, Eigen::Vector2d(0.5, -2.0), Eigen::Vector2d(2.5, -2.0), *workspace);
    BOOST_REQUIRE_EQUAL(barrier.has_value(), gap == 0.0);
    if (!barrier) continue;
    BOOST_CHECK_SMALL(barrier->position - M_PI / 2, 2e-3);
    BOOST_TEST(barrier->contact.describe() == "link 'upper' and object 'box0' touch");
  }
}

BOOST_AUTO_TEST_CASE(a_continuous_joint_that_can_turn_in_the_other_direction_has_no_barrier) {
  RobotDescription description = robots::planar_description();
  std::string& urdf = description.urdf_text;
  for (std::size_t at = urdf.find("revolute"); at != std::string::npos; at = urdf.find("revolute"))
    urdf.replace(at, 8, "continuous");
  const auto robot = RobotModel::load(description);
  Scene scene;
  scene.add_robot(robot);
  scene.add_object("wall", Box{{0.1, 0.1, 1.0}}, at(0.0, 0.8, 0.0));
  const auto checker = make_checker(scene, robot->name());
  const auto workspace = checker->make_workspace();
  BOOST_CHECK(!find_joint_barrier(*checker, Eigen::Vector2d(0.5, 0.0), Eigen::Vector2d(2.5, 0.0), *workspace));
}
