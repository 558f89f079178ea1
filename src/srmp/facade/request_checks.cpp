#include "srmp/facade/request_checks.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/planning/options/registry.hpp"

namespace srmp {

std::vector<std::string> names_of(const MultiPlanRequest& request) {
  std::vector<std::string> names;
  for (const auto& [name, start] : request.starts) names.push_back(name);
  return names;
}

std::vector<std::string> moving_robots(const MultiPlanRequest& request) {
  std::vector<std::string> names;
  for (const auto& [name, goal] : request.goals)
    if (goal.type != GoalType::hold) names.push_back(name);
  for (const auto& [name, motion] : request.obstacles) names.push_back(name);
  return names;
}

bool names_any(const MultiPlanRequest& request, const std::function<bool(const std::string&)>& is_one) {
  const auto named = [&](const auto& entry) { return is_one(entry.first); };
  return std::any_of(request.starts.begin(), request.starts.end(), named) ||
         std::any_of(request.obstacles.begin(), request.obstacles.end(), named);
}
bool names_any(const PlanRequest& request, const std::function<bool(const std::string&)>& is_one) {
  return is_one(request.robot);
}

void require_planner_for_one(const PlannerOptions& options) {
  if (registered_planner(options).info.one_robot) return;
  throw NotSupported(planner_id(options) +
                     " plans for many robots, with plan_multi; make_planner another planner, such as 'wAstar', for "
                     "plan");
}

void require_no_clearance(const PlannerOptions& options, const std::string& what) {
  const CommonOptions& common = common_options(options);
  for (const auto& [name, value] :
       {std::pair("clearance", common.clearance), std::pair("preferred_clearance", common.preferred_clearance)})
    if (value > 0.0)
      throw NotSupported(std::string(name) + " is " + to_text(value) + " m, but " + what +
                         " cannot keep a clearance; make_planner with 0, and give padding to objects instead");
}

void require_clearance_for_many(const PlannerOptions& options, const MultiPlanRequest& request) {
  if (!request.obstacles.empty()) return require_no_clearance(options, "plan_multi among robots in motion");
  const double preferred = common_options(options).preferred_clearance;
  if (preferred > 0.0)
    throw NotSupported("preferred_clearance is " + to_text(preferred) +
                       " m, but plan_multi knows no preferred clearance; make_planner with 0, or with a clearance that "
                       "has to be kept");
}

void require_constraints_for_many(const PlannerOptions& options, const MultiPlanRequest& request) {
  if (!std::holds_alternative<RRTConnect>(options)) return;
  for (const auto& [robot, constraints] : request.constraints)
    if (!constraints.empty())
      throw NotSupported("constraints of '" + robot +
                         "': the trees of RRTConnect for several robots keep no path constraints; make_planner another "
                         "planner, such as 'auto' or 'xECBS', for them");
}

void require_for_many(const PlannerOptions& options) {
  const PlannerInfo& info = registered_planner(options).info;
  if (!info.many_robots)
    throw InvalidArgument("planner '" + info.id +
                          "' plans for one robot, with plan; make_planner one for many, such as 'xECBS', for "
                          "plan_multi");
}

}  // namespace srmp
