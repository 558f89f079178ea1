#include "srmp/facade/problem_file.hpp"

#include <algorithm>
#include <filesystem>

#include "srmp/io/scene_archive.h"
#include "srmp/io/trajectory_archive.h"
#include "srmp/planning/obstacles/moving_obstacles.hpp"
#include "srmp/planning/options/registry.hpp"
#include "srmp/planning/statistics_fields.hpp"
#include "srmp/trajectory/joint_torques.hpp"

namespace srmp {

namespace {

const std::vector<std::string> formats{io::problem_format, io::scene_format};

struct PlannerText {
  std::vector<std::string> robots;
  OptionMap options;
};

template <class Motion>
struct ResultText {
  PlanStatistics statistics;
  std::optional<Motion> motion;
};
using Motions = std::map<std::string, Trajectory>;

/// One that the options ask for and that is not of this library; "" = there is none.
std::string foreign_heuristic(const PlannerOptions& options) {
  const auto& known = built_in_heuristics();
  for (const std::string& name : named_heuristics(options))
    if (std::find(known.begin(), known.end(), name) == known.end() && !bfs_cell(name)) return name;
  return "";
}

PlannerText planner_text(const std::vector<std::string>& robots, const PlannerOptions& options) {
  PlannerText text{robots, to_map(options)};
  if (const std::string name = foreign_heuristic(options); !name.empty())
    throw InvalidArgument("the planner of " + quoted_list(robots) + " uses the heuristic '" + name +
                          "' of yours, a function, which no file can hold; choose a built-in one with make_planner, "
                          "or save the scene alone with save_scene");
  // The working directory may be another one by the time it is read.
  for (auto& [key, value] : text.options)
    if (key.starts_with("mprim_path"))
      if (auto& path = std::get<std::string>(value); !path.empty()) path = std::filesystem::absolute(path).string();
  return text;
}

}  // namespace

std::vector<std::string> planner_key(const Scene& scene, std::vector<std::string> robots) {
  if (robots.empty()) throw InvalidArgument("make_planner needs at least one robot name");
  for (const std::string& name : robots) scene.robot(name);
  std::sort(robots.begin(), robots.end());
  if (const auto twin = std::adjacent_find(robots.begin(), robots.end()); twin != robots.end())
    throw InvalidArgument("robot '" + *twin + "' is named twice");
  return robots;
}

void require_planner_for(const std::vector<std::string>& robots, const PlannerOptions& options) {
  const PlannerInfo& info = registered_planner(options).info;
  if (robots.size() > 1 && !info.many_robots)
    throw InvalidArgument("planner '" + info.id + "' plans for one robot, but " + std::to_string(robots.size()) +
                          " were named; use 'xECBS' for many");
}

namespace {

/// Throws InvalidArgument unless the targets suit the joints, and planned joints move the links.
void require_goal(const RobotModel& model, const GoalConstraint& goal, const std::string& robot) {
  const std::string what = "goal of '" + robot + "'";
  if (goal.type == GoalType::joints)
    for (const Eigen::VectorXd& target : goal.targets) model.require_configuration(target, what);
  if (goal.type != GoalType::pose && goal.type != GoalType::position) return;
  if (goal.links.empty()) model.link_or_end_effector("");
  for (const std::string& link : goal.links)
    if (model.link_support(model.link_index(link)) == 0)
      throw InvalidArgument(what + ": no planned joint moves the link '" + link + "'");
}

}  // namespace

void require_request(const Scene& scene, const std::string& robot, ConstVector start,
                     const std::vector<GoalConstraint>& goals) {
  const RobotModel& model = *scene.robot(robot).model;
  if (goals.empty()) throw InvalidArgument("plan needs at least one goal");
  for (const GoalConstraint& goal : goals) {
    goal.validate();
    if (goal.targets.empty())
      throw InvalidArgument("a goal of type '" + std::string(to_string(goal.type)) + "' is for plan_multi");
    require_goal(model, goal, robot);
  }
  model.require_configuration(start, "start of '" + robot + "'");
}

void require_multi_request(const Scene& scene, const MultiPlanRequest& request) {
  for (const auto& [name, start] : request.starts) scene.robot(name);  // throws with the nearest name
  for (const auto& [name, goal] : request.goals) {
    scene.robot(name);
    if (!request.starts.contains(name)) throw InvalidArgument("robot '" + name + "' has a goal but no start");
  }
  for (const auto& [name, motion] : request.obstacles) scene.robot(name);
  for (const auto& [name, constraints] : request.constraints) {
    scene.robot(name);
    if (!request.starts.contains(name)) throw InvalidArgument("robot '" + name + "' has path constraints but no start");
  }
  if (request.starts.empty()) throw InvalidArgument("plan_multi needs the start of at least one robot");
  bool one_moves = false;
  for (const auto& [name, start] : request.starts) {
    const RobotModel& model = *scene.robot(name).model;
    model.require_configuration(start, "start of '" + name + "'");
    const auto found = request.goals.find(name);
    if (found == request.goals.end()) continue;
    const GoalConstraint& goal = found->second;
    goal.validate();
    one_moves |= goal.type != GoalType::hold;
    require_goal(model, goal, name);
  }
  if (!one_moves)
    throw InvalidArgument(
        "plan_multi has nothing to plan: every robot with a start holds; one moves when it has a goal to reach, or one "
        "of type 'any'");
}

namespace io {

template <>
std::string current_name<GoalType>(const std::string& name) {
  return name == "aside" ? "any" : name;
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, GoalConstraint> goal) {
  archive("type", goal.type);
  archive("targets", goal.targets);
  archive("position_tolerance", goal.position_tolerance.axes);
  archive("rotation_tolerance", goal.rotation_tolerance.axes);
  describe_list(archive, "links", goal.links);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, PathConstraint> constraint) {
  archive("type", constraint.type);
  archive("link", constraint.link);
  archive("frame", constraint.frame);
  archive("target", constraint.target);
  archive("axis", constraint.axis);
  archive("point", constraint.point);
  archive("position_tolerance", constraint.position_tolerance.axes);
  archive("rotation_tolerance", constraint.rotation_tolerance.axes);
  archive("tolerance", constraint.tolerance);
  archive("min_distance", constraint.min_distance);
  archive("max_distance", constraint.max_distance);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, PlanRequest> request) {
  archive("robot", request.robot);
  archive("start", request.start);
  archive("goals", request.goals);
  describe_list(archive, "constraints", request.constraints);
  const auto describe_some = [&](const char* name, auto& values) {
    if constexpr (Archive::reading) {
      if (archive.has(name)) archive(name, values);
    } else if (values.size()) {
      archive(name, values);
    }
  };
  describe_some("start_velocity", request.start_velocity);
  describe_some("start_acceleration", request.start_acceleration);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, MultiPlanRequest> request) {
  archive("starts", request.starts);
  archive("goals", request.goals);
  archive("obstacles", request.obstacles);
  describe_list(archive, "constraints", request.constraints);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Solution> solution) {
  archive("time_s", solution.time_s);
  archive("cost_rad", solution.cost_rad);
  archive("bound", solution.bound);
  archive("graph", solution.graph);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, PlanStatistics> statistics) {
  const auto describe_field = [&](const char* name, auto& field) { archive(name, field); };
  for_each_field(statistics, describe_field);
  bool many{};
  if constexpr (Archive::reading)
    many = archive.has("robot_cost_rad");
  else
    many = !statistics.robot_cost_rad.empty();
  if (many) for_each_multi_field(statistics, describe_field);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, ResultText<Trajectory>> result) {
  archive("statistics", result.statistics);
  archive("trajectory", result.motion);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, ResultText<Motions>> result) {
  archive("statistics", result.statistics);
  archive("trajectories", result.motion);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, PlannerText> planner) {
  archive("robots", planner.robots);
  archive("options", planner.options);
}

}  // namespace io

namespace {

ResultText<Trajectory> result_text(const PlanResult& result) {
  return {result.statistics(), result.solved() ? std::optional(result.trajectory()) : std::nullopt};
}

ResultText<Motions> result_text(const MultiPlanResult& result) {
  return {result.statistics(), result.solved() ? std::optional(result.trajectory().robots) : std::nullopt};
}

}  // namespace

void save_problem(const Problem& problem, const std::string& path) {
  std::vector<PlannerText> planners;
  for (const auto& [robots, options] : problem.planners) planners.push_back(planner_text(robots, options));
  io::JsonWriter writer(io::problem_format);
  writer("scene", io::SceneText{problem.scene});
  writer("planners", planners);
  if (!problem.motion_limits.empty()) writer("motion_limits", problem.motion_limits);
  if (problem.request) std::visit([&](const auto& request) { writer("request", request); }, *problem.request);
  if (problem.result) std::visit([&](const auto& result) { writer("result", result_text(result)); }, *problem.result);
  writer.save(path);
}

namespace {

/// There are none where no limits were set.
void read_limits(io::JsonReader& root, Problem& problem) {
  if (!root.has("motion_limits")) return;
  root("motion_limits", problem.motion_limits);
  root.inner("motion_limits").guarded([&] {
    for (const auto& [robot, limits] : problem.motion_limits) {
      const RobotModel& model = *problem.scene.robot(robot).model;
      require_limits(limits, model.joint_names());
      require_bounds_of_robot(limits, model);
      if (limits.continuous != default_limits(model).continuous)
        throw InvalidArgument("the continuous joints of '" + robot + "' are not those of its model");
    }
  });
}

PlanRequest read_single_request(io::JsonReader& reader, const Scene& scene) {
  PlanRequest request;
  describe(reader, request);
  reader.guarded([&] { require_request(scene, request.robot, request.start, request.goals); });
  return request;
}

MultiPlanRequest read_multi_request(io::JsonReader& reader, const Scene& scene) {
  MultiPlanRequest request;
  describe(reader, request);
  reader.guarded([&] {
    require_multi_request(scene, request);
    Scene at_ends = scene;
    stand_at_ends(at_ends, request.starts, request.obstacles, {});
  });
  return request;
}

std::optional<LastRequest> read_request(io::JsonReader& root, const Scene& scene) {
  if (!root.has("request")) return std::nullopt;
  io::JsonReader reader = root.inner("request");
  if (!reader.has("robot") && !reader.has("starts"))
    reader.fail("it has neither 'robot', as one of plan has, nor 'starts', as one of plan_multi has");
  const LastRequest request = reader.has("starts") ? LastRequest(read_multi_request(reader, scene))
                                                   : LastRequest(read_single_request(reader, scene));
  reader.finish();
  return request;
}

template <class Motion>
ResultText<Motion> read_result_text(io::JsonReader& reader) {
  ResultText<Motion> text;
  describe(reader, text);
  reader.finish();
  if (text.motion.has_value() != (text.statistics.status == Status::solved))
    reader.fail("the status is '" + std::string(to_string(text.statistics.status)) + "', but there is " +
                (text.motion ? "a" : "no") + " trajectory");
  return text;
}

/// A result may be edited into another one, but not into one that is no motion of its robot.
void require_motion(const io::JsonReader& place, const RobotModel& robot, const Trajectory& motion) {
  place.guarded([&] {
    motion.validate();
    if (motion.joint_names != robot.joint_names())
      throw InvalidArgument("the joints are " + quoted_list(motion.joint_names) + ", but those of robot '" +
                            robot.name() + "' are " + quoted_list(robot.joint_names()));
  });
}

LastResult read_result_of(const PlanRequest& request, io::JsonReader& reader, const Scene& scene) {
  auto text = read_result_text<Trajectory>(reader);
  if (text.motion) require_motion(reader.inner("trajectory"), *scene.robot(request.robot).model, *text.motion);
  return PlanResult(std::move(text.statistics), std::move(text.motion));
}

LastResult read_result_of(const MultiPlanRequest& request, io::JsonReader& reader, const Scene& scene) {
  auto text = read_result_text<Motions>(reader);
  if (!text.motion) return MultiPlanResult(std::move(text.statistics));
  const auto names = [](const auto& by_robot) {
    std::vector<std::string> all;
    for (const auto& [name, value] : by_robot) all.push_back(name);
    return all;
  };
  if (names(*text.motion) != names(request.starts))
    reader.fail("the trajectories are of " + quoted_list(names(*text.motion)) + ", but the request has starts of " +
                quoted_list(names(request.starts)));
  for (const auto& [name, motion] : *text.motion)
    require_motion(reader.inner("trajectories").inner(name.c_str()), *scene.robot(name).model, motion);
  return MultiPlanResult(std::move(text.statistics), MultiTrajectory{std::move(*text.motion)});
}

std::optional<LastResult> read_result(io::JsonReader& root, const std::optional<LastRequest>& request,
                                      const Scene& scene) {
  if (!root.has("result")) return std::nullopt;
  io::JsonReader reader = root.inner("result");
  if (!request) root.fail("it has a result, but no request");
  return std::visit([&](const auto& given) { return read_result_of(given, reader, scene); }, *request);
}

}  // namespace

Problem load_problem(const std::string& path, const std::vector<std::string>& package_dirs) {
  const io::JsonFile file(path, formats);
  io::JsonReader root = file.root();
  Problem problem;
  problem.scene = io::read_scene(root.inner("scene"), package_dirs);
  if (file.format() == io::scene_format) {
    root.finish();
    return problem;
  }
  for (io::JsonReader& each : root.items("planners")) {
    PlannerText text;
    describe(each, text);
    each.finish();
    each.guarded([&] {
      const PlannerOptions options = parse_options(text.options);
      require_heuristics(options, {});
      std::vector<std::string> key = planner_key(problem.scene, text.robots);
      require_planner_for(key, options);
      require_robots(options, key);
      if (!problem.planners.emplace(std::move(key), options).second)
        throw InvalidArgument("there is another planner for " + quoted_list(text.robots));
    });
  }
  read_limits(root, problem);
  problem.request = read_request(root, problem.scene);
  problem.result = read_result(root, problem.request, problem.scene);
  root.finish();
  return problem;
}

}  // namespace srmp
