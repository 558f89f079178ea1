#pragma once

#include "srmp/planning/world_paths.hpp"

namespace srmp {

struct LargeNeighbourhoodOptions {
  /// In (0, 1]: a new path must be shorter than this times the robot's path. Less saves searches that gain little.
  double max_length_ratio{0.95};
  /// Of a step of waiting [rad], > 0: small, so that waits are preferred to detours; more makes robots arrive earlier.
  double wait_cost{0.01};
  /// Steps of one wait, > 0: fewer find earlier departures, with more nodes.
  int wait_steps{3};
  /// Longer paths are left as they are: the search space grows with their duration.
  int max_steps{250};
  /// Nodes of one robot's search, which then gives up: bounds its time.
  std::size_t max_nodes{4000};
};

/// Shortens the path robot by robot, in the order of path.robots: each in turn gets the cheapest path in space-time
/// that conflicts with none of the others, which move as before. Large-neighbourhood search with neighbourhoods of one
/// robot (Li, Chen, Harabor, Stuckey, Koenig 2021, "Anytime multi-agent path finding via large neighborhood search").
///
/// A robot moves straight between vertices: the waypoints of its path, those of its single-robot path, and
/// `configurations` (by the robot's number in the world, or empty). It waits at any of them for as long as it likes,
/// also after the others have arrived. No robot's path becomes longer, and paths stay collision-free. Stops at the
/// deadline with what it has.
JointPath reroute_one_robot(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                            const std::vector<std::vector<Eigen::VectorXd>>& configurations = {},
                            const LargeNeighbourhoodOptions& options = {});

}  // namespace srmp
