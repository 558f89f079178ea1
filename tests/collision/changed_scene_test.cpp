// A checker of a scene that changed takes over what did not: its results are those of one that knows nothing of the
// scene before, with the same work.

#include <boost/test/unit_test.hpp>
#include <set>

#include "collision/worlds.hpp"
#include "srmp/collision/batch/batch_robot.hpp"
#include "srmp/cover/cover_store.hpp"
#include "support/amount.hpp"

using namespace srmp;
using namespace worlds;

namespace {

/// Changes the scene of `crowd` at random: objects, what is held, where robots stand, paddings, settings.
void change(Scene& scene, Dice& dice, const std::string& robot) {
  const auto kinds = every_kind();
  const std::vector<std::string> names = scene.object_names();
  const std::string& name = names[dice.below(names.size())];
  const bool held = scene.attachments().contains(name);
  switch (dice.below(8)) {
    case 0: scene.set_object_pose(name, held ? at(0, 0, dice.in(0.15, 0.25)) : dice.pose(0.45, 0.9)); break;
    case 1: scene.set_padding(name, dice.in(0.0, 0.02)); break;
    case 2:
      if (!held && names.size() > 4) scene.remove_object(name);
      break;
    case 3:
      scene.add_object("new_" + std::to_string(dice.below(1u << 30)), kinds[dice.below(kinds.size())].second,
                       dice.pose(0.45, 0.9));
      break;
    case 4:
      if (held)
        scene.detach_object(name);
      else
        scene.attach_object(name, robot, hand_of(*scene.robot(robot).model), {}, at(0, 0, 0.22));
      break;
    case 5: scene.set_base_pose(robot, at(dice.in(-0.1, 0.1), dice.in(-0.1, 0.1), 0.05)); break;
    case 6: scene.set_robot_padding(robot, dice.in(0.0, 0.01)); break;
    case 7: scene.set_allowed_collision(robot, name, dice.below(2) == 0); break;
  }
}

/// Moves, removes, replaces and adds objects that no robot holds, at least `from` [m] away; returns their names.
std::set<std::string> change_objects(Scene& scene, Dice& dice, double from) {
  const auto kinds = every_kind();
  const auto add = [&](const std::string& name) {
    scene.add_object(name, kinds[dice.below(kinds.size())].second, dice.pose(from, from + 0.45), dice.in(0.0, 0.01));
  };
  std::set<std::string> changed;
  for (const std::string& name : scene.object_names()) {
    if (scene.attachments().contains(name) || dice.below(4) != 0) continue;
    changed.insert(name);
    const auto kind = dice.below(6);
    if (kind < 3) scene.set_object_pose(name, dice.pose(from, from + 0.45));
    if (kind == 3) scene.set_padding(name, dice.in(0.0, 0.02));
    if (kind > 3) scene.remove_object(name);
    if (kind == 5) add(name);
  }
  for (unsigned count = dice.below(3); count > 0; --count) {
    const std::string name = std::string(1, static_cast<char>('a' + dice.below(26))) + std::to_string(dice.below(1000));
    if (scene.objects().contains(name)) continue;
    add(name);
    changed.insert(name);
  }
  return changed;
}

/// Both have the same results, after the same number of steps.
void compare(const Checker& a, const Checker& b, Dice& dice) {
  const auto in_a = a.make_workspace(), in_b = b.make_workspace();
  for (int i = 0; i < 20; ++i) {
    const Eigen::VectorXd q = dice.configuration(a.robot());
    const Eigen::VectorXd other = q + 0.2 * (dice.configuration(a.robot()) - q);
    BOOST_TEST(a.is_free(q, *in_a) == b.is_free(q, *in_b));
    BOOST_TEST(a.is_motion_free(q, other, *in_a) == b.is_motion_free(q, other, *in_b));
    BOOST_TEST(a.clearance(q, *in_a) == b.clearance(q, *in_b));
  }
  const CheckStatistics &x = in_a->statistics, &y = in_b->statistics;
  BOOST_TEST(x.blocks == y.blocks);
  BOOST_TEST(x.undecided == y.undecided);
  BOOST_TEST(x.narrow_phase == y.narrow_phase);
  BOOST_TEST(x.configurations == y.configurations);
}

/// Of a robot of one sphere, at x.
BatchRobot one_sphere(double x) {
  BatchRobot robot;
  robot.bodies.emplace_back();
  robot.bodies[0].bound = {{x, 0, 0}, 1.0};
  robot.bodies[0].coarse = {robot.bodies[0].bound};
  robot.bodies[0].exact = true;
  return robot;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_checker_of_a_changed_scene_has_the_results_of_one_made_anew) {
  const auto robot = arm7();
  for (unsigned seed = 0; seed < amount(10); ++seed) {
    Scene scene = crowd(robot, seed, seed % 10, hand_of(*robot));
    Dice dice(100 + seed);
    const auto covers = std::make_shared<CoverStore>("");
    const auto known = std::make_shared<BatchRobotStore>();
    for (int step = 0; step < 12; ++step) {
      const double clearance = step % 5 == 4 ? 0.01 : 0.0;
      const auto taken_over =
          make_checker(scene, "arm7", {.covers = covers, .clearance = clearance, .batch_robots = known});
      compare(*taken_over, *make_checker(scene, "arm7", {.covers = covers, .clearance = clearance}), dice);
      change(scene, dice, "arm7");
      known->scene_changed();
    }
  }
}

BOOST_AUTO_TEST_CASE(a_checker_that_follows_objects_has_the_results_of_one_made_anew) {
  const auto robot = arm7();
  for (unsigned seed = 0; seed < amount(10); ++seed) {
    Scene scene = crowd(robot, seed, seed % 10, hand_of(*robot));
    scene.set_allowed_collision("box_a", "arm7_base");
    Dice dice(200 + seed);
    const CheckerOptions options{
        .mode = std::array{CheckMode::exact, CheckMode::coal, CheckMode::conservative}[seed % 3],
        .covers = std::make_shared<CoverStore>(""),
        .clearance = seed % 4 == 3 ? 0.01 : 0.0};
    SceneChecker following(scene, "arm7", options);
    for (int step = 0; step < 6; ++step) {
      const std::set<std::string> changed = change_objects(scene, dice, step == 2 ? 0.0 : 0.45);  // into the base too
      following.follow_objects(scene, changed);
      const auto anew = make_checker(scene, "arm7", options);
      compare(following, *anew, dice);
      const auto in_a = following.make_workspace(), in_b = anew->make_workspace();
      for (int i = 0; i < 5; ++i) {
        const Eigen::VectorXd q = dice.configuration(*robot);
        const auto a = following.contacts(q, *in_a), b = anew->contacts(q, *in_b);
        BOOST_TEST_REQUIRE(a.size() == b.size());
        for (std::size_t k = 0; k < a.size(); ++k) BOOST_TEST(a[k].describe() == b[k].describe());
      }
      const auto a = following.nearest_fixed(), b = anew->nearest_fixed();
      BOOST_TEST_REQUIRE(a.has_value() == b.has_value());
      if (a) BOOST_TEST(a->describe() == b->describe());
    }
  }
}

BOOST_AUTO_TEST_CASE(robots_are_made_once_while_they_are_asked_for) {
  BatchRobotStore store;
  int made = 0;
  const auto at_x = [&](double x) {
    return store.get({{}, {x}}, [&] {
      ++made;
      return one_sphere(x);
    });
  };
  const auto first = at_x(0.0);
  BOOST_TEST(at_x(0.0) == first);
  BOOST_TEST(at_x(1.0) != first);
  BOOST_TEST(made == 2);
  for (int i = 0; i < 3; ++i) store.scene_changed();  // several changes, and none is asked for between them
  BOOST_TEST(at_x(0.0) == first);
  BOOST_TEST(made == 2);
  store.scene_changed();
  BOOST_TEST(at_x(0.0) == first);
  BOOST_TEST(at_x(1.0)->reach == 2.0);  // was not asked for between the last two changes
  BOOST_TEST(made == 3);
}
