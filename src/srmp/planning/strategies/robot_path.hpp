#pragma once

#include "srmp/planning/endpoints/endpoints.hpp"
#include "srmp/planning/robot_context.hpp"

namespace srmp {

/// A path of one robot among what stands still for its checker.
struct RobotPath {
  RobotEndpoints endpoints;
  RowMatrix waypoints;  ///< m x dof, from endpoints.start to one of the targets; no rows: the robot may end anywhere
};

/// Finds the endpoints, and a path between them by the strategies that the context's options name: RRT-Connect and
/// lattices side by side for `auto`, RRT-Connect alone for `RRTConnect`, one lattice for the others. Fills costs, bound
/// and solutions of the statistics. Throws PlanningError.
RobotPath find_robot_path(RobotContext& context);

}  // namespace srmp
