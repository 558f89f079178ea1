#pragma once

#include <vector>

#include "srmp/planning/parallel_work.hpp"
#include "srmp/planning/problem.hpp"
#include "srmp/planning/strategies/robot_path.hpp"
#include "srmp/planning/world_paths.hpp"

namespace srmp {

/// Paths of all robots of a problem. Each group's path may be timed by itself; different groups do not collide.
struct JointPaths {
  std::vector<JointPath> raw;       ///< of each group, as a strategy found it; none for one robot
  std::vector<JointPath> smoothed;  ///< the same, shortened
  /// That the paths were found in; null for one robot.
  std::unique_ptr<MultiRobotWorld> world;
  double lower{};  ///< no paths of the robots' lattices cost less, in sum
  /// Of one robot: corners near ends that are closer than the clearance are rounded by the rule of CloseMotions.
  bool close_ends{};
};

/// Finds the paths of several robots from the paths of each alone: robots whose paths collide are planned jointly, as
/// groups that grow until no two groups collide (independence detection: Standley 2010, "Finding Optimal Solutions to
/// Cooperative Pathfinding Problems"). CBS and ECBS plan all robots jointly that can reach each other. Then the paths
/// are shortened, and rerouted robot by robot and replanned as the options ask (large neighbourhood search: Li et al.
/// 2021). Fills the statistics. Throws PlanningError.
JointPaths find_joint_paths(const PlanProblem& problem, std::vector<RobotPath> alone, ParallelWork& work,
                            const Deadline& deadline, PlanStatistics& statistics);

/// Writes the costs of these paths, which are to be returned, with the bound that `lower` proves, into the statistics.
void record_costs(const PlanProblem& problem, const std::vector<JointPath>& paths, double lower,
                  const Deadline& deadline, PlanStatistics& statistics);

}  // namespace srmp
