#include "srmp/collision/pair_groups.hpp"

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/collision/scene_workspace.hpp"

using namespace srmp;
using namespace worlds;

namespace {

/// Each pair is in one group, whose envelopes are no farther apart than its bodies, and move by no less.
void check_groups(const Scene& scene, const std::vector<std::string>& robots, unsigned seed) {
  const detail::RobotGroup group(scene, robots);
  const detail::SceneModel model(scene, group, {.mode = CheckMode::coal});
  const detail::PairGroups groups(model.bodies);
  detail::SceneWorkspace workspace(model);
  const auto dof = static_cast<Eigen::Index>(group.joints().size());
  workspace.start_any_motion((std::uint64_t{1} << group.actuated_joints().size()) - 1);
  std::vector<int> times(model.bodies.pairs.size());
  Dice dice(seed);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const detail::Pair& around = groups.around(g);
    BOOST_TEST(!groups.members(g).empty());
    for (const std::uint32_t member : groups.members(g)) ++times[member];
    for (int i = 0; i < 5; ++i) {
      Eigen::VectorXd q(dof);
      std::vector<double> change, none(static_cast<std::size_t>(dof));
      for (double& value : q) value = dice.in(-2, 2);
      for (Eigen::Index j = 0; j < dof; ++j) change.push_back(dice.in(0, 0.3));
      workspace.place_in_range(q, change, none, change);
      for (const std::uint32_t member : groups.members(g)) {
        const detail::Pair& pair = model.bodies.pairs[member];
        BOOST_TEST(around.padding >= pair.padding);
        BOOST_TEST((around.support_a == pair.support_a && around.support_b == pair.support_b));
        BOOST_TEST(workspace.distance_bound(around) <= workspace.distance_bound(pair) + 1e-9);
        BOOST_TEST(workspace.approach(around) >= workspace.approach(pair) - 1e-9);
      }
    }
  }
  BOOST_TEST(std::ranges::all_of(times, [](int n) { return n == 1; }));
}

}  // namespace

BOOST_AUTO_TEST_CASE(envelopes_of_a_group_of_pairs_are_around_all_of_its_bodies) {
  Scene scene;
  scene.add_robot(spheres());
  Dice dice(3);
  for (int i = 0; i < 5; ++i)
    scene.add_object("x" + std::to_string(i), Box{{0.1, 0.2, 0.3}}, dice.pose(0.6, 2.5), 0.01 * i);
  check_groups(scene, {"planar"}, 1);
  for (unsigned world = 0; world < 3; ++world) check_groups(crowd(arm7(), world, 2, "arm7_hand"), {"arm7"}, world);
  Scene two;
  two.add_robot(arm7("left"), at(0, 0.35, 0));
  two.add_robot(arm7("right"), at(0, -0.35, 0, 0, 0, 1.0));
  two.add_object("held", Sphere{0.1}, at(0, 0, 0.2));
  two.attach_object("held", "right", "arm7_hand");
  check_groups(two, {"left", "right"}, 5);
}
