// Loads a planning pipeline as MoveIt does and asks it for motions; every answer is checked by MoveIt's own collision
// checker.
//
//   srmp_moveit_check problems DIR PROBLEMS NAMESPACE [joint|pose] [planner_id]
//   srmp_moveit_check behaviour DIR PROBLEMS NAMESPACE
//   srmp_moveit_check arms - - NAMESPACE
//
// DIR holds panda.urdf, panda.srdf and meshes; PROBLEMS is the unpacked problems.tar.bz2; NAMESPACE is that of the
// pipeline's parameters (planning_plugin, request_adapters). In MoveIt 2 the parameters are those of the program's
// node:
// --ros-args --params-file pipelines_humble.yaml.

#include <octomap/octomap.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <iostream>
#include <numeric>
#include <thread>

#include "pipeline.hpp"
#include "scenes.hpp"

using namespace srmp_moveit;

namespace {

using Clock = std::chrono::steady_clock;
using planning_interface::MotionPlanResponse;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// MoveIt's own check of the motion between rows too, in steps of 10 ms.
bool is_free_between_rows(const planning_scene::PlanningScene& scene,
                          const robot_trajectory::RobotTrajectory& trajectory, const std::string& group) {
  auto state = std::make_shared<moveit::core::RobotState>(trajectory.getFirstWayPoint());
  for (double t = 0.0; t < trajectory.getDuration(); t += 0.01) {
    trajectory.getStateAtDurationFromStart(t, state);
    state->update();
    if (scene.isStateColliding(*state, group)) return false;
  }
  return true;
}

bool is_valid(const planning_scene::PlanningScene& scene, const robot_trajectory::RobotTrajectory& trajectory,
              const std::string& group) {
  return scene.isPathValid(trajectory, group) && is_free_between_rows(scene, trajectory, group);
}

double length(const robot_trajectory::RobotTrajectory& trajectory, const std::string& group) {
  const auto* joints = trajectory.getRobotModel()->getJointModelGroup(group);
  double sum = 0.0;
  Eigen::VectorXd before, now;
  for (std::size_t i = 0; i < trajectory.getWayPointCount(); ++i) {
    trajectory.getWayPoint(i).copyJointGroupPositions(joints, now);
    if (i > 0) sum += (now - before).norm();
    before = now;
  }
  return sum;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::string in_ms(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f ms", 1e3 * seconds);
  return text;
}

struct Question {
  planning_scene::PlanningScenePtr scene;
  moveit_messages::MotionPlanRequest request;
};

MotionPlanResponse ask(planning_pipeline::PlanningPipeline& pipeline, const Question& question) {
  MotionPlanResponse response;
  (void)pipeline.generatePlan(question.scene, question.request, response);
  return response;
}

int solve_problems(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model,
                   const std::string& problems, bool pose_goals, const std::string& planner_id) {
  const char* const scenarios[] = {"bookshelf_small", "bookshelf_tall",  "bookshelf_thin", "box", "cage",
                                   "table_pick",      "table_under_pick"};
  int asked = 0, solved = 0, valid_rows = 0, valid = 0;
  std::vector<double> times, lengths;
  for (int number = 1; asked < 50; ++number)
    for (const char* scenario : scenarios) {
      if (asked == 50) break;
      char name[16];
      std::snprintf(name, sizeof name, "%04d.yaml", number);
      const std::string directory = problems + "/" + scenario + "_panda/";
      Question question{read_scene(directory + "scene" + name, model), read_request(directory + "request" + name)};
      const std::string group = question.request.group_name;
      if (pose_goals) question.request = with_pose_goal(question.request, *question.scene);
      question.request.planner_id = planner_id;
      ++asked;
      const auto start = Clock::now();
      const MotionPlanResponse response = ask(pipeline, question);
      const double time = seconds_since(start);
      if (!is_solved(response)) {
        std::cout << scenario << ' ' << number << ": error code " << code_of(response) << '\n';
        continue;
      }
      ++solved;
      times.push_back(time);
      lengths.push_back(length(*trajectory_of(response), group));
      valid_rows += question.scene->isPathValid(*trajectory_of(response), group);
      valid += is_valid(*question.scene, *trajectory_of(response), group);
    }
  const double mean_length = std::accumulate(lengths.begin(), lengths.end(), 0.0) / std::max<double>(1, lengths.size());
  std::cout << "solved " << solved << " of " << asked << "; PlanningScene::isPathValid accepts " << valid_rows
            << ", free every 10 ms too " << valid << "; median " << in_ms(median(times)) << ", slowest "
            << in_ms(times.empty() ? 0.0 : *std::max_element(times.begin(), times.end())) << ", mean length "
            << mean_length << " rad\n";
  return valid == solved ? 0 : 1;
}

int failures = 0;

void expect(bool holds, const std::string& what) {
  std::cout << (holds ? "ok    " : "FAULT ") << what << '\n';
  failures += !holds;
}

moveit_messages::AttachedCollisionObject rod_of(double length) {
  moveit_messages::AttachedCollisionObject rod;
  rod.link_name = "panda_hand";
  rod.touch_links = {"panda_hand", "panda_leftfinger", "panda_rightfinger"};
  rod.object.id = "rod";
  rod.object.header.frame_id = "panda_hand";
  rod.object.operation = rod.object.ADD;
  rod.object.pose.orientation.w = 1.0;
  rod.object.pose.position.z = 0.1 + length / 2;
  rod.object.primitives.resize(1);
  rod.object.primitives[0].type = rod.object.primitives[0].BOX;
  rod.object.primitives[0].dimensions = {0.02, 0.02, length};
  rod.object.primitive_poses.resize(1);
  rod.object.primitive_poses[0].orientation.w = 1.0;
  return rod;
}

Eigen::Vector3d goal_position(const Question& question, const std::string& link) {
  moveit::core::RobotState state = *question.scene->getCurrentStateUpdated(question.request.start_state);
  for (const auto& joint : question.request.goal_constraints.at(0).joint_constraints)
    state.setVariablePosition(joint.joint_name, joint.position);
  state.update();
  return state.getGlobalLinkTransform(link).translation();
}

/// A turn of the first joint with the arm stretched out to the front.
Question turn(const moveit::core::RobotModelPtr& model) {
  Question question{std::make_shared<planning_scene::PlanningScene>(model), moveit_messages::MotionPlanRequest()};
  auto& request = question.request;
  request.group_name = "panda_arm";
  request.allowed_planning_time = 5.0;
  request.start_state.is_diff = true;
  request.goal_constraints.resize(1);
  const double positions[] = {-0.8, 0.3, 0.0, -1.6, 0.0, 1.9, 0.785};
  for (int i = 0; i < 7; ++i) {
    const std::string joint = "panda_joint" + std::to_string(i + 1);
    request.start_state.joint_state.name.push_back(joint);
    request.start_state.joint_state.position.push_back(positions[i]);
    moveit_messages::JointConstraint constraint;
    constraint.joint_name = joint;
    constraint.position = i == 0 ? 0.8 : positions[i];
    constraint.tolerance_above = constraint.tolerance_below = 1e-4;
    constraint.weight = 1.0;
    request.goal_constraints[0].joint_constraints.push_back(constraint);
  }
  return question;
}

void check_scenes(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  using Codes = moveit_messages::MoveItErrorCodes;
  Question question = turn(model);
  const auto free = ask(pipeline, question);
  expect(is_solved(free), "a turn in an empty scene");
  const Eigen::Vector3d goal = goal_position(question, "panda_hand");
  add_box(*question.scene, "box in the way", {std::hypot(goal.x(), goal.y()), 0, goal.z()}, {0.1, 0.1, 0.4});
  const auto around = ask(pipeline, question);
  expect(is_solved(around) && is_valid(*question.scene, *trajectory_of(around), "panda_arm") &&
             length(*trajectory_of(around), "panda_arm") > length(*trajectory_of(free), "panda_arm") + 0.05,
         "a box in the way: another path, free by MoveIt's check");
  question.scene->getWorldNonConst()->clearObjects();
  add_box(*question.scene, "box around the goal", goal, {0.2, 0.2, 0.2});
  expect(code_of(ask(pipeline, question)) == Codes::GOAL_IN_COLLISION, "a box around the goal: GOAL_IN_COLLISION");
  question.scene->getWorldNonConst()->clearObjects();
  expect(is_solved(ask(pipeline, question)), "without it again: a path");

  add_box(*question.scene, "low table", {goal.x(), goal.y(), goal.z() - 0.4}, {0.3, 0.3, 0.05});
  expect(is_solved(ask(pipeline, question)), "a table below the goal: a path");
  question.scene->processAttachedCollisionObjectMsg(rod_of(0.3));
  expect(code_of(ask(pipeline, question)) == Codes::GOAL_IN_COLLISION,
         "a rod of 30 cm in the hand reaches into the table: GOAL_IN_COLLISION");
  question.scene->getCurrentStateNonConst().clearAttachedBodies();
  set_padding(*question.scene, 0.3);
  expect(code_of(ask(pipeline, question)) == Codes::GOAL_IN_COLLISION, "links padded by 30 cm: GOAL_IN_COLLISION");
  set_padding(*question.scene, 0.0);
  expect(is_solved(ask(pipeline, question)), "without rod and padding: a path");
}

/// What a request may say, and with which code it is refused.
void check_requests(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  using Codes = moveit_messages::MoveItErrorCodes;
  const auto code_after = [&](const std::function<void(Question&)>& change) {
    Question question = turn(model);
    change(question);
    return code_of(ask(pipeline, question));
  };
  const auto expect_code = [&](int code, const std::string& what, const std::function<void(Question&)>& change) {
    const int got = code_after(change);
    expect(got == code, what + ": error code " + std::to_string(got));
  };
  const auto start = [](Question& q) -> moveit_messages::RobotState& { return q.request.start_state; };
  expect_code(Codes::INVALID_GROUP_NAME, "no such group", [](Question& q) { q.request.group_name = "panda_leg"; });
  expect_code(Codes::PLANNING_FAILED, "no such planner", [](Question& q) { q.request.planner_id = "wPASEE"; });
  expect_code(Codes::SUCCESS, "a configuration with a list and a small number",
              [](Question& q) { q.request.planner_id = "fine"; });
  expect_code(Codes::TIMED_OUT, "a microsecond", [](Question& q) { q.request.allowed_planning_time = 1e-6; });
  expect_code(Codes::START_STATE_INVALID, "a start with a joint that is none",
              [&](Question& q) { start(q).joint_state.name[0] = "panda_joint9"; });
  expect_code(Codes::INVALID_ROBOT_STATE, "a start with too few positions",
              [&](Question& q) { start(q).joint_state.position.pop_back(); });
  expect_code(Codes::START_STATE_INVALID, "a start faster than its limit", [&](Question& q) {
    start(q).joint_state.velocity.assign(7, 0.0);
    start(q).joint_state.velocity[0] = 50.0;
  });
  expect_code(Codes::START_STATE_INVALID, "a base that moves", [&](Question& q) {
    start(q).multi_dof_joint_state.twist.resize(1);
    start(q).multi_dof_joint_state.twist[0].linear.x = 0.5;
  });
  const auto attach = [&](Question& q, const std::string& link, const std::string& frame) {
    start(q).attached_collision_objects = {rod_of(0.05)};
    start(q).attached_collision_objects[0].link_name = link;
    start(q).attached_collision_objects[0].object.header.frame_id = frame;
  };
  expect_code(Codes::SUCCESS, "a start that holds a rod", [&](Question& q) { attach(q, "panda_hand", "panda_hand"); });
  expect_code(Codes::INVALID_LINK_NAME, "a rod on a link that is none",
              [&](Question& q) { attach(q, "panda_hnad", "panda_hand"); });
  expect_code(Codes::FRAME_TRANSFORM_FAILURE, "a rod in a frame that is none",
              [&](Question& q) { attach(q, "panda_hand", "moon"); });
  const auto at_goal = [&](Question& q) { return goal_position(q, "panda_hand"); };
  expect_code(Codes::GOAL_IN_COLLISION, "an octomap with a cell at the goal", [&](Question& q) {
    const auto tree = std::make_shared<octomap::OcTree>(0.05);
    const Eigen::Vector3d goal = at_goal(q);
    tree->updateNode(octomap::point3d(goal.x(), goal.y(), goal.z()), true);
    q.scene->processOctomapPtr(tree, Eigen::Isometry3d::Identity());
  });
  expect_code(Codes::SUCCESS, "a box at the goal that may be touched", [&](Question& q) {
    add_box(*q.scene, "box", at_goal(q), {0.1, 0.1, 0.1});
    q.scene->getAllowedCollisionMatrixNonConst().setDefaultEntry("box", true);
  });
}

/// The hand keeps its direction, or goes on with its velocity.
void check_motions(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  Question question = turn(model);
  const moveit::core::RobotState state = *question.scene->getCurrentStateUpdated(question.request.start_state);
  moveit_messages::OrientationConstraint upright;
  upright.header.frame_id = question.scene->getPlanningFrame();
  upright.link_name = "panda_hand";
  upright.orientation = tf2::toMsg(Eigen::Quaterniond(state.getFrameTransform("panda_hand").rotation()));
  upright.absolute_x_axis_tolerance = upright.absolute_y_axis_tolerance = 0.1;
  upright.absolute_z_axis_tolerance = 7.0;
  upright.weight = 1.0;
  Question constrained = question;
  constrained.request.path_constraints.orientation_constraints = {upright};
  const auto kept = ask(pipeline, constrained);
  expect(is_solved(kept) &&
             question.scene->isPathValid(*trajectory_of(kept), constrained.request.path_constraints, "panda_arm"),
         "a path constraint: the hand keeps its tilt, by MoveIt's check");

  question.request.start_state.joint_state.velocity.assign(7, 0.0);
  question.request.start_state.joint_state.velocity[1] = 0.3;
  const auto moving = ask(pipeline, question);
  expect(is_solved(moving) && is_valid(*question.scene, *trajectory_of(moving), "panda_arm") &&
             trajectory_of(moving)->getFirstWayPoint().getVariableVelocity("panda_joint2") == 0.3,
         "a start in motion: the trajectory begins with its velocity");
}

void check_planners(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  std::vector<std::string> ids;
  pipeline.getPlannerManager()->getPlanningAlgorithms(ids);
  for (const std::string& id : ids) {
    if (id.find('[') != std::string::npos) continue;  // configurations of these planners
    Question question = turn(model);
    add_box(*question.scene, "box", {0.55, 0, 0.3}, {0.05, 0.05, 0.6});
    question.request.planner_id = id;
    const auto response = ask(pipeline, question);
    const bool several = id == "xECBS" || id == "ECBS" || id == "CBS" || id == "prioritised" || id == "prioritized";
    if (several)
      expect(!is_solved(response), "planner " + id + " is for several arms: refused");
    else
      expect(is_solved(response) && is_valid(*question.scene, *trajectory_of(response), "panda_arm"),
             "planner " + id + ": error code " + std::to_string(code_of(response)));
  }
}

void check_termination(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  Question question = turn(model);
  add_box(*question.scene, "box", {0.55, 0, 0.3}, {0.05, 0.05, 0.6});
  question.request.planner_id = "slow";
  question.request.allowed_planning_time = 60.0;
  std::vector<double> latencies;
  for (int i = 0; i < 20; ++i) {
    Clock::time_point stopped;
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(200 + 10 * i));
      stopped = Clock::now();
      pipeline.terminate();
    });
    const auto response = ask(pipeline, question);
    const Clock::time_point ended = Clock::now();
    other.join();
    if (code_of(response) != moveit_messages::MoveItErrorCodes::PREEMPTED)
      return expect(false, "terminated: error code " + std::to_string(code_of(response)));
    latencies.push_back(std::chrono::duration<double>(ended - stopped).count());
  }
  const double slowest = *std::max_element(latencies.begin(), latencies.end());
  expect(slowest < 0.02, "terminated 20 times from another thread: ended after " + in_ms(median(latencies)) +
                             " (median), " + in_ms(slowest) + " (slowest)");
}

void check_stages(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  Question question = turn(model);
  moveit_messages::MoveItErrorCodes code;
  const auto context = pipeline.getPlannerManager()->getPlanningContext(question.scene, question.request, code);
  planning_interface::MotionPlanDetailedResponse response;
  context->solve(response);
  std::string stages;
  for (std::size_t i = 0; i < descriptions_of(response).size(); ++i)
    stages += (i ? "; " : "") + descriptions_of(response)[i] + " " + in_ms(processing_times_of(response)[i]);
  expect(is_solved(response) && trajectory_of(response).size() == 2, "the detailed answer has the stages: " + stages);
}

/// Two arms, each to where the other one is: both turn through the space between them.
Question cross(const moveit::core::RobotModelPtr& model, const std::string& planner_id) {
  Question question{std::make_shared<planning_scene::PlanningScene>(model), moveit_messages::MotionPlanRequest()};
  auto& request = question.request;
  request.group_name = "both";
  request.planner_id = planner_id;
  request.allowed_planning_time = 10.0;
  request.start_state.is_diff = true;
  request.goal_constraints.resize(1);
  for (const std::string side : {"left", "right"})
    for (int i = 1; i < 4; ++i) {
      const double sign = side == "left" ? 1.0 : -1.0;
      request.start_state.joint_state.name.push_back(side + "_joint" + std::to_string(i));
      request.start_state.joint_state.position.push_back(i == 1 ? sign : 0.0);
      moveit_messages::JointConstraint constraint;
      constraint.joint_name = request.start_state.joint_state.name.back();
      constraint.position = i == 1 ? -0.7 * sign : i == 2 ? 1.4 * sign : 0.3;
      constraint.tolerance_above = constraint.tolerance_below = 1e-4;
      constraint.weight = 1.0;
      request.goal_constraints[0].joint_constraints.push_back(constraint);
    }
  return question;
}

/// The link stays within `radius` of a point of the planning frame.
moveit_messages::PositionConstraint within_sphere(const planning_scene::PlanningScene& scene, const std::string& link,
                                                  const Eigen::Vector3d& center, double radius) {
  moveit_messages::PositionConstraint position;
  position.header.frame_id = scene.getPlanningFrame();
  position.link_name = link;
  position.constraint_region.primitives.resize(1);
  position.constraint_region.primitives[0].type = shape_messages::SolidPrimitive::SPHERE;
  position.constraint_region.primitives[0].dimensions = {radius};
  position.constraint_region.primitive_poses.resize(1);
  position.constraint_region.primitive_poses[0].position = tf2::toMsg(center);
  position.constraint_region.primitive_poses[0].orientation.w = 1.0;
  position.weight = 1.0;
  return position;
}

/// The goal of `cross` as positions of both arms' last links.
Question cross_by_position(const moveit::core::RobotModelPtr& model, const std::string& planner_id) {
  Question question = cross(model, planner_id);
  auto& goal = question.request.goal_constraints[0];
  for (const std::string link : {"left_lower", "right_lower"}) {
    const Eigen::Vector3d at = goal_position(question, link);
    goal.position_constraints.push_back(within_sphere(*question.scene, link, at, 0.01));
  }
  goal.joint_constraints.clear();
  return question;
}

void check_arms(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  using Codes = moveit_messages::MoveItErrorCodes;
  const auto expect_motion = [&](const Question& question, const std::string& what) {
    const auto start = Clock::now();
    const auto response = ask(pipeline, question);
    const double time = seconds_since(start);
    expect(is_solved(response) && is_valid(*question.scene, *trajectory_of(response), "both") &&
               question.scene->isPathValid(*trajectory_of(response), question.request.path_constraints,
                                           question.request.goal_constraints, "both"),
           what + ", by MoveIt's check, " + in_ms(time) + ", error code " + std::to_string(code_of(response)));
  };
  for (const char* id : {"xECBS", "ECBS", "CBS", "prioritised", "auto", "RRTConnect", "wPASE"})
    expect_motion(cross(model, id), std::string("two arms by ") + id + ": one trajectory of 6 joints to the goal");
  expect_motion(cross_by_position(model, "xECBS"), "two arms by xECBS to positions of their last links");

  Question box = cross(model, "xECBS");
  add_box(*box.scene, "box", {0.9, 0.0, 0.0}, {0.1, 0.1, 0.1});
  expect_motion(box, "two arms by xECBS around a box between them");
  Question around_goal = cross(model, "xECBS");
  add_box(*around_goal.scene, "box", goal_position(around_goal, "left_lower"), {0.1, 0.1, 0.1});
  expect(code_of(ask(pipeline, around_goal)) == Codes::GOAL_IN_COLLISION,
         "two arms, a box around the goal of one: GOAL_IN_COLLISION");

  Question constrained = cross(model, "xECBS");
  constrained.request.path_constraints.position_constraints = {
      within_sphere(*constrained.scene, "left_lower", Eigen::Vector3d::Zero(), 2.0)};
  expect(code_of(ask(pipeline, constrained)) == Codes::PLANNING_FAILED,
         "two arms by xECBS with a path constraint: refused");
  constrained.request.planner_id = "auto";
  expect_motion(constrained, "two arms by auto with a path constraint");
}

/// What the plugin costs beside plan: the same request in an unchanged scene.
void time_unchanged(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model,
                    const std::string& problems) {
  Question question{read_scene(problems + "/bookshelf_small_panda/scene0001.yaml", model),
                    read_request(problems + "/bookshelf_small_panda/request0001.yaml")};
  std::vector<double> total, plan;
  for (int i = 0; i < 50; ++i) {
    const auto context = pipeline.getPlannerManager()->getPlanningContext(question.scene, question.request);
    planning_interface::MotionPlanDetailedResponse response;
    const auto start = Clock::now();
    context->solve(response);
    total.push_back(seconds_since(start));
    plan.push_back(std::accumulate(processing_times_of(response).begin(), processing_times_of(response).end(), 0.0));
  }
  std::cout << "the same request 50 times, bookshelf_small 1: median " << in_ms(median(total))
            << " in the plugin, of it " << in_ms(median(plan)) << " in plan\n";
}

}  // namespace

int main(int argc, char** argv) try {
  start_node(argc, argv);
  if (argc < 5) throw std::runtime_error("see the comment at the head of check.cpp");
  const std::string mode = argv[1], directory = argv[2], problems = argv[3], name_space = argv[4];
  const auto model = mode == "arms" ? load_two_arms() : load_panda(directory);
  const auto made = make_pipeline(model, name_space);
  planning_pipeline::PlanningPipeline& pipeline = *made;
  pipeline.displayComputedMotionPlans(false);
  pipeline.checkSolutionPaths(false);  // done here
  if (mode == "problems")
    return solve_problems(pipeline, model, problems, argc < 6 || std::string(argv[5]) == "pose",
                          argc > 6 ? argv[6] : "");
  if (mode == "arms") {
    check_arms(pipeline, model);
    return failures;
  }
  check_scenes(pipeline, model);
  check_requests(pipeline, model);
  check_motions(pipeline, model);
  check_planners(pipeline, model);
  check_termination(pipeline, model);
  check_stages(pipeline, model);
  time_unchanged(pipeline, model, problems);
  return failures;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 2;
}
