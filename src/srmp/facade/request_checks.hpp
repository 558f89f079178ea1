#pragma once

#include <functional>
#include <string>
#include <vector>

#include "srmp/planning/options.hpp"
#include "srmp/planning/request.hpp"

namespace srmp {

/// The robots that have a start.
std::vector<std::string> names_of(const MultiPlanRequest& request);

/// The robots that the request moves, or that are committed to motions.
std::vector<std::string> moving_robots(const MultiPlanRequest& request);

/// Does the request name something for which `is_one` is true: a robot with a start, or one of a committed motion?
bool names_any(const MultiPlanRequest& request, const std::function<bool(const std::string&)>& is_one);
bool names_any(const PlanRequest& request, const std::function<bool(const std::string&)>& is_one);

/// Throws NotSupported for a planner that plans for many robots only.
void require_planner_for_one(const PlannerOptions& options);
/// Throws InvalidArgument for a planner that plans for one robot only: one of many robots may have been given it.
void require_for_many(const PlannerOptions& options);
/// Throws NotSupported for a clearance above 0, required or preferred, which `what` cannot keep.
void require_no_clearance(const PlannerOptions& options, const std::string& what);
/// Throws NotSupported for path constraints that RRT-Connect's trees of several robots cannot keep.
void require_constraints_for_many(const PlannerOptions& options, const MultiPlanRequest& request);
/// Throws NotSupported for what of the clearances plan_multi cannot keep.
void require_clearance_for_many(const PlannerOptions& options, const MultiPlanRequest& request);

}  // namespace srmp
