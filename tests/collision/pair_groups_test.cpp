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

Eigen::Vector3d unit_vector(Dice& dice) {
  return Eigen::Vector3d(dice.in(-1, 1), dice.in(-1, 1), dice.in(-1, 1)).normalized();
}

/// Of the pair, or the group: what its bound loses from here to there.
void check_bound(detail::SceneWorkspace& here, detail::SceneWorkspace& there, const detail::Pair& pair) {
  const detail::DistanceBound bound = here.bound(pair);
  const double now = there.distance_bound(pair);
  BOOST_TEST(now >= bound.distance - here.approach_of_spheres(pair) - 1e-9);
  if (bound.distance <= 0.0) return;
  const Eigen::Vector3d direction = bound.direction();
  BOOST_TEST(now >= bound.distance - here.approach_of_spheres(pair, 1.0, &direction) - 1e-9);
}

/// Planes between two solids here keep a gap there.
void check_gap(detail::SceneWorkspace& here, detail::SceneWorkspace& there, const detail::Pair& pair) {
  if (!pair.solid) return;
  const detail::Separation planes = here.separate(pair, 10.0);
  const double gap = here.free_gap(pair, planes, 0.0);
  if (gap > 0.0) BOOST_TEST(there.distance(pair, 10.0, 0.0) - pair.padding >= gap - 1e-6);
}

/// No bounding sphere moves by more than its envelope says, in any direction, and distances are those of the body.
void check_bounds_in_envelopes(const Scene& scene, const std::vector<std::string>& robots, unsigned seed) {
  const detail::RobotGroup group(scene, robots);
  const detail::SceneModel model(scene, group, {.mode = CheckMode::coal});
  detail::SceneWorkspace here(model), there(model);
  const auto dof = group.joints().size();
  here.start_any_motion((std::uint64_t{1} << group.actuated_joints().size()) - 1);
  Dice dice(seed);
  for (int i = 0; i < 20; ++i) {
    std::vector<double> change, linear, rest;
    Eigen::VectorXd q(static_cast<Eigen::Index>(dof));
    for (double& value : q) value = dice.in(-2, 2);
    const double size = dice.in(0.0, 0.3);
    for (std::size_t j = 0; j < dof; ++j) {
      linear.push_back(dice.in(-size, size));
      rest.push_back(dice.in(0, 0.1 * size));
      change.push_back(std::abs(linear.back()) + rest.back());
    }
    here.place_in_range(q, change, linear, rest);
    for (const detail::Pair& pair : model.bodies.pairs)
      BOOST_TEST(std::abs(here.bound_in_envelopes(pair).distance - here.distance_bound(pair)) < 1e-9);
    for (int sample = 0; sample < 20; ++sample) {
      const double along = sample % 2 ? 1.0 : dice.in(-1, 1);
      Eigen::VectorXd to = q;
      for (std::size_t j = 0; j < dof; ++j)
        to[static_cast<Eigen::Index>(j)] += along * linear[j] + dice.in(-1, 1) * rest[j];
      there.place(to);
      for (std::size_t body = 0; body < model.bodies.moving.size(); ++body) {
        const std::uint64_t support = model.bodies.moving[body].support;
        const Eigen::Vector3d moved = there.placed(false, body).center - here.placed(false, body).center,
                              direction = unit_vector(dice);
        const double along = std::abs(moved.dot(direction));
        BOOST_TEST(moved.norm() <= here.displacement_in_envelope(body, support) + 1e-9);
        BOOST_TEST(along <= here.displacement_in_envelope(body, support, &direction) + 1e-9);
        BOOST_TEST(moved.norm() <= here.displacement_of_sphere(body, support) + 1e-9);
        BOOST_TEST(along <= here.displacement_of_sphere(body, support, 1.0, &direction) + 1e-9);
      }
      for (std::size_t i = 0; i < model.pair_groups().size(); ++i)
        check_bound(here, there, model.pair_groups().pair_of(model.pair_groups().number(i)));
      for (const detail::Pair& pair : model.bodies.pairs) {
        check_bound(here, there, pair);
        check_gap(here, there, pair);
      }
    }
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(bodies_move_no_farther_than_their_envelopes_say) {
  Scene scene;
  scene.add_robot(spheres());
  scene.add_object("box", Box{{0.1, 0.2, 0.3}}, at(1, 1, 0));
  check_bounds_in_envelopes(scene, {"planar"}, 1);
  for (unsigned world = 0; world < 3; ++world)
    check_bounds_in_envelopes(crowd(arm7(), world, 2, "arm7_hand"), {"arm7"}, world);
  Scene two;
  two.add_robot(arm7("left"), at(0, 0.35, 0));
  two.add_robot(slide(), at(0, -0.35, 0, 0, 0, 1.0));
  check_bounds_in_envelopes(two, {"left", "slide"}, 5);
}

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
