#include <algorithm>
#include <charconv>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/planning/options/registry.hpp"

namespace srmp {

const std::vector<std::string>& built_in_heuristics() {
  static const std::vector<std::string> names{"joint_euclidean", "joint_proximal", "joint_distal", "joint_sum", "bfs"};
  return names;
}

std::optional<double> bfs_cell(const std::string& heuristic) {
  if (!heuristic.starts_with("bfs(")) return std::nullopt;
  double cell{};
  const char* end = heuristic.data() + heuristic.size();
  const auto [stop, error] = std::from_chars(heuristic.data() + 4, end, cell);
  if (error == std::errc{} && stop + 1 == end && *stop == ')' && cell > 0.0 && cell <= max_length) return cell;
  throw InvalidArgument("heuristic '" + heuristic +
                        "': between the brackets must be the cell of the grid [m], above 0 and at most " +
                        to_text(max_length));
}

Improvement improvement(const PlannerOptions& options) {
  if (const auto* any = std::get_if<Auto>(&options)) return {any->improve_rounds, any->improve_time, any->final_weight};
  constexpr double fraction = 0.9;  // the rest is for timing and certificate
  if (const auto* ara = std::get_if<ARAStar>(&options))
    return {.time = fraction * ara->common.time_limit, .final_weight = ara->final_weight};
  if (const auto* amra = std::get_if<AMRAStar>(&options))
    return {.time = fraction * amra->common.time_limit, .final_weight = amra->final_weight};
  return {};
}

int num_threads(const PlannerOptions& options) {
  return std::visit(
      [](const auto& typed) {
        if constexpr (requires { typed.num_threads; }) return typed.num_threads;
        return 1;
      },
      options);
}

bool independence_detection(const PlannerOptions& options) {
  return std::visit(
      [](const auto& typed) {
        if constexpr (requires { typed.independence_detection; }) return typed.independence_detection;
        return true;
      },
      options);
}

bool large_neighbourhood_search(const PlannerOptions& options) {
  return std::visit(
      [](const auto& typed) {
        if constexpr (requires { typed.large_neighbourhood_search; }) return typed.large_neighbourhood_search;
        return !std::is_same_v<std::decay_t<decltype(typed)>, RRTConnect>;  // trees and nothing else
      },
      options);
}

const CommonOptions& common_options(const PlannerOptions& options) {
  return std::visit([](const auto& typed) -> const CommonOptions& { return typed.common; }, options);
}

CommonOptions common_options(const PlannerOptions& options, const std::string& robot) {
  CommonOptions common = common_options(options);
  const RobotOptionMap& robots = single_robots(options);
  if (const auto own = robots.find(robot); own != robots.end()) {
    if (own->second.heuristic) common.heuristic = *own->second.heuristic;
    if (own->second.mprim_path) common.mprim_path = *own->second.mprim_path;
  }
  return common;
}

void require_robots(const PlannerOptions& options, const std::vector<std::string>& robots) {
  for (const auto& [name, own] : single_robots(options)) {
    if (std::find(robots.begin(), robots.end(), name) == robots.end())
      throw InvalidArgument("there are options for robot '" + name +
                            "' alone, which is none of the robots of this planner" + or_known(name, robots));
    if (robots.size() == 1)
      throw InvalidArgument("there are options for robot '" + name + "' alone, such as 'heuristic_" + name +
                            "', but it is the only one; name them without it");
  }
}

}  // namespace srmp
