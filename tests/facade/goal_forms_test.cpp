#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using Eigen::Vector2d;
using srmp::GoalConstraint;
using srmp::PlannerInterface;

namespace {

/// Two bars, with the state "folded".
PlannerInterface planar_with_states() {
  srmp::RobotDescription description = robots::planar_description();
  description.srdf_text =
      "<robot name='planar'><group name='arm'><chain base_link='base' tip_link='tip'/></group>"
      "<group_state name='folded' group='arm'><joint name='a' value='1'/><joint name='b' "
      "value='2'/></group_state></robot>";
  PlannerInterface planner;
  planner.add_articulation(description);
  return planner;
}

const Vector2d rest(-1.0, 0.0), turned(1.0, 0.0);

}  // namespace

BOOST_AUTO_TEST_SUITE(goal_forms)

BOOST_AUTO_TEST_CASE(every_form_of_a_goal_plans_the_same_without_make_planner) {
  PlannerInterface planner = planar_with_states();
  const srmp::Trajectory expected = planner.plan("planar", rest, GoalConstraint::joints(turned));
  const std::map<std::string, double> by_name{{"a", 1.0}};
  BOOST_TEST((planner.plan("planar", rest, turned).positions == expected.positions));
  BOOST_TEST((planner.plan(rest, by_name).positions == expected.positions));
  BOOST_TEST((planner.plan(rest, std::vector{GoalConstraint::joints(turned)}.front()).positions == expected.positions));
  const srmp::Trajectory folded = planner.plan(rest, "folded");
  BOOST_TEST((folded.positions.bottomRows<1>().transpose() == Vector2d(1, 2)));
  const srmp::Pose pose = planner.compute_fk("planar", turned);
  BOOST_TEST(
      (planner.plan(rest, pose).positions == planner.plan("planar", rest, GoalConstraint::pose(pose)).positions));
  planner.make_planner({"planar"}, srmp::Auto{});
  BOOST_TEST((planner.plan(rest, turned).positions == expected.positions));
}

BOOST_AUTO_TEST_CASE(joints_not_named_stay_as_at_the_start) {
  PlannerInterface planner = planar_with_states();
  const std::map<std::string, double> by_name{{"b", 0.5}};
  BOOST_TEST((planner.goal("planar", by_name, rest).targets[0] == Vector2d(-1.0, 0.5)));
  planner.set_qpos("planar", turned);
  BOOST_TEST((planner.goal("planar", by_name).targets[0] == Vector2d(1.0, 0.5)));
}

BOOST_AUTO_TEST_CASE(wrong_forms_are_refused) {
  PlannerInterface planner = planar_with_states();
  const auto refused = [&](const srmp::Goal& goal, const std::string& sentence) {
    check_throws<srmp::InvalidArgument>([&] { planner.plan(rest, goal); }, sentence);
    BOOST_TEST(!planner.last_request());
  };
  refused("foldde", "there is no state 'foldde' of all its planned joints in the SRDF, did you mean 'folded'?");
  refused(std::map<std::string, double>{{"t", 1.0}}, "joint 't' of robot 'planar' is fixed");
  refused(std::map<std::string, double>{}, "names no joint; planned are 'a' and 'b'");
  refused(Eigen::VectorXd(Eigen::Vector3d::Zero()), "goal of 'planar' has 3 values");
  check_throws<srmp::InvalidArgument>([&] { planner.goal("plnar", "folded"); }, "did you mean 'planar'");
  check_throws<srmp::InvalidArgument>([] { PlannerInterface().plan(rest, "folded"); }, "call add_articulation first");
}

BOOST_AUTO_TEST_CASE(poses_of_links_are_reached_at_the_same_time) {
  PlannerInterface planner = planar_with_states();
  const std::map<std::string, srmp::Pose> goal{{"tip", planner.compute_fk("planar", turned, "tip")}};
  const srmp::Trajectory motion = planner.plan(rest, goal);
  BOOST_TEST(
      planner.compute_fk("planar", motion.positions.bottomRows<1>().transpose()).p.isApprox(goal.at("tip").p, 1e-4));
  BOOST_TEST(planner.goal("planar", goal).links.size() == 1u);
  const auto refused = [&](const srmp::Goal& wrong, const std::string& sentence) {
    check_throws<srmp::InvalidArgument>([&] { planner.plan(rest, wrong); }, sentence);
  };
  refused(std::map<std::string, srmp::Pose>{}, "names no link; such as 'tip'");
  refused(std::map<std::string, srmp::Pose>{{"a", {}}}, "'a' is a joint, whose goal is a number");
  refused(std::map<std::string, srmp::Pose>{{"tpi", {}}}, "did you mean 'tip'");
  refused(std::map<std::string, double>{{"tip", 1.0}}, "'tip' is a link, whose goal is a Pose");
  GoalConstraint twice = GoalConstraint::pose({}, "tip");
  twice.links.emplace_back("tip");
  refused(twice, "names the link 'tip' twice");
  twice.links.back() = "base";
  refused(twice, "a target for 2 links is 14 numbers, 7 for each, but got 7");
}

BOOST_AUTO_TEST_CASE(warnings_are_listed) {
  srmp::RobotDescription description = robots::planar_description();
  description.srdf_text = "<robot name='planar'><passive_joint name='wheel'/></robot>";
  PlannerInterface planner;
  planner.add_articulation(description);
  BOOST_TEST_REQUIRE(planner.warnings("planar").size() == 1u);
  BOOST_TEST(planner.warnings("planar")[0] == "SRDF text:1: <passive_joint> names the unknown joint 'wheel'");
}

BOOST_AUTO_TEST_SUITE_END()
