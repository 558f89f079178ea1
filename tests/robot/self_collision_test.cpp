#include <coal/collision.h>

#include <boost/test/unit_test.hpp>

#include "srmp/robot/robot_model.hpp"
#include "support/data.hpp"
#include "support/files.hpp"

using namespace srmp;

namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

std::string link(const std::string& name, double radius) {
  if (radius == 0) return "<link name='" + name + "'/>";
  return "<link name='" + name + "'><collision><geometry><sphere radius='" + std::to_string(radius) +
         "'/></geometry></collision></link>";
}

std::string joint(const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& xyz) {
  return "<joint name='" + child + "_joint' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
         "'/><origin xyz='" + xyz +
         "'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' velocity='1' effort='1'/></joint>";
}

/// Spheres along x:   base ─turns─ a ─fixed─ bare ─turns─ b ─fixed─ c ─turns─ d, 0.1 m apart; c has a large one.
RobotDescription chain() {
  RobotDescription description;
  description.urdf_text = "<robot name='chain'>" + link("base", 0.06) + link("a", 0.06) + link("bare", 0) +
                          link("b", 0.06) + link("c", 0.2) + link("d", 0.06) +
                          joint("revolute", "base", "a", "0.1 0 0") + joint("fixed", "a", "bare", "0 0 0") +
                          joint("revolute", "bare", "b", "0.1 0 0") + joint("fixed", "b", "c", "0.1 0 0") +
                          joint("revolute", "c", "d", "0.1 0 0") + "</robot>";
  return description;
}

Pairs checked(const RobotModel& robot) {
  Pairs pairs;
  for (const auto& [i, j] : robot.self_pairs()) {
    BOOST_TEST(i < j);
    pairs.emplace_back(robot.geometries()[i].link, robot.geometries()[j].link);
  }
  return pairs;
}

bool collides(const RobotModel& robot, const Eigen::VectorXd& q) {
  const RobotDataPtr data = robot.make_data();
  robot.forward(*data, q);
  for (const auto& [i, j] : robot.self_pairs()) {
    const auto &a = robot.geometry_pose(*data, i), &b = robot.geometry_pose(*data, j);
    coal::CollisionResult result;
    if (coal::collide(robot.geometries()[i].shape.get(), coal::Transform3s(a.linear(), a.translation()),
                      robot.geometries()[j].shape.get(), coal::Transform3s(b.linear(), b.translation()),
                      coal::CollisionRequest(), result))
      return true;
  }
  return false;
}

}  // namespace

BOOST_AUTO_TEST_CASE(adjacent_and_rigid_links_are_allowed_with_an_srdf) {
  const TemporaryDirectory directory;
  RobotDescription description = chain();
  description.srdf_path = directory.write("r.srdf", "<robot name='chain'/>");
  const auto robot = RobotModel::load(description);
  // base-a, a-b (through bare) and c-d are joined by one joint; b and c are one body.
  BOOST_TEST(
      (checked(*robot) == Pairs{{"base", "b"}, {"base", "c"}, {"base", "d"}, {"a", "c"}, {"a", "d"}, {"b", "d"}}));
  BOOST_TEST(robot->allowed("b", "a"));
  BOOST_TEST(robot->allowed("c", "b"));
  BOOST_TEST(robot->allowed("a", "a"));
  BOOST_TEST(!robot->allowed("base", "d"));
  BOOST_TEST(robot->always_colliding().empty());
}

BOOST_AUTO_TEST_CASE(srdf_rules_disable_and_enable_pairs) {
  const TemporaryDirectory directory;
  RobotDescription description = chain();
  description.srdf_path = directory.write("r.srdf",
                                          "<robot name='chain'><disable_default_collisions link='base'/>"
                                          "<disable_collisions link1='a' link2='c' reason='Never'/>"
                                          "<enable_collisions link1='base' link2='d'/>"
                                          "<enable_collisions link1='b' link2='c'/></robot>");
  BOOST_TEST((checked(*RobotModel::load(description)) == Pairs{{"base", "d"}, {"a", "d"}, {"b", "d"}}));
}

BOOST_AUTO_TEST_CASE(without_an_srdf_pairs_that_always_collide_are_allowed_and_reported) {
  const auto robot = RobotModel::load(chain());
  // a is never farther from c than 0.2 m, and 0.26 m is contact; base is 0.3 m away when the chain is stretched.
  BOOST_TEST((robot->always_colliding() == Pairs{{"a", "c"}}));
  BOOST_TEST(robot->allowed("a", "c"));
  BOOST_TEST((checked(*robot) == Pairs{{"base", "b"}, {"base", "c"}, {"base", "d"}, {"a", "d"}, {"b", "d"}}));
  const auto again = RobotModel::load(chain());
  BOOST_TEST((again->self_pairs() == robot->self_pairs()));
}

BOOST_AUTO_TEST_CASE(arm7_is_collision_free_when_ready_and_can_collide_with_itself) {
  const auto robot = RobotModel::load(arm7());
  BOOST_TEST(!collides(*robot, robot->group_states().at("ready")));
  BOOST_TEST(!collides(*robot, robot->group_states().at("upright")));
  Eigen::VectorXd hand_on_upper_arm = Eigen::VectorXd::Zero(7), wrist_on_base = Eigen::VectorXd::Zero(7);
  hand_on_upper_arm[3] = 2.4;
  hand_on_upper_arm[5] = 2.1;
  wrist_on_base[1] = 1.9;
  wrist_on_base[3] = 2.4;
  BOOST_TEST(collides(*robot, hand_on_upper_arm));
  BOOST_TEST(collides(*robot, wrist_on_base));
  RobotDescription bare = arm7();
  bare.srdf_path.clear();
  const auto sampled = RobotModel::load(bare);
  BOOST_TEST(sampled->always_colliding().empty());
  BOOST_TEST((sampled->self_pairs() == robot->self_pairs()));
}
