#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/goal.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// One plan of many.
struct PlanRequest {
  std::string robot;
  Eigen::VectorXd start;  ///< dof [rad or m]
  std::vector<GoalConstraint> goals;
  std::optional<PlannerOptions> options{};  ///< none: those of make_planner
};

/// Told by plan_many in the caller's thread: requests done, requests in all.
using PlanProgress = std::function<void(std::size_t done, std::size_t total)>;

/// One question to plan_multi: its arguments.
struct MultiPlanRequest {
  std::map<std::string, Eigen::VectorXd> starts;  ///< by robot name, dof [rad or m]
  std::map<std::string, GoalConstraint> goals;    ///< by robot name; a robot with a start and no goal holds
  std::map<std::string, Trajectory> obstacles{};  ///< by robot name: motions that others are committed to
};

}  // namespace srmp
