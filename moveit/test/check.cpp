// Loads a planning pipeline as MoveIt does and asks it for motions; every answer is checked by MoveIt's own collision
// checker.
//
//   srmp_moveit_check problems DIR PROBLEMS NAMESPACE [joint|pose] [planner_id]
//   srmp_moveit_check behaviour DIR PROBLEMS NAMESPACE
//   srmp_moveit_check arms - - NAMESPACE
//
// DIR holds panda.urdf, panda.srdf and meshes; PROBLEMS is the unpacked problems.tar.bz2; NAMESPACE is that of the
// pipeline's parameters (planning_plugin, request_adapters).

#include <moveit/planning_pipeline/planning_pipeline.h>
#include <ros/ros.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <numeric>
#include <thread>

#include "scenes.hpp"

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
  moveit_msgs::MotionPlanRequest request;
};

MotionPlanResponse ask(planning_pipeline::PlanningPipeline& pipeline, const Question& question) {
  MotionPlanResponse response;
  pipeline.generatePlan(question.scene, question.request, response);
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
      if (!response.error_code_) {
        std::cout << scenario << ' ' << number << ": error code " << response.error_code_.val << '\n';
        continue;
      }
      ++solved;
      times.push_back(time);
      lengths.push_back(length(*response.trajectory_, group));
      valid_rows += question.scene->isPathValid(*response.trajectory_, group);
      valid += is_valid(*question.scene, *response.trajectory_, group);
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

void attach_rod(planning_scene::PlanningScene& scene, double length) {
  moveit_msgs::AttachedCollisionObject rod;
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
  scene.processAttachedCollisionObjectMsg(rod);
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
  Question question{std::make_shared<planning_scene::PlanningScene>(model), {}};
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
    moveit_msgs::JointConstraint constraint;
    constraint.joint_name = joint;
    constraint.position = i == 0 ? 0.8 : positions[i];
    constraint.tolerance_above = constraint.tolerance_below = 1e-4;
    constraint.weight = 1.0;
    request.goal_constraints[0].joint_constraints.push_back(constraint);
  }
  return question;
}

void check_scenes(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  using Codes = moveit_msgs::MoveItErrorCodes;
  Question question = turn(model);
  const auto free = ask(pipeline, question);
  expect(bool(free.error_code_), "a turn in an empty scene");
  const Eigen::Vector3d goal = goal_position(question, "panda_hand");
  add_box(*question.scene, "box in the way", {std::hypot(goal.x(), goal.y()), 0, goal.z()}, {0.1, 0.1, 0.4});
  const auto around = ask(pipeline, question);
  expect(bool(around.error_code_) && is_valid(*question.scene, *around.trajectory_, "panda_arm") &&
             length(*around.trajectory_, "panda_arm") > length(*free.trajectory_, "panda_arm") + 0.05,
         "a box in the way: another path, free by MoveIt's check");
  question.scene->getWorldNonConst()->clearObjects();
  add_box(*question.scene, "box around the goal", goal, {0.2, 0.2, 0.2});
  expect(ask(pipeline, question).error_code_.val == Codes::GOAL_IN_COLLISION,
         "a box around the goal: GOAL_IN_COLLISION");
  question.scene->getWorldNonConst()->clearObjects();
  expect(bool(ask(pipeline, question).error_code_), "without it again: a path");

  add_box(*question.scene, "low table", {goal.x(), goal.y(), goal.z() - 0.4}, {0.3, 0.3, 0.05});
  expect(bool(ask(pipeline, question).error_code_), "a table below the goal: a path");
  attach_rod(*question.scene, 0.3);
  expect(ask(pipeline, question).error_code_.val == Codes::GOAL_IN_COLLISION,
         "a rod of 30 cm in the hand reaches into the table: GOAL_IN_COLLISION");
  question.scene->getCurrentStateNonConst().clearAttachedBodies();
  const auto set_padding = [&](double padding) {
    question.scene->getCollisionEnvNonConst()->setPadding(padding);
    question.scene->propogateRobotPadding();
  };
  set_padding(0.3);
  expect(ask(pipeline, question).error_code_.val == Codes::GOAL_IN_COLLISION,
         "links padded by 30 cm: GOAL_IN_COLLISION");
  set_padding(0.0);
  expect(bool(ask(pipeline, question).error_code_), "without rod and padding: a path");
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
      expect(!response.error_code_, "planner " + id + " is for several arms: refused");
    else
      expect(bool(response.error_code_) && is_valid(*question.scene, *response.trajectory_, "panda_arm"),
             "planner " + id + ": error code " + std::to_string(response.error_code_.val));
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
    if (response.error_code_.val != moveit_msgs::MoveItErrorCodes::PREEMPTED)
      return expect(false, "terminated: error code " + std::to_string(response.error_code_.val));
    latencies.push_back(std::chrono::duration<double>(ended - stopped).count());
  }
  const double slowest = *std::max_element(latencies.begin(), latencies.end());
  expect(slowest < 0.02, "terminated 20 times from another thread: ended after " + in_ms(median(latencies)) +
                             " (median), " + in_ms(slowest) + " (slowest)");
}

void check_stages(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  Question question = turn(model);
  moveit_msgs::MoveItErrorCodes code;
  const auto context = pipeline.getPlannerManager()->getPlanningContext(question.scene, question.request, code);
  planning_interface::MotionPlanDetailedResponse response;
  const bool solved = context->solve(response);
  std::string stages;
  for (std::size_t i = 0; i < response.description_.size(); ++i)
    stages += (i ? "; " : "") + response.description_[i] + " " + in_ms(response.processing_time_[i]);
  expect(solved && response.trajectory_.size() == 2, "the detailed answer has the stages: " + stages);
}

/// Two arms, each to where the other one is: both turn through the space between them.
void check_arms(planning_pipeline::PlanningPipeline& pipeline, const moveit::core::RobotModelPtr& model) {
  for (const char* id : {"xECBS", "ECBS", "auto"}) {
    Question question{std::make_shared<planning_scene::PlanningScene>(model), {}};
    auto& request = question.request;
    request.group_name = "both";
    request.planner_id = id;
    request.allowed_planning_time = 10.0;
    request.start_state.is_diff = true;
    request.goal_constraints.resize(1);
    for (const std::string side : {"left", "right"})
      for (int i = 1; i < 4; ++i) {
        const double sign = side == "left" ? 1.0 : -1.0;
        const double goal = i == 1 ? -0.7 * sign : i == 2 ? 1.4 * sign : 0.3;
        request.start_state.joint_state.name.push_back(side + "_joint" + std::to_string(i));
        request.start_state.joint_state.position.push_back(i == 1 ? sign : 0.0);
        moveit_msgs::JointConstraint constraint;
        constraint.joint_name = request.start_state.joint_state.name.back();
        constraint.position = goal;
        constraint.tolerance_above = constraint.tolerance_below = 1e-4;
        constraint.weight = 1.0;
        request.goal_constraints[0].joint_constraints.push_back(constraint);
      }
    const auto start = Clock::now();
    const auto response = ask(pipeline, question);
    const double time = seconds_since(start);
    expect(bool(response.error_code_) && is_valid(*question.scene, *response.trajectory_, "both"),
           std::string("two arms by ") + id + ": one trajectory of 6 joints, free by MoveIt's check, " + in_ms(time));
  }
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
    plan.push_back(std::accumulate(response.processing_time_.begin(), response.processing_time_.end(), 0.0));
  }
  std::cout << "the same request 50 times, bookshelf_small 1: median " << in_ms(median(total))
            << " in the plugin, of it " << in_ms(median(plan)) << " in plan\n";
}

}  // namespace

int main(int argc, char** argv) try {
  ros::init(argc, argv, "srmp_moveit_check", ros::init_options::AnonymousName);
  if (argc < 5) throw std::runtime_error("see the comment at the head of check.cpp");
  const std::string mode = argv[1], directory = argv[2], problems = argv[3], name_space = argv[4];
  const auto model = mode == "arms" ? load_two_arms() : load_panda(directory);
  planning_pipeline::PlanningPipeline pipeline(model, ros::NodeHandle(name_space));
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
  check_planners(pipeline, model);
  check_termination(pipeline, model);
  check_stages(pipeline, model);
  time_unchanged(pipeline, model, problems);
  return failures;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 2;
}
