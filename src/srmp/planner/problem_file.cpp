#include "srmp/planner/problem_file.hpp"

#include <algorithm>
#include <filesystem>

#include "srmp/io/scene_archive.h"
#include "srmp/io/trajectory_archive.h"
#include "srmp/planner/statistics_fields.hpp"

namespace srmp {

namespace {

const std::vector<std::string> formats{io::problem_format, io::scene_format};

struct PlannerText {
  std::vector<std::string> robots;
  OptionMap options;
};

struct ResultText {
  PlanStatistics statistics;
  std::optional<Trajectory> trajectory;
};

/// The name in the options that is no heuristic of this library; "" = there is none.
std::string foreign_heuristic(const OptionMap& options) {
  std::vector<std::string> named;
  for (const char* key : {"heuristic", "inadmissible_heuristics"}) {
    const auto it = options.find(key);
    if (it == options.end()) continue;
    if (const auto* one = std::get_if<std::string>(&it->second)) named.push_back(*one);
    if (const auto* many = std::get_if<std::vector<std::string>>(&it->second))
      named.insert(named.end(), many->begin(), many->end());
  }
  const auto& known = built_in_heuristics();
  for (const std::string& name : named)
    if (std::find(known.begin(), known.end(), name) == known.end() && !bfs_cell(name)) return name;
  return "";
}

PlannerText planner_text(const std::vector<std::string>& robots, const PlannerOptions& options) {
  PlannerText text{robots, to_map(options)};
  if (const std::string name = foreign_heuristic(text.options); !name.empty())
    throw InvalidArgument("the planner of " + quoted_list(robots) + " uses the heuristic '" + name +
                          "' of yours, a function, which no file can hold; choose a built-in one with make_planner, "
                          "or save the scene alone with save_scene");
  // The working folder may be another one by the time it is read.
  if (auto& path = std::get<std::string>(text.options["mprim_path"]); !path.empty())
    path = std::filesystem::absolute(path).string();
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
  const auto& known = available_planners();
  const auto info = std::find_if(known.begin(), known.end(),
                                 [&](const PlannerInfo& planner) { return planner.id == planner_id(options); });
  if (robots.size() > 1 && !info->many_robots)
    throw InvalidArgument("planner '" + info->id + "' plans for one robot, but " + std::to_string(robots.size()) +
                          " were named; use 'xECBS' for many");
}

void require_question(const Scene& scene, const std::string& robot, ConstVector start,
                      const std::vector<GoalConstraint>& goals) {
  const RobotModel& model = *scene.robot(robot).model;
  if (goals.empty()) throw InvalidArgument("plan needs at least one goal");
  for (const GoalConstraint& goal : goals) {
    goal.validate();
    if (goal.targets.empty())
      throw InvalidArgument("a goal of type '" + std::string(to_string(goal.type)) + "' is for plan_multi");
    if (goal.type == GoalType::joints)
      for (const Eigen::VectorXd& target : goal.targets) model.require_configuration(target, "goal of '" + robot + "'");
  }
  model.require_configuration(start, "start of '" + robot + "'");
}

namespace io {

template <class Archive>
void describe(Archive& archive, Ref<Archive, GoalConstraint> goal) {
  archive("type", goal.type);
  archive("targets", goal.targets);
  archive("position_tolerance", goal.position_tolerance.axes);
  archive("rotation_tolerance", goal.rotation_tolerance.axes);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, PlanRequest> request) {
  archive("robot", request.robot);
  archive("start", request.start);
  archive("goals", request.goals);
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
  for_each_field(statistics, [&](const char* name, auto& field) { archive(name, field); });
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, ResultText> result) {
  archive("statistics", result.statistics);
  archive("trajectory", result.trajectory);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, PlannerText> planner) {
  archive("robots", planner.robots);
  archive("options", planner.options);
}

}  // namespace io

void save_problem(const Problem& problem, const std::string& path) {
  std::vector<PlannerText> planners;
  for (const auto& [robots, options] : problem.planners) planners.push_back(planner_text(robots, options));
  io::JsonWriter writer(io::problem_format);
  writer("scene", io::SceneText{problem.scene});
  writer("planners", planners);
  if (!problem.motion_limits.empty()) writer("motion_limits", problem.motion_limits);
  writer("request", problem.request);
  if (problem.result) {
    const PlanResult& result = *problem.result;
    writer("result",
           ResultText{result.statistics(), result.solved() ? std::optional(result.trajectory()) : std::nullopt});
  }
  writer.save(path);
}

/// There are none where no limits were set.
void read_limits(io::JsonReader& root, Problem& problem) {
  if (!root.has("motion_limits")) return;
  root("motion_limits", problem.motion_limits);
  root.inner("motion_limits").guarded([&] {
    for (const auto& [robot, limits] : problem.motion_limits) {
      const RobotModel& model = *problem.scene.robot(robot).model;
      require_limits(limits, model.joint_names());
      if (limits.continuous != default_limits(model).continuous)
        throw InvalidArgument("the continuous joints of '" + robot + "' are not those of its model");
    }
  });
}

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
      if (!problem.planners.emplace(std::move(key), options).second)
        throw InvalidArgument("there is another planner for " + quoted_list(text.robots));
    });
  }
  read_limits(root, problem);
  root("request", problem.request);
  if (const auto& request = problem.request)
    root.inner("request").guarded(
        [&] { require_question(problem.scene, request->robot, request->start, request->goals); });
  std::optional<ResultText> result;
  root("result", result);
  if (result) {
    if (!problem.request) root.fail("it has a result, but no request");
    if (result->trajectory.has_value() != (result->statistics.status == Status::solved))
      root.inner("result").fail("the status is '" + std::string(to_string(result->statistics.status)) +
                                "', but there is " + (result->trajectory ? "a" : "no") + " trajectory");
    problem.result = PlanResult(result->statistics, std::move(result->trajectory));
  }
  root.finish();
  return problem;
}

}  // namespace srmp
