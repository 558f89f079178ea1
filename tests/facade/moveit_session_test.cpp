#include "srmp/moveit_session.hpp"

#include <boost/test/unit_test.hpp>
#include <chrono>
#include <thread>

#include "moveit_case.hpp"
#include "srmp/planner_interface.hpp"
#include "support/data.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace moveit_case;

namespace {

/// Two arms of three joints side by side on one base, in the plane; they can reach each other.
MoveItRobot two_arms() {
  const std::string limit = "<limit lower='-3' upper='3' velocity='2' effort='1'/>";
  std::string urdf = "<robot name='pair'><link name='base'/>", srdf = "<robot name='pair'>";
  for (const std::string side : {"left", "right"}) {
    const auto name = [&](const std::string& part) { return side + "_" + part; };
    const auto bar = [&](const std::string& part) {
      return "<link name='" + name(part) +
             "'><collision><origin xyz='0.25 0 0'/><geometry><box size='0.4 0.08 0.08'/></geometry></collision></link>";
    };
    urdf += bar("upper") + bar("middle") + bar("lower") + "<link name='" + name("tip") + "'/>" +
            robots::joint(name("a"), "revolute", "base", name("upper"), side == "left" ? "0 0.5 0" : "0 -0.5 0",
                          "0 0 1", limit) +
            robots::joint(name("b"), "revolute", name("upper"), name("middle"), "0.5 0 0", "0 0 1", limit) +
            robots::joint(name("c"), "revolute", name("middle"), name("lower"), "0.5 0 0", "0 0 1", limit) +
            robots::joint(name("t"), "fixed", name("lower"), name("tip"), "0.5 0 0", "0 0 1", "");
    srdf += "<group name='" + side + "'><chain base_link='base' tip_link='" + name("tip") + "'/></group>";
    srdf += "<disable_collisions link1='" + name("upper") + "' link2='" + name("middle") + "' reason='Adjacent'/>";
    srdf += "<disable_collisions link1='" + name("middle") + "' link2='" + name("lower") + "' reason='Adjacent'/>";
  }
  srdf += "<group name='both'><group name='left'/><group name='right'/></group></robot>";
  return {urdf + "</robot>", srdf, {}, {}};
}

/// A scene and a request in which both arms turn a little.
std::pair<io::SceneFile, io::RequestFile> turn_of_both_arms() {
  io::SceneFile scene;
  io::RequestFile request;
  request.group_name = "both";
  request.goals.resize(1);
  for (const std::string joint : {"left_a", "left_b", "left_c", "right_a", "right_b", "right_c"}) {
    scene.robot_state.joints[joint] = 0.0;
    request.goals[0].joints.push_back({joint, joint.starts_with("left") ? 0.2 : -0.2, 0.001, 0.001});
  }
  return {scene, request};
}

}  // namespace

BOOST_AUTO_TEST_CASE(an_answer_is_what_plan_finds_and_does_not_depend_on_requests_before) {
  PlannerInterface planner;
  RobotDescription description = arm7();
  description.group = "arm";
  planner.add_articulation(description);
  planner.add_box("box", {0.1, 0.1, 0.8}, Pose{{0.35, 0.2, 0.4}});
  Case question;
  question.add_box("box", {0.35, 0.2, 0.4}, {0.1, 0.1, 0.8});
  Eigen::VectorXd start(7), goal(7);
  start << 0, 0, 0, M_PI / 2, 0, M_PI / 2, 0;
  goal = start;
  goal[0] = 0.8;
  const Trajectory expected = planner.plan(start, GoalConstraint::joints(goal));
  MoveItSession session(arm_robot());
  const MoveItResponse first = session.solve(question.scene, question.request);
  BOOST_REQUIRE(first.code == Code::success);
  BOOST_TEST((first.trajectory.positions == expected.positions));
  BOOST_TEST((first.trajectory.times == expected.times));
  BOOST_TEST(first.trajectory.velocities.rows() == expected.positions.rows());
  BOOST_TEST(first.trajectory.accelerations.rows() == expected.positions.rows());

  Case other;  // without the box, with an object in the hand
  other.attach("rod", "arm7_hand");
  BOOST_REQUIRE(session.solve(other.scene, other.request).code == Code::success);
  const MoveItResponse again = session.solve(question.scene, question.request);
  BOOST_TEST((again.trajectory.positions == expected.positions));
}

BOOST_AUTO_TEST_CASE(what_the_scene_holds_decides) {
  MoveItSession session(arm_robot());
  Case free;
  const MoveItResponse straight = session.solve(free.scene, free.request);
  Case blocked;
  blocked.add_box("box", {0.32, 0.15, 0.55}, {0.05, 0.05, 0.3});
  const MoveItResponse around = session.solve(blocked.scene, blocked.request);
  BOOST_REQUIRE(around.code == Code::success);
  BOOST_TEST(around.trajectory.length() > straight.trajectory.length() + 0.1);

  // The same box, allowed to be touched, and then not any more.
  blocked.scene.allowed_collisions.defaults["box"] = true;
  BOOST_TEST((session.solve(blocked.scene, blocked.request).trajectory.positions == straight.trajectory.positions));
  blocked.scene.allowed_collisions.defaults.clear();
  BOOST_TEST((session.solve(blocked.scene, blocked.request).trajectory.positions == around.trajectory.positions));
  BOOST_TEST((session.solve(free.scene, free.request).trajectory.positions == straight.trajectory.positions));
}

BOOST_AUTO_TEST_CASE(attached_objects_and_padding_count) {
  MoveItSession session(arm_robot());
  Case held;
  held.add_box("floor of the goal", {0.28, 0.28, 0.37}, {0.2, 0.2, 0.02});
  BOOST_TEST(to_string(session.solve(held.scene, held.request).code) == "SUCCESS");
  io::CollisionObject& rod = held.attach("rod", "arm7_hand").object;
  rod.shapes[0].shape = Box{{0.02, 0.02, 0.3}};
  rod.pose.p = {0, 0, 0.2};
  const MoveItResponse with_rod = session.solve(held.scene, held.request);
  BOOST_TEST(to_string(with_rod.code) == "GOAL_IN_COLLISION", with_rod.message);
  held.request.start_state.attached.clear();
  BOOST_TEST(to_string(session.solve(held.scene, held.request).code) == "SUCCESS");
  const auto robot = RobotModel::load(arm7());
  for (const auto& geometry : robot->geometries()) held.scene.link_padding[geometry.link] = 0.09;
  BOOST_TEST(to_string(session.solve(held.scene, held.request).code) == "GOAL_IN_COLLISION");
  held.scene.link_padding.clear();
  BOOST_TEST(to_string(session.solve(held.scene, held.request).code) == "SUCCESS");
}

BOOST_AUTO_TEST_CASE(limits_of_the_robot_model_and_scaling_hold) {
  MoveItRobot robot = arm_robot();
  MoveItSession as_in_urdf(robot);
  robot.bounds["arm7_joint1"] = {.lower = -1.0, .upper = 0.5, .velocity = 0.2, .acceleration = 0.4, .jerk = {}};
  MoveItSession narrow(robot);
  Case question;
  const double duration = as_in_urdf.solve(question.scene, question.request).trajectory.duration();
  BOOST_TEST(to_string(narrow.solve(question.scene, question.request).code) == "GOAL_STATE_INVALID");
  question.joint(0).position = 0.4;
  BOOST_TEST(narrow.solve(question.scene, question.request).trajectory.duration() > 2.0);
  question.joint(0).position = 0.8;
  question.request.velocity_scaling = 0.1;
  BOOST_TEST(as_in_urdf.solve(question.scene, question.request).trajectory.duration() > 2.0 * duration);
}

BOOST_AUTO_TEST_CASE(planner_configurations_are_found_by_name) {
  MoveItSession session(arm_robot());
  session.set_configurations({{"arm", {{"planner_id", std::string("wAstar")}, {"weight", std::string("20")}}},
                              {"arm[fast]", {{"planner_id", std::string("rrt_connect")}}}});
  Case question;
  const auto planner = [&](const std::string& id) {
    question.request.planner_id = id;
    return session.solve(question.scene, question.request).planner_id;
  };
  BOOST_TEST(planner("") == "wAstar");
  BOOST_TEST(planner("fast") == planner("arm[fast]"));
  BOOST_TEST(planner("fast") != "wAstar");
  BOOST_TEST(planner("wPASE") == "wPASE");
  const auto ids = session.planner_ids();
  BOOST_TEST((std::find(ids.begin(), ids.end(), "arm[fast]") != ids.end()));
  check_throws<InvalidArgument>([&] { session.set_configurations({{"arm", {{"wieght", 2.0}}}}); },
                                "planner configuration 'arm': ");
}

BOOST_AUTO_TEST_CASE(another_thread_stops_a_plan_within_20_ms) {
  MoveItSession session(arm_robot());
  Case question;
  question.add_box("box", {0.32, 0.15, 0.55}, {0.05, 0.05, 0.3});
  question.request.planner_id = "Astar";
  question.request.allowed_planning_time = 60.0;
  session.set_configurations({{"arm", {{"planner_id", std::string("Astar")}, {"resolution", 3.0}}}});
  question.request.planner_id = "";
  double best = 1.0;  // [s]; the machine may be busy
  for (int attempt = 0; attempt < 5 && best > 0.02; ++attempt) {
    std::atomic<bool> stop{false};
    std::chrono::steady_clock::time_point stopped;
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(150));
      stopped = std::chrono::steady_clock::now();
      stop = true;
    });
    const MoveItResponse response = session.solve(question.scene, question.request, &stop);
    const auto end = std::chrono::steady_clock::now();
    other.join();
    BOOST_TEST(to_string(response.code) == "PREEMPTED", response.message);
    best = std::min(best, std::chrono::duration<double>(end - stopped).count());
  }
  BOOST_TEST(best < 0.02);
  const std::atomic<bool> stop{true};
  BOOST_TEST(to_string(session.solve(question.scene, question.request, &stop).code) == "PREEMPTED");
}

BOOST_AUTO_TEST_CASE(a_group_of_two_arms_is_planned_by_planners_for_several_robots) {
  MoveItSession session(two_arms());
  io::SceneFile scene;
  io::RequestFile request;
  request.group_name = "both";
  request.goals.resize(1);
  for (const std::string side : {"left", "right"})
    for (const std::string joint : {"a", "b", "c"}) {
      const double sign = side == "left" ? 1.0 : -1.0;  // from the outside towards each other
      scene.robot_state.joints[side + "_" + joint] = joint == "a" ? sign * 1.0 : 0.0;
      const double goal = joint == "a" ? -sign * 0.7 : joint == "b" ? sign * 1.4 : 0.3;
      request.goals[0].joints.push_back({side + "_" + joint, goal, 0.001, 0.001});
    }
  for (const char* id : {"xECBS", "ECBS", "auto"}) {
    request.planner_id = id;
    const MoveItResponse response = session.solve(scene, request);
    BOOST_TEST(to_string(response.code) == "SUCCESS", id << ": " << response.message);
    BOOST_TEST(response.trajectory.dof() == 6u);
    if (response.code != Code::success) continue;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto& goals = request.goals[0].joints;
      const auto goal = std::find_if(goals.begin(), goals.end(), [&](const auto& constraint) {
        return constraint.joint == response.trajectory.joint_names[i];
      });
      BOOST_REQUIRE((goal != goals.end()));
      BOOST_TEST(std::abs(response.trajectory.positions.bottomRows(1)(0, static_cast<Eigen::Index>(i)) -
                          goal->position) < 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(planners_of_several_arms_take_no_path_constraints_and_start_at_rest) {
  MoveItSession session(two_arms());
  auto [scene, request] = turn_of_both_arms();
  request.planner_id = "xECBS";
  request.start_state.velocities["left_a"] = 0.1;
  const MoveItResponse moving = session.solve(scene, request);
  BOOST_TEST(to_string(moving.code) == "START_STATE_INVALID");
  BOOST_TEST(moving.message.find("several arms") != std::string::npos, moving.message);
  request.start_state.velocities.clear();
  io::PositionConstraint position{.link = "left_tip", .frame = ""};
  position.regions.push_back({Sphere{3.0}, {}});
  request.path_constraints.positions = {position};
  const MoveItResponse constrained = session.solve(scene, request);
  BOOST_TEST(to_string(constrained.code) == "PLANNING_FAILED");
  BOOST_TEST(constrained.message.find("several arms") != std::string::npos, constrained.message);
}

BOOST_AUTO_TEST_CASE(auto_plans_several_arms_as_one_robot_for_what_only_one_robot_supports) {
  MoveItSession session(two_arms());
  auto [scene, request] = turn_of_both_arms();
  io::PositionConstraint position{.link = "left_tip", .frame = ""};
  position.regions.push_back({Sphere{3.0}, {}});
  io::RequestFile constrained = request, moving = request, alternatives = request;
  constrained.path_constraints.positions = {position};
  moving.start_state.velocities["left_a"] = 0.1;
  alternatives.goals.push_back(request.goals[0]);
  for (const io::RequestFile& one : {constrained, moving, alternatives}) {
    const MoveItResponse response = session.solve(scene, one);
    BOOST_TEST(to_string(response.code) == "SUCCESS", response.message);
    BOOST_TEST(response.trajectory.dof() == 6u);
  }
  BOOST_TEST(session.solve(scene, moving).trajectory.velocities.row(0).maxCoeff() == 0.1);
}

BOOST_AUTO_TEST_CASE(subgroups_that_move_a_link_together_are_one_robot) {
  MoveItRobot robot = two_arms();  // the second group is carried by the first, as a hand is by an arm
  robot.srdf_text =
      "<robot name='pair'><group name='upper'><joint name='left_a'/><joint name='left_b'/></group>"
      "<group name='wrist'><joint name='left_c'/></group><group name='whole'><group name='upper'/>"
      "<group name='wrist'/></group><disable_collisions link1='left_upper' link2='left_middle' reason=''/>"
      "<disable_collisions link1='left_middle' link2='left_lower' reason=''/></robot>";
  MoveItSession session(robot);
  io::SceneFile scene;
  io::RequestFile request;
  request.group_name = "whole";
  request.goals.resize(1);
  for (const std::string joint : {"left_a", "left_b", "left_c"}) {
    scene.robot_state.joints[joint] = 0.0;
    request.goals[0].joints.push_back({joint, 0.2, 0.001, 0.001});
  }
  for (const char* id : {"", "auto", "RRTConnect"}) {
    request.planner_id = id;
    const MoveItResponse response = session.solve(scene, request);
    BOOST_TEST(to_string(response.code) == "SUCCESS", id << ": " << response.message);
    BOOST_TEST(response.trajectory.dof() == 3u);
  }
  request.planner_id = "xECBS";
  const MoveItResponse response = session.solve(scene, request);
  BOOST_TEST(to_string(response.code) == "INVALID_GROUP_NAME");
  BOOST_TEST(response.message.find("more than one of the groups") != std::string::npos, response.message);
}

BOOST_AUTO_TEST_CASE(what_is_placed_in_a_frame_that_moves_is_placed_anew_at_each_start) {
  // A rod that is given in the world is held from where it lies; the start says where the hand is then.
  Case question;
  question.attach("rod", "arm7_hand");
  io::CollisionObject& rod = question.request.start_state.attached.back().object;
  rod.frame = "";
  rod.pose = Pose{{0.33, 0.0, 0.39}};  // below the hand
  question.add_box("cup", {0.0, 0.3, 0.0}, {0.05, 0.05, 0.05}).frame = "arm7_forearm";
  Case turned = question;
  turned.request.start_state.joints = ready;
  turned.request.start_state.joints["arm7_joint1"] = -0.3;
  turned.add_box("post", {0.33 * std::cos(0.3), -0.33 * std::sin(0.3), 0.35}, {0.02, 0.02, 0.02});
  MoveItSession session(arm_robot()), fresh(arm_robot());
  BOOST_REQUIRE(session.solve(question.scene, question.request).code == Code::success);
  const MoveItResponse again = session.solve(turned.scene, turned.request);
  const MoveItResponse first = fresh.solve(turned.scene, turned.request);
  BOOST_TEST(to_string(first.code) == "SUCCESS", first.message);
  BOOST_TEST(to_string(again.code) == "SUCCESS", again.message);
  BOOST_TEST((again.trajectory.positions == first.trajectory.positions));
  Case below = turned;  // still below the hand, it would touch the post
  below.request.start_state.attached.clear();
  below.attach("rod", "arm7_hand");
  const MoveItResponse touches = fresh.solve(below.scene, below.request);
  BOOST_TEST(to_string(touches.code) == "START_STATE_IN_COLLISION", touches.message);
}

BOOST_AUTO_TEST_CASE(a_start_in_motion_that_is_wrong_has_the_code_of_what_is_wrong) {
  MoveItSession session(arm_robot());
  const auto refused = [&](const Case& question, const std::string& code, const std::string& fragment) {
    const MoveItResponse response = session.solve(question.scene, question.request);
    BOOST_TEST(to_string(response.code) == code, response.message);
    BOOST_TEST(response.message.find(fragment) != std::string::npos, response.message);
  };
  Case moving;
  moving.request.start_state.velocities["arm7_joint1"] = 0.5;
  Case goal = moving;
  goal.add_box("box", {0.28, 0.28, 0.55}, {0.1, 0.1, 0.1});
  refused(goal, "GOAL_IN_COLLISION", "box");
  Case start = moving;
  start.add_box("box", {0.3, 0, 0.6}, {0.3, 0.3, 0.3});
  refused(start, "START_STATE_IN_COLLISION", "box");
  Case stop = moving;  // free, but the robot runs into the wall before it stands
  stop.request.start_state.velocities["arm7_joint1"] = 2.0;
  stop.joint(0).position = -0.8;
  stop.add_box("wall", {0.33, 0.16, 0.5}, {0.4, 0.02, 1.0});
  refused(stop, "START_STATE_INVALID", "cannot stop");
  Case fast = moving;
  fast.request.start_state.velocities["arm7_joint1"] = 50;
  refused(fast, "START_STATE_INVALID", "limit");
  session.set_configurations({{"arm", {{"timing", std::string("none")}}}});
  refused(moving, "PLANNING_FAILED", "timing is 'none'");
  session.set_configurations({{"arm", {{"sample_rate", 100.0}}}});
  refused(moving, "PLANNING_FAILED", "sample_rate");
}

BOOST_AUTO_TEST_CASE(a_start_in_motion_goes_on_with_its_velocity) {
  MoveItSession session(arm_robot());
  Case question;
  const MoveItResponse at_rest = session.solve(question.scene, question.request);
  question.request.start_state.velocities = {{"arm7_joint1", 0.3}, {"arm7_joint2", 0.002}};
  const MoveItResponse moving = session.solve(question.scene, question.request);
  BOOST_REQUIRE(moving.code == Code::success);
  BOOST_TEST(moving.trajectory.velocities(0, 0) == 0.3);
  BOOST_TEST(moving.trajectory.velocities(0, 1) == 0.002);
  BOOST_TEST(moving.trajectory.certificate->proved_free());
  question.request.start_state.velocities = {{"arm7_joint1", 0.009}, {"arm7_joint2", -0.009}};  // noise of sensors
  BOOST_TEST((session.solve(question.scene, question.request).trajectory.positions == at_rest.trajectory.positions));
}

BOOST_AUTO_TEST_CASE(path_constraints_hold_at_every_row_by_the_rules_of_moveit) {
  const auto robot = RobotModel::load(arm7());
  MoveItSession session(arm_robot());
  Case question;
  question.keep_orientation({0.1, 0.1, 7.0});
  question.keep_position(Box{{2.0, 2.0, 0.1}});
  question.add_box("box", {0.32, 0.15, 0.55}, {0.05, 0.05, 0.2});
  const MoveItResponse response = session.solve(question.scene, question.request);
  BOOST_REQUIRE(response.code == Code::success);
  BOOST_TEST(response.trajectory.certificate->constraints.size() == 2u);
  for (Eigen::Index row = 0; row < response.trajectory.positions.rows(); ++row) {
    const Pose hand = robot->compute_fk(response.trajectory.positions.row(row).transpose(), "arm7_hand");
    const Eigen::Matrix3d off = (Eigen::Quaterniond(0, 0, 1, 0).conjugate() * hand.q).toRotationMatrix();
    BOOST_TEST(std::abs(std::atan2(-off(1, 2), off(2, 2))) <= 0.1);
    BOOST_TEST(std::abs(std::asin(off(0, 2))) <= 0.1);
    BOOST_TEST(std::abs(hand.p.z() - 0.45) <= 0.05);
  }
}

BOOST_AUTO_TEST_CASE(files_that_cannot_be_read_are_failures) {
  Case question;
  for (const auto& [part, text] : {std::pair{&MoveItRobot::urdf_text, "<robot"}, {&MoveItRobot::srdf_text, "<robot"}}) {
    MoveItRobot robot = arm_robot();
    robot.*part = text;
    const MoveItResponse response = MoveItSession(robot).solve(question.scene, question.request);
    BOOST_TEST(to_string(response.code) == "FAILURE", response.message);
    BOOST_TEST(!response.message.empty());
  }
}

namespace {

/// A continuous joint, a revolute one, one that mimics it, a slide, and two that are not planned:
///   base ──a── first ──b── second ──c (mimics b)── third ──d── tip;   base ──(kind)── cart
MoveItRobot odd_robot(const std::string& kind) {
  const std::string limit = "<limit lower='-2' upper='2' velocity='2' effort='1'/>";
  std::string urdf = "<robot name='odd'><link name='base'/><link name='cart'/><link name='tip'/>";
  for (const std::string link : {"first", "second", "third"})
    urdf += "<link name='" + link +
            "'><collision><origin xyz='0.15 0 0'/><geometry><box size='0.2 0.04 0.04'/></geometry></collision></link>";
  urdf += robots::joint("a", "continuous", "base", "first", "0 0 0.3", "0 0 1", "<limit velocity='2' effort='1'/>") +
          robots::joint("b", "revolute", "first", "second", "0.3 0 0", "0 1 0", limit) +
          robots::joint("c", "revolute", "second", "third", "0.3 0 0", "0 1 0", limit + "<mimic joint='b'/>") +
          robots::joint("d", "prismatic", "third", "tip", "0.3 0 0", "1 0 0",
                        "<limit lower='0' upper='0.2' velocity='1' effort='1'/>") +
          robots::joint("cart_joint", kind, "base", "cart", "1 1 0", "0 0 1", "") + "</robot>";
  const std::string srdf =
      "<robot name='odd'><group name='listed'><joint name='a'/><joint name='b'/><joint name='c'/><joint name='d'/>"
      "</group><group name='cart'><joint name='cart_joint'/></group></robot>";
  return {urdf, srdf, {}, {}};
}

/// Of the group `listed`, from all joints at 0.
struct OddRequest {
  io::SceneFile scene;
  io::RequestFile request;

  OddRequest() {
    scene.robot_state.joints = {{"a", 0.0}, {"b", 0.0}, {"c", 0.0}, {"d", 0.0}};
    request.group_name = "listed";
    request.goals.resize(1);
    request.goals[0].joints = {{"a", 3.5, 1e-3, 1e-3}, {"b", 0.4, 1e-3, 1e-3}, {"d", 0.1, 1e-3, 1e-3}};
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_group_that_is_a_list_of_joints_of_several_kinds) {
  for (const char* kind : {"planar", "floating"}) {
    MoveItSession session(odd_robot(kind));
    OddRequest odd;
    const MoveItResponse response = session.solve(odd.scene, odd.request);
    BOOST_REQUIRE_MESSAGE(response.code == Code::success, kind << ": " << response.message);
    BOOST_TEST(response.trajectory.joint_names == (std::vector<std::string>{"a", "b", "d"}),
               boost::test_tools::per_element());
    const Eigen::VectorXd last = response.trajectory.positions.bottomRows(1).transpose();
    BOOST_TEST(std::abs(std::remainder(last[0] - 3.5, 2 * M_PI)) < 1e-9);
    BOOST_TEST(response.trajectory.length() < 4.0);
    odd.request.group_name = "cart";
    BOOST_TEST(to_string(session.solve(odd.scene, odd.request).code) == "INVALID_GROUP_NAME");
  }
}

BOOST_AUTO_TEST_CASE(a_goal_for_a_joint_that_mimics_another_is_refused) {
  MoveItSession session(odd_robot("floating"));
  OddRequest odd;
  odd.request.goals[0].joints.push_back({"c", 0.4, 1e-3, 1e-3});
  BOOST_TEST(to_string(session.solve(odd.scene, odd.request).code) == "INVALID_GOAL_CONSTRAINTS");
}

BOOST_AUTO_TEST_CASE(a_joint_that_is_not_planned_must_be_at_rest) {
  MoveItRobot robot = odd_robot("floating");
  robot.srdf_text = "<robot name='odd'><group name='listed'><joint name='a'/><joint name='b'/></group></robot>";
  MoveItSession session(robot);
  OddRequest odd;
  odd.request.goals[0].joints.pop_back();
  BOOST_TEST(to_string(session.solve(odd.scene, odd.request).code) == "SUCCESS");
  odd.request.start_state.velocities["d"] = 0.2;
  const MoveItResponse response = session.solve(odd.scene, odd.request);
  BOOST_TEST(to_string(response.code) == "START_STATE_INVALID");
  BOOST_TEST(response.message.find("'d', which is not planned") != std::string::npos, response.message);
}

BOOST_AUTO_TEST_CASE(limits_of_the_jerk_count_with_the_timing_that_has_them) {
  MoveItRobot robot = odd_robot("floating");
  OddRequest odd;
  const std::map<std::string, OptionMap> ruckig{{"listed", {{"timing", std::string("ruckig")}}}};
  const auto duration = [&] {
    MoveItSession session(robot);
    session.set_configurations(ruckig);
    const MoveItResponse response = session.solve(odd.scene, odd.request);
    BOOST_REQUIRE_MESSAGE(response.code == Code::success, response.message);
    return response.trajectory.duration();
  };
  const double before = duration();
  robot.bounds["a"].jerk = 0.5;
  BOOST_TEST(duration() > 1.5 * before);
}
