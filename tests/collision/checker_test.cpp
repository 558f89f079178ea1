#include "srmp/collision/checker.hpp"

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/core/error.hpp"
#include "support/amount.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace worlds;
using Eigen::Vector2d;

namespace {

/// The planar robot with one object called "x".
struct PlanarWith {
  explicit PlanarWith(const Shape& shape, const Pose& pose, double padding = 0.0, double robot_padding = 0.0) {
    scene.add_robot(robots::planar());
    scene.add_object("x", shape, pose, padding);
    scene.set_robot_padding("planar", robot_padding);
  }
  Scene scene;
};

bool names(const Contact& contact, const std::string& a, const std::string& b) {
  return contact.body_a == a && contact.body_b == b;
}

bool has_contact(const std::vector<Contact>& contacts, const std::string& a, const std::string& b) {
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) { return names(c, a, b); });
}

bool is_free(const Scene& scene, const std::string& robot, ConstVector q) {
  const SceneChecker checker(scene, robot);
  const auto workspace = checker.make_workspace();
  const bool free = checker.is_free(q, *workspace);
  BOOST_TEST(free == checker.contacts(q, *workspace).empty());
  return free;
}

}  // namespace

BOOST_AUTO_TEST_CASE(distance_and_points_are_those_of_geometry) {
  const PlanarWith world(Sphere{0.1}, at(1.5, 0.3, 0));
  const SceneChecker checker(world.scene, "planar");
  const auto workspace = checker.make_workspace();
  const auto nearest = checker.nearest(Vector2d(0, 0), *workspace);
  BOOST_REQUIRE(nearest.has_value());
  BOOST_TEST(names(*nearest, "lower", "x"));
  BOOST_TEST(std::abs(nearest->distance - 0.15) < 1e-6);
  BOOST_TEST((nearest->point_a - Eigen::Vector3d(1.5, 0.05, 0)).norm() < 1e-5);
  BOOST_TEST((nearest->point_b - Eigen::Vector3d(1.5, 0.2, 0)).norm() < 1e-5);
  BOOST_TEST(nearest->describe() == "link 'lower' and object 'x' are 150 mm apart");
}

BOOST_AUTO_TEST_CASE(penetration_is_negative_and_the_points_are_in_the_world) {
  PlanarWith world(Sphere{0.1}, at(1.5, 2.1, 3));
  world.scene.set_base_pose("planar", at(0, 2, 3));
  const SceneChecker checker(world.scene, "planar");
  const auto workspace = checker.make_workspace();
  const auto contacts = checker.contacts(Vector2d(0, 0), *workspace);
  BOOST_REQUIRE(contacts.size() == 1);
  BOOST_TEST(std::abs(contacts[0].distance + 0.05) < 1e-5);
  BOOST_TEST((contacts[0].point_a - Eigen::Vector3d(1.5, 2.05, 3)).norm() < 1e-4);
  BOOST_TEST((contacts[0].point_b - Eigen::Vector3d(1.5, 2.0, 3)).norm() < 1e-4);
  BOOST_TEST(contacts[0].describe() == "link 'lower' and object 'x' overlap by 50 mm");
  BOOST_TEST(checker.nearest(Vector2d(0, 0), *workspace)->distance == contacts[0].distance);
}

BOOST_AUTO_TEST_CASE(padding_of_object_and_robot_counts) {
  const PlanarWith near(Sphere{0.1}, at(1.5, 0.3, 0), 0.05, 0.02), nearer(Sphere{0.1}, at(1.5, 0.3, 0), 0.1, 0.06);
  const SceneChecker checker(near.scene, "planar"), padded(nearer.scene, "planar");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(std::abs(checker.nearest(Vector2d(0, 0), *workspace)->distance - 0.08) < 1e-6);
  BOOST_TEST(checker.is_free(Vector2d(0, 0), *workspace));
  const auto padded_workspace = padded.make_workspace();
  BOOST_TEST(!padded.is_free(Vector2d(0, 0), *padded_workspace));
  const auto contacts = padded.contacts(Vector2d(0, 0), *padded_workspace);
  BOOST_REQUIRE(contacts.size() == 1);
  BOOST_TEST(std::abs(contacts[0].distance + 0.01) < 1e-6);
  BOOST_TEST(contacts[0].describe() ==
             "link 'lower' and object 'x' are 150 mm apart, less than their padding of 160 mm");
}

BOOST_AUTO_TEST_CASE(contacts_come_deepest_first) {
  PlanarWith world(Sphere{0.1}, at(1.5, 0.1, 0));
  world.scene.add_object("deep", Sphere{0.1}, at(0.5, 0.05, 0));
  const SceneChecker checker(world.scene, "planar");
  const auto contacts = checker.contacts(Vector2d(0, 0), *checker.make_workspace());
  BOOST_REQUIRE(contacts.size() == 2);
  BOOST_TEST(names(contacts[0], "upper", "deep"));
  BOOST_TEST(names(contacts[1], "lower", "x"));
}

BOOST_AUTO_TEST_CASE(nothing_to_collide_with_has_no_nearest_pair) {
  Scene scene;
  scene.add_robot(robots::planar());
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(!checker.nearest(Vector2d(0, 0), *workspace).has_value());
  BOOST_TEST(checker.is_motion_free(Vector2d(-3, -3), Vector2d(3, 3), *workspace));
}

BOOST_AUTO_TEST_CASE(configurations_are_checked_at_the_door) {
  Scene scene;
  scene.add_robot(robots::planar());
  check_throws<InvalidArgument>([&] { SceneChecker(scene, "plana"); }, "did you mean 'planar'?");
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  const Vector2d good(0, 0), bad(0, NAN);
  check_throws<InvalidArgument>([&] { checker.is_free(Eigen::VectorXd::Zero(3), *workspace); }, "configuration");
  check_throws<InvalidArgument>([&] { checker.is_free(bad, *workspace); }, "NaN");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(bad, good, *workspace); }, "start of the motion");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(good, bad, *workspace); }, "end of the motion");
  const Vector2d infinite(0, INFINITY), far(0, 2e4), opposite(0, -1.7e308), farthest(0, 1.7e308);
  check_throws<InvalidArgument>([&] { checker.is_motion_free(infinite, infinite, *workspace); }, "start of the motion");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(good, far, *workspace); }, "as far as 10000");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(opposite, farthest, *workspace); }, "as far as 10000");
  check_throws<InvalidArgument>([&] { checker.contacts(bad, *workspace); }, "NaN");
  check_throws<InvalidArgument>([&] { checker.nearest(bad, *workspace); }, "NaN");
}

// --- every kind of object

BOOST_AUTO_TEST_CASE(every_kind_of_object_is_found_by_every_link) {
  const auto robot = arm7();
  const Eigen::VectorXd q = (Eigen::VectorXd(7) << 0.3, 0.4, -0.5, 0.9, 0.2, 0.6, -0.3).finished();
  const auto data = robot->make_data();
  robot->forward(*data, q);
  for (const auto& [name, shape] : every_kind())
    for (std::size_t i = 0; i < robot->geometries().size(); ++i) {
      const LinkGeometry& geometry = robot->geometries()[i];
      const Eigen::Vector3d center = robot->geometry_pose(*data, i) * geometry.center;
      // A cloud and a mesh are hollow: put their surface, not their middle, inside the link.
      const Eigen::Vector3d shift(name == "cloud" ? 0.08 : 0.0, 0, 0);
      Scene scene;
      scene.add_robot(robot);
      scene.add_object("x", shape, Pose{center + shift, Eigen::Quaterniond::Identity()});
      const SceneChecker checker(scene, "arm7");
      const auto workspace = checker.make_workspace();
      BOOST_TEST(!checker.is_free(q, *workspace), name << " in " << geometry.name);
      BOOST_TEST(has_contact(checker.contacts(q, *workspace), geometry.link, "x"), name << " in " << geometry.name);
      scene.set_object_pose("x", at(0, 0, 3));
      BOOST_TEST(is_free(scene, "arm7", q));
    }
}

BOOST_AUTO_TEST_CASE(every_kind_of_attached_object_is_checked_against_world_and_links) {
  const auto robot = arm7();
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  for (const auto& [name, shape] : every_kind()) {
    Scene scene;
    scene.add_robot(robot);
    scene.add_object("held", shape, {});
    scene.attach_object("held", "arm7", "arm7_hand", {}, at(0, 0, 0.5));
    BOOST_TEST(is_free(scene, "arm7", q), name);
    const Pose held = scene.object_pose("held");
    scene.add_object("x", Box{{0.25, 0.25, 0.25}}, held);
    const SceneChecker checker(scene, "arm7");
    const auto workspace = checker.make_workspace();
    const auto contacts = checker.contacts(q, *workspace);
    BOOST_TEST(!checker.is_free(q, *workspace), name);
    BOOST_TEST(has_contact(contacts, "held", "x"), name);
    if (!contacts.empty()) BOOST_TEST(contacts[0].describe().starts_with("attached object 'held' and object 'x'"));

    scene.remove_object("x");  // now against the robot's own upper arm
    scene.detach_object("held");
    const Pose upper = scene.link_pose("arm7", "arm7_upper_arm") * at(name == "cloud" ? 0.08 : 0.0, 0, 0.12);
    scene.attach_object("held", "arm7", "arm7_hand", {}, scene.link_pose("arm7", "arm7_hand").inverse() * upper);
    const SceneChecker self(scene, "arm7");
    BOOST_TEST(has_contact(self.contacts(q, *self.make_workspace()), "arm7_upper_arm", "held"), name);
    scene.set_allowed_collision("held", "arm7");
    BOOST_TEST(is_free(scene, "arm7", q), name);
  }
}

// --- rules

BOOST_AUTO_TEST_CASE(touch_links_and_settings_decide_what_an_attached_object_may_touch) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("cup", Box{{0.2, 0.2, 0.2}}, {});
  scene.attach_object("cup", "planar", "tip", {}, at(-0.1, 0, 0));  // sticks into the lower bar
  const Vector2d q(0, 0);
  BOOST_TEST(!is_free(scene, "planar", q));
  scene.detach_object("cup");
  scene.attach_object("cup", "planar", "tip", {"lower"}, at(-0.1, 0, 0));
  BOOST_TEST(is_free(scene, "planar", q));
  scene.set_allowed_collision("cup", "lower", false);
  BOOST_TEST(!is_free(scene, "planar", q));
  scene.set_allowed_collision("cup", "planar");
  BOOST_TEST(is_free(scene, "planar", q));
}

BOOST_AUTO_TEST_CASE(an_attached_object_may_be_allowed_to_touch_one_object_in_the_world) {
  PlanarWith world(Box{{1, 1, 0.1}}, at(2, 0, -0.2));
  world.scene.add_object("cup", Box{{0.1, 0.1, 0.4}}, {});
  world.scene.attach_object("cup", "planar", "tip", {}, at(0.1, 0, 0));
  BOOST_TEST(!is_free(world.scene, "planar", Vector2d(0, 0)));
  world.scene.set_allowed_collision("cup", "x");
  BOOST_TEST(is_free(world.scene, "planar", Vector2d(0, 0)));
}

BOOST_AUTO_TEST_CASE(two_attached_objects_are_checked_against_each_other) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("one", Sphere{0.1}, {});
  scene.add_object("two", Sphere{0.1}, {});
  scene.attach_object("one", "planar", "upper", {"lower"}, at(0.5, 0.4, 0));
  scene.attach_object("two", "planar", "lower", {"upper"}, at(0.5, 0.4, 0));
  BOOST_TEST(is_free(scene, "planar", Vector2d(0, 0)));
  BOOST_TEST(!is_free(scene, "planar", Vector2d(0, 1.6)));  // folded about joint b until the two touch
  scene.set_allowed_collision("one", "two");
  BOOST_TEST(is_free(scene, "planar", Vector2d(0, 1.6)));
}

BOOST_AUTO_TEST_CASE(a_setting_brings_back_a_pair_that_the_model_leaves_out) {
  Scene scene;
  scene.add_robot(robots::planar());
  const Vector2d folded(0, 2.9);
  BOOST_TEST(is_free(scene, "planar", folded));  // adjacent links
  scene.set_allowed_collision("upper", "lower", false);
  BOOST_TEST(!is_free(scene, "planar", folded));
  BOOST_TEST(is_free(scene, "planar", Vector2d(0, 0)));
}

BOOST_AUTO_TEST_CASE(allowed_collisions_exempt_one_link_only) {
  PlanarWith world(Box{{4, 0.1, 0.1}}, {});
  world.scene.set_allowed_collision("x", "upper");
  const SceneChecker checker(world.scene, "planar");
  const auto contacts = checker.contacts(Vector2d(0, 0), *checker.make_workspace());
  BOOST_REQUIRE(contacts.size() == 1);
  BOOST_TEST(names(contacts[0], "lower", "x"));
  world.scene.set_allowed_collision("planar", "x");
  BOOST_TEST(is_free(world.scene, "planar", Vector2d(0, 0)));
}

BOOST_AUTO_TEST_CASE(other_robots_stand_where_they_were_put_and_so_does_what_they_hold) {
  Scene scene;
  scene.add_robot(arm7("left"));
  scene.add_robot(arm7("right"), at(0, 0.8, 0));
  const Eigen::VectorXd up = Eigen::VectorXd::Zero(7),
                        any = (Eigen::VectorXd(7) << 1.57, 1.5, 0, 0, 0, 0, 0).finished();
  BOOST_TEST(is_free(scene, "left", up));
  const SceneChecker checker(scene, "left");
  const auto contacts = checker.contacts(any, *checker.make_workspace());
  BOOST_REQUIRE(!contacts.empty());
  BOOST_TEST(
      std::all_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.body_b.starts_with("right/"); }));
  scene.add_object("cup", Sphere{0.05}, {});
  scene.attach_object("cup", "right", "arm7_hand", {}, at(0, -0.8, 0));
  const SceneChecker with_cup(scene, "left");
  const auto cup = with_cup.contacts(up, *with_cup.make_workspace());
  BOOST_TEST(has_contact(cup, "arm7_hand", "cup"));
  scene.set_qpos("right", any);
  BOOST_TEST(is_free(scene, "left", up));
}

BOOST_AUTO_TEST_CASE(a_base_may_stand_on_a_table_but_not_in_it) {
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  const auto with_top_at = [&](double z, double padding = 0.0) {
    Scene scene;
    scene.add_robot(arm7());
    scene.add_object("table", Box{{1, 1, 1}}, at(0, 0, z - 0.5), padding);
    return scene;
  };
  BOOST_TEST(is_free(with_top_at(0), "arm7", q));
  BOOST_TEST(is_free(with_top_at(1e-6), "arm7", q));
  BOOST_TEST(is_free(with_top_at(-1e-6), "arm7", q));
  BOOST_TEST(is_free(with_top_at(0, 0.01), "arm7", q));  // padding is for what moves
  Scene sunk = with_top_at(0.001);
  const SceneChecker checker(sunk, "arm7");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(!checker.is_free(q, *workspace));
  BOOST_TEST(!checker.is_motion_free(q, Eigen::VectorXd::Constant(7, 0.01), *workspace));
  const auto contacts = checker.contacts(q, *workspace);
  BOOST_REQUIRE(contacts.size() == 1);
  BOOST_TEST(contacts[0].describe() == "link 'arm7_base' and object 'table' overlap by 1 mm");
  BOOST_TEST(std::abs(checker.nearest(q, *workspace)->distance + 0.001) < 1e-6);
  sunk.set_allowed_collision("table", "arm7_base");
  BOOST_TEST(is_free(sunk, "arm7", q));
}

BOOST_AUTO_TEST_CASE(a_box_around_the_whole_robot_names_the_base_too) {
  Scene scene;
  scene.add_robot(arm7());
  scene.add_object("box", Box{{1, 1, 1}}, at(0, 0, 0));
  const SceneChecker checker(scene, "arm7");
  const auto contacts = checker.contacts(Eigen::VectorXd::Zero(7), *checker.make_workspace());
  BOOST_TEST(has_contact(contacts, "arm7_base", "box"));
  BOOST_TEST(has_contact(contacts, "arm7_shoulder", "box"));
}

BOOST_AUTO_TEST_CASE(nearest_agrees_with_is_free_everywhere) {
  const auto robot = arm7();
  const Scene scene = crowd(robot, 5, 1, "arm7_hand");
  const SceneChecker checker(scene, "arm7");
  const auto workspace = checker.make_workspace();
  Dice dice(9);
  for (int i = 0; i < amount(300); ++i) {
    const Eigen::VectorXd q = dice.configuration(*robot);
    BOOST_TEST(checker.is_free(q, *workspace) == (checker.nearest(q, *workspace)->distance > 1e-9));
  }
}

BOOST_AUTO_TEST_CASE(many_objects_give_the_same_results_as_few) {
  const auto robot = arm7();
  Dice dice(3);
  Scene all;
  all.add_robot(robot);
  std::vector<Scene> each;
  for (int i = 0; i < 60; ++i) {
    const Pose pose = dice.pose(0.3, 1.2);
    each.emplace_back().add_robot(robot);
    each.back().add_object("x", Box{{0.1, 0.1, 0.05}}, pose);
    all.add_object("x" + std::to_string(i), Box{{0.1, 0.1, 0.05}}, pose);
  }
  const SceneChecker checker(all, "arm7");
  const auto workspace = checker.make_workspace();
  std::vector<std::unique_ptr<Checker>> checkers;
  for (const Scene& scene : each) checkers.push_back(std::make_unique<SceneChecker>(scene, "arm7"));
  for (int i = 0; i < 30; ++i) {
    const Eigen::VectorXd q = dice.configuration(*robot);
    const bool free = std::all_of(checkers.begin(), checkers.end(),
                                  [&](const auto& one) { return one->is_free(q, *one->make_workspace()); });
    BOOST_TEST(checker.is_free(q, *workspace) == free);
  }
}

BOOST_AUTO_TEST_CASE(nearest_is_right_for_robots_and_things_of_spheres_only) {
  // Their distance has a formula, which knows no infinite margin.
  for (const double far : {2.3, 50.0, 900.0}) {
    Scene scene;
    scene.add_robot(spheres());
    scene.add_object("x", Sphere{0.1}, at(far, 0, 0));
    for (const CheckMode mode : {CheckMode::exact, CheckMode::coal}) {
      const SceneChecker checker(scene, "planar", {.mode = mode});
      const auto nearest = checker.nearest(Vector2d(0, 0), *checker.make_workspace());
      BOOST_REQUIRE(nearest.has_value());
      BOOST_TEST(names(*nearest, "lower", "x"));
      BOOST_TEST(nearest->distance == far - 1.9 - 0.15, boost::test_tools::tolerance(1e-6));
      BOOST_TEST((nearest->point_b - Eigen::Vector3d(far - 0.1, 0, 0)).norm() < 1e-6 * far);
    }
  }
}

// --- how far a joint moves things

namespace {

/// How far the joint moves any point on the bounding spheres of the robot's bodies per unit, from q on.
double moved(const RobotModel& robot, const Eigen::VectorXd& q, Eigen::Index joint, Dice& dice) {
  constexpr double unit = 1e-3;
  Eigen::VectorXd next = q;
  next[joint] += unit;
  const auto here = robot.make_data(), there = robot.make_data();
  robot.forward(*here, q);
  robot.forward(*there, next);
  double most = 0.0;
  for (std::size_t i = 0; i < robot.geometries().size(); ++i)
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d direction(dice.in(-1, 1), dice.in(-1, 1), dice.in(-1, 1));
      const Eigen::Vector3d p = robot.geometries()[i].center + robot.geometries()[i].radius * direction.normalized();
      most = std::max(most, (robot.geometry_pose(*there, i) * p - robot.geometry_pose(*here, i) * p).norm());
    }
  return most / unit;
}

void expect_to_bound(const RobotModel& robot, double used) {
  Dice dice(1);
  Scene alone;
  alone.add_robot(std::shared_ptr<const RobotModel>(&robot, [](const RobotModel*) {}));
  const Eigen::VectorXd reach = SceneChecker(alone, robot.name()).reach();
  Eigen::VectorXd most = Eigen::VectorXd::Zero(reach.size());
  for (int i = 0; i < amount(300); ++i) {
    const Eigen::VectorXd q = dice.configuration(robot);
    for (Eigen::Index j = 0; j < reach.size(); ++j) most[j] = std::max(most[j], moved(robot, q, j, dice));
  }
  for (Eigen::Index j = 0; j < reach.size(); ++j) {
    BOOST_TEST(most[j] <= reach[j] * (1 + 1e-9));
    BOOST_TEST(most[j] >= used * reach[j]);  // else the bound is of little use
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(reach_bounds_how_far_a_joint_moves_any_point) {
  expect_to_bound(*robots::planar(), 0.95);
  expect_to_bound(*robots::planar("continuous"), 0.95);
  expect_to_bound(*spheres(), 0.95);
  expect_to_bound(*arm7(), 0.3);
  expect_to_bound(*slide(), 0.0);  // nothing is in the drawer
  if (const auto robot = panda()) expect_to_bound(*robot, 0.0);
}

BOOST_AUTO_TEST_CASE(reach_counts_attached_objects_and_other_robots) {
  Scene scene;
  scene.add_robot(robots::planar());
  const Eigen::VectorXd empty = SceneChecker(scene, "planar").reach();
  scene.add_object("held", Sphere{0.1}, {});
  scene.attach_object("held", "planar", "tip", {"lower"}, at(0.4, 0, 0));
  const Eigen::VectorXd holding = SceneChecker(scene, "planar").reach();
  BOOST_TEST(holding[1] == 1.5, boost::test_tools::tolerance(1e-12));  // 1 to the tip, 0.4 to the sphere, 0.1 in it
  BOOST_TEST(holding[0] == 2.5, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(empty[1] < 1.0);
  scene.add_robot(arm7());
  const Eigen::VectorXd both = SceneChecker(scene, "planar", {.other_robots = {"arm7"}}).reach();
  BOOST_TEST(both.size() == 9);
  BOOST_TEST((both.head<2>() == holding));
  BOOST_TEST((both.tail<7>() == SceneChecker(scene, "arm7").reach()));
}

namespace {

/// Two planar arms face to face, 3 m apart, and a post in reach of the first.
Scene arms_and_post() {
  Scene scene;
  RobotDescription description = robots::planar_description();
  for (const char* name : {"left", "right"}) {
    description.name = name;
    scene.add_robot(RobotModel::load(description), at(name[0] == 'l' ? 0 : 3, 0, 0, 0, 0, name[0] == 'l' ? 0 : M_PI));
  }
  scene.add_object("post", Sphere{0.1}, at(0, 1.5, 0));
  return scene;
}

bool free_at(const Checker& checker, const Eigen::VectorXd& q) {
  const auto workspace = checker.make_workspace();
  return checker.is_free(q, *workspace);
}

}  // namespace

BOOST_AUTO_TEST_CASE(excluded_robots_are_left_out_with_attached_objects) {
  Scene scene = arms_and_post();
  scene.set_qpos("right", Eigen::Vector2d(M_PI / 2, 0));
  scene.add_object("held", Sphere{0.1}, at(1.5, 0, 0));
  scene.attach_object("held", "right", "base");
  const Eigen::Vector2d ahead(0, 0), at_post(M_PI / 2, 0);
  for (const CheckMode mode : {CheckMode::coal, CheckMode::exact}) {
    const SceneChecker all(scene, "left", {.mode = mode}),
        alone(scene, "left", {.mode = mode, .excluded_robots = {"right"}});
    BOOST_TEST(!free_at(all, ahead));
    BOOST_TEST(free_at(alone, ahead));
    BOOST_TEST(!free_at(alone, at_post));
    BOOST_TEST(!alone.is_motion_free(ahead, at_post, *alone.make_workspace()));
    BOOST_TEST(alone.contacts(ahead, *alone.make_workspace()).empty());
  }
}

BOOST_AUTO_TEST_CASE(other_robots_only_reports_what_robots_do_to_each_other) {
  const Scene scene = arms_and_post();
  for (const CheckMode mode : {CheckMode::coal, CheckMode::exact}) {
    const SceneChecker pair(scene, "left", {.mode = mode, .other_robots = {"right"}, .other_robots_only = true});
    BOOST_TEST(pair.dof() == 4u);
    BOOST_TEST(!free_at(pair, Eigen::Vector4d(0, 0, 0, 0)));
    BOOST_TEST(free_at(pair, Eigen::Vector4d(M_PI / 2, 0, 1, 0)));  // the left one in the post
    BOOST_TEST(free_at(pair, Eigen::Vector4d(2, 3, 1, 0)));         // and folded onto itself
    const Eigen::Vector4d apart(1.2, 0, 1.2, 0), other_side(-1.2, 0, -1.2, 0);
    BOOST_TEST(!pair.is_motion_free(apart, other_side, *pair.make_workspace()));
    const auto contacts = pair.contacts(Eigen::Vector4d(0, 0, 0, 0), *pair.make_workspace());
    BOOST_REQUIRE(!contacts.empty());
    BOOST_TEST(contacts.front().body_b.starts_with("right/"));
  }
}

BOOST_AUTO_TEST_CASE(range_holds_the_robot_wherever_it_stands) {
  Scene scene = arms_and_post();
  const PlacedSphere empty = SceneChecker(scene, "right").range();
  scene.add_object("held", Sphere{0.1}, at(0, 0, 0));
  scene.attach_object("held", "right", "tip", {"lower"}, at(0.4, 0, 0));
  const PlacedSphere range = SceneChecker(scene, "right").range();
  BOOST_TEST(range.radius > empty.radius);
  for (double a = -3; a <= 3; a += 0.5)
    for (double b = -3; b <= 3; b += 0.5) {
      scene.set_qpos("right", Eigen::Vector2d(a, b));
      const auto& instance = scene.robot("right");
      const Pose tip = instance.base * instance.model->compute_fk(instance.q, "tip", instance.other_positions);
      const Eigen::Vector3d held = tip.p + tip.q * Eigen::Vector3d(0.4, 0, 0);
      BOOST_TEST((held - range.center).norm() + 0.1 <= range.radius + 1e-9);
    }
  BOOST_TEST(range.radius < 2 * 2.5);
}

BOOST_AUTO_TEST_CASE(by_spheres_alone_is_never_free_wrongly) {
  const Scene scene = arms_and_post();
  const SceneChecker exact(scene, "left", {.other_robots = {"right"}, .other_robots_only = true});
  const SceneChecker coal(scene, "left",
                          {.mode = CheckMode::coal, .other_robots = {"right"}, .other_robots_only = true});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> turn(-1.5, 1.5);
  const RowMatrix q = RowMatrix::NullaryExpr(200, 4, [&] { return turn(random); });
  const auto check_all = [&](const Checker& checker, bool by_spheres) {
    const auto free = std::make_unique<bool[]>(200);
    checker.are_free(q, {free.get(), 200}, *checker.make_workspace(), {.spheres_only = by_spheres});
    return std::vector<bool>(free.get(), free.get() + 200);
  };
  const auto truth = check_all(coal, false), spheres_only = check_all(exact, true);
  BOOST_TEST((check_all(exact, false) == truth));
  BOOST_TEST((check_all(coal, true) == truth));  // it has no spheres
  int proved = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    BOOST_TEST((!spheres_only[i] || truth[i]));
    proved += spheres_only[i];
  }
  BOOST_TEST(2 * proved > std::count(truth.begin(), truth.end(), true));
}
