// Plans after objects have moved, come or gone are those of a planner that knew nothing of where they stood before.

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <span>
#include <sstream>

#include "srmp/facade/scene_checkers.hpp"
#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using Eigen::Vector2d;
using srmp::GoalConstraint;
using srmp::PlannerInterface;
using srmp::Pose;

namespace {

const Vector2d start(-1.0, 0.3), goal(1.0, -0.2);

/// Two planar arms 3 m apart, each beside a post.
PlannerInterface two_arms(const std::vector<Pose>& posts) {
  PlannerInterface planner;
  srmp::RobotDescription description = robots::planar_description();
  for (const auto& [name, x] : {std::pair{"left", 0.0}, {"right", 3.0}}) {
    description.name = name;
    planner.add_articulation(description, {.p = {x, 0.0, 0.0}});
  }
  for (std::size_t i = 0; i < posts.size(); ++i) planner.add_cylinder("post" + std::to_string(i), 0.05, 1.0, posts[i]);
  planner.make_planner({"left"}, srmp::Auto{});
  planner.make_planner({"left", "right"}, srmp::Auto{});
  return planner;
}

/// Of one arm, or why there is none; then of both, and of one beside the other, which holds.
std::string plans(PlannerInterface& planner) {
  std::ostringstream text;
  text.precision(17);
  try {
    const srmp::Trajectory path = planner.plan("left", start, GoalConstraint::joints(goal));
    text << path.positions << " " << path.certificate->clearance;
  } catch (const srmp::Error& error) {
    text << error.what();
  }
  try {
    const auto both =
        planner.plan_multi({{"left", start}, {"right", start}},
                           {{"left", GoalConstraint::joints(goal)}, {"right", GoalConstraint::joints(goal)}});
    for (const auto& [name, motion] : both.robots) text << name << motion.positions;
  } catch (const srmp::Error& error) {
    text << error.what();
  }
  try {
    const auto beside =
        planner.plan_multi({{"left", start}, {"right", goal}}, {{"left", GoalConstraint::joints(goal)}});
    text << beside.robots.at("left").positions;
  } catch (const srmp::Error& error) {
    text << error.what();
  }
  text << planner.is_state_colliding("left", start) << planner.is_state_colliding("right", goal);
  return text.str();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(followed_objects)

BOOST_AUTO_TEST_CASE(plans_are_those_of_a_new_planner) {
  std::vector<Pose> posts{{.p = {1.5, 0.0, 0.0}}, {.p = {4.6, 0.1, 0.0}}};
  PlannerInterface planner = two_arms(posts);
  std::set<std::string> different;
  for (int step = 0; step < 12; ++step) {
    const std::string expected = [&] {
      PlannerInterface anew = two_arms(posts);
      return plans(anew);
    }();
    BOOST_TEST(plans(planner) == expected);
    different.insert(expected);
    for (std::size_t i = 0; i < posts.size(); ++i) {
      if ((step + static_cast<int>(i)) % 3 == 0) continue;
      posts[i].p.head<2>() = Vector2d(3.0 * static_cast<double>(i), 0.0) +
                             (0.3 + 0.15 * step) * Vector2d(std::cos(0.7 * step), std::sin(1.3 * step));
      planner.set_object_pose("post" + std::to_string(i), posts[i]);
    }
  }
  BOOST_TEST(different.size() > 6);
}

BOOST_AUTO_TEST_CASE(plans_after_objects_come_and_go_are_those_of_a_new_planner) {
  std::map<std::string, Pose> posts{{"b", {.p = {1.5, 0.0, 0.0}}}};
  const auto add = [](PlannerInterface& planner, const std::string& name, const Pose& pose) {
    planner.add_cylinder(name, 0.05, 1.0, pose);
  };
  PlannerInterface planner = two_arms({});
  add(planner, "b", posts.at("b"));
  std::set<std::string> different;
  for (int step = 0; step < 16; ++step) {
    PlannerInterface anew = two_arms({});
    for (const auto& [name, pose] : posts) add(anew, name, pose);
    const std::string expected = plans(anew);
    BOOST_TEST(plans(planner) == expected);
    different.insert(expected);
    const std::string name(1, static_cast<char>('a' + step * 5 % 7));
    const Pose pose{.p = {0.4 + 0.1 * step, 0.6 * std::sin(1.3 * step), 0.0}};
    if (posts.contains(name)) planner.remove_object(name);
    if (!posts.erase(name) || step % 2 == 0) {
      add(planner, name, pose);
      posts[name] = pose;
    }
  }
  BOOST_TEST(different.size() > 4);
}

BOOST_AUTO_TEST_CASE(plans_after_any_changes_are_those_of_a_new_planner) {
  using Change = std::function<void(PlannerInterface&)>;
  const std::vector<std::string> robots{"left", "right"}, names{"a", "b", "c", "d"};
  std::mt19937 dice(7);
  const auto below = [&](unsigned count) { return dice() % count; };
  const auto in = [&](double low, double high) { return low + (high - low) * below(1000) / 1000.0; };
  std::vector<Change> history;
  PlannerInterface planner = two_arms({});
  std::set<std::string> different;
  const auto do_all = [](PlannerInterface& to, std::span<const Change> changes) {
    for (const Change& change : changes) change(to);
  };
  for (int step = 0; step < 40; ++step) {
    const std::size_t known = history.size();
    for (unsigned count = below(4); count > 0; --count) {
      const std::string name = names[below(4)], robot = robots[below(2)];
      const Pose pose{.p = {in(-2.0, 4.5), in(-1.8, 1.8), 0.0}};
      const double number = in(0.0, 0.05);
      const auto kind = below(8);
      history.push_back([=](PlannerInterface& to) {
        const bool exists = to.scene().objects().contains(name), held = to.scene().attachments().contains(name);
        if (kind == 0) to.set_qpos(robot, 10.0 * number * start);
        if (kind == 1) to.set_base_pose(robot, {.p = {robot == "left" ? 0.0 : 3.0, number, 0.0}});
        if (kind == 2 && exists) to.remove_object(name);
        if (kind == 2) return to.add_box(name, {0.2, 0.1 + number, 0.3}, pose);
        if (!exists) return to.add_cylinder(name, 0.05 + number, 1.0, pose);
        if (kind == 3) to.remove_object(name);
        if (kind == 4) to.set_padding(name, number);
        if (kind == 5 && held) return to.detach_object(name);
        if (kind == 5) to.attach_object(name, robot, to.get_link_names(robot).back(), {}, Pose{});
        if (kind >= 6 && !held) to.set_object_pose(name, pose);
        if (kind == 7) to.set_allowed_collision(name, robot, number < 0.03);
      });
    }
    do_all(planner, std::span(history).subspan(known));
    PlannerInterface anew = two_arms({});
    do_all(anew, history);
    const std::string expected = plans(anew);
    BOOST_TEST(plans(planner) == expected);
    different.insert(expected);
  }
  BOOST_TEST(different.size() > 15);
}

BOOST_AUTO_TEST_CASE(an_object_that_comes_back_has_no_allowed_collisions) {
  PlannerInterface planner = two_arms({});
  const Pose at_the_arm{.p = {0.3, -0.3, 0.0}};
  planner.add_box("box", {0.5, 0.5, 0.5}, at_the_arm);
  BOOST_TEST(planner.is_state_colliding("left", start));
  planner.set_allowed_collision("box", "left");
  BOOST_TEST(!planner.is_state_colliding("left", start));
  planner.set_object_pose("box", at_the_arm);
  BOOST_TEST(!planner.is_state_colliding("left", start));
  planner.remove_object("box");
  planner.add_box("box", {0.5, 0.5, 0.5}, at_the_arm);
  BOOST_TEST(planner.is_state_colliding("left", start));
  planner.attach_object("box", "left", planner.get_link_names("left").back());
  planner.remove_object("box");
  BOOST_TEST(!planner.is_state_colliding("left", start));
  for (int i = 0; i < 20; ++i) planner.add_box("box" + std::to_string(i), {0.1, 0.1, 0.1}, {.p = {9.0, 0.0, 0.0}});
  planner.add_box("box", {0.5, 0.5, 0.5}, at_the_arm);
  BOOST_TEST(planner.is_state_colliding("left", start));
}

BOOST_AUTO_TEST_CASE(checkers_are_kept_where_only_objects_and_their_own_robot_change) {
  PlannerInterface planner = two_arms({{.p = {1.5, 0.0, 0.0}}});
  srmp::Scene scene = planner.scene();
  srmp::SceneCheckers checkers;
  const auto are_kept = [&](auto&& change) {
    const std::weak_ptr<const srmp::ProblemCheckers> before = checkers.of_one(scene, "left");
    change();
    checkers.scene_changed();
    checkers.of_one(scene, "left");
    return !before.expired();
  };
  BOOST_TEST(are_kept([] {}));
  BOOST_TEST(are_kept([&] { scene.set_qpos("left", start); }));
  BOOST_TEST(are_kept([&] {
    for (int i = 0; i < 30; ++i)
      scene.add_object("box" + std::to_string(i), srmp::Box{{0.1, 0.1, 0.1}}, {.p = {9.0, 0.0, 0.0}});
  }));
  BOOST_TEST(are_kept([&] { scene.remove_object("post0"); }));
  BOOST_TEST(!are_kept([&] { scene.set_qpos("right", start); }));
  BOOST_TEST(!are_kept([&] { scene.set_base_pose("left", {{0, 0, 1}, {1, 0, 0, 0}}); }));
  BOOST_TEST(!are_kept([&] { scene.set_allowed_collision("box0", "left"); }));
  BOOST_TEST(!are_kept([&] { checkers.clear(); }));
  const auto held = checkers.of_one(scene, "left");  // one that is in use does not change
  BOOST_TEST(!held->planning.scene().objects().contains("new"));
  scene.add_object("new", srmp::Sphere{0.1}, {.p = {9.0, 0.0, 0.0}});
  checkers.scene_changed();
  BOOST_TEST(checkers.of_one(scene, "left") != held);
  BOOST_TEST(!held->planning.scene().objects().contains("new"));
}

BOOST_AUTO_TEST_CASE(a_backend_of_the_users_makes_its_checkers_again) {
  PlannerInterface planner = two_arms({{.p = {1.5, 0.0, 0.0}}});
  int made = 0;
  planner.set_collision_backend(
      [&](const srmp::Scene& scene, const std::string& robot, const srmp::CheckerOptions& options) {
        ++made;
        return srmp::make_checker(scene, robot, options);
      });
  for (int moves = 0; moves < 3; ++moves) {
    planner.set_object_pose("post0", {.p = {1.5, 0.1 * moves, 0.0}});
    planner.plan("left", start, GoalConstraint::joints(goal));
  }
  BOOST_TEST(made == 3);
}

BOOST_AUTO_TEST_CASE(an_object_that_cannot_be_moved_stays_and_so_do_plans) {
  PlannerInterface planner = two_arms({{.p = {1.5, 0.0, 0.0}}});
  const std::string before = plans(planner);
  check_throws<srmp::InvalidArgument>([&] { planner.set_object_pose("pots0", {}); }, "did you mean 'post0'");
  check_throws<srmp::InvalidArgument>([&] { planner.set_object_pose("post0", {.p = {std::nan(""), 0.0, 0.0}}); },
                                      "NaN");
  BOOST_TEST(plans(planner) == before);
  planner.set_object_pose("post0", {.p = {9.0, 0.0, 0.0}});
  planner.remove_object("post0");  // one that the checkers have not followed yet
  PlannerInterface without = two_arms({});
  BOOST_TEST(plans(planner) == plans(without));
}

BOOST_AUTO_TEST_SUITE_END()
