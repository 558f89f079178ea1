#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// Options by the robots they plan for: names sorted, each once.
using PlannerTable = std::map<std::vector<std::string>, PlannerOptions>;

/// The key of these robots. Throws InvalidArgument for unknown robots, for none, and for one that is named twice.
std::vector<std::string> planner_key(const Scene& scene, std::vector<std::string> robots);
/// Throws InvalidArgument for several robots and a planner that is for one.
void require_planner_for(const std::vector<std::string>& robots, const PlannerOptions& options);
/// Throws InvalidArgument unless start and goals suit the robot.
void require_request(const Scene& scene, const std::string& robot, ConstVector start,
                     const std::vector<GoalConstraint>& goals);
/// The same of many robots: throws InvalidArgument unless starts and goals suit them, and one is to move. Of obstacles
/// only the names are checked; the rest is stand_at_ends'.
void require_multi_request(const Scene& scene, const MultiPlanRequest& request);

/// What a problem file holds: a world, how its robots plan, and the last request with its result.
struct Problem {
  Scene scene;
  PlannerTable planners;
  std::map<std::string, MotionLimits> motion_limits{};  ///< of robots whose limits were set
  std::optional<LastRequest> request;                   ///< without options: those of `planners` count
  std::optional<LastResult> result;                     ///< of the request, in this scene, by these planners
};

/// Throws FileError when the file cannot be written, and InvalidArgument when a planner names a heuristic of the
/// user's: a function cannot be saved.
void save_problem(const Problem& problem, const std::string& path);
/// As io::load_scene; a scene file is a problem without planners.
Problem load_problem(const std::string& path, const std::vector<std::string>& package_dirs = {});

}  // namespace srmp
