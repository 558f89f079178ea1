#pragma once

#include "srmp/planning/pipeline.hpp"
#include "srmp/trajectory/cartesian_path.hpp"

namespace srmp {

/// What a link of the problem's only robot is to follow, from where the robot starts.
struct PosesToFollow {
  std::string link;    ///< "" = the end effector
  CartesianPath path;  ///< in the world; begins where the link is at the start
  CartesianTolerance tolerance;
};

/// Plans a motion along poses: the start is checked, a configuration for each of close poses is searched
/// (cartesian_graph.hpp), first for poses that are far apart, then for closer ones; timing and certificate are those of
/// other plans, with corners rounded less. That the motion keeps to the poses is proved of the result. Fills the
/// statistics, whether there is a motion or a PlanningError.
Trajectory follow_poses(const PlanProblem& problem, const PosesToFollow& poses, const Deadline& deadline,
                        PlanStatistics& statistics);

}  // namespace srmp
