#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/status.hpp"

namespace srmp {

/// A path that was better, or proved to be better, than what was known before. It begins where an escape from the start
/// ended, if there was one.
struct Solution {
  double time_s{};    ///< since the call of plan
  double cost_rad{};  ///< joint-space length of the path as it would be returned
  double bound{};     ///< cost_rad <= bound * the optimum of `graph`; infinity = none proven
  std::string graph;  ///< "the lattice of 22.5 degrees from the start"; "every path": of all there are in joint space
};

/// Sees each solution, with its waypoints (n, dof), while the plan runs; false: it is good enough.
using OnSolution = std::function<bool(const Solution&, ConstRows waypoints)>;

/// What the last plan did, and how long each phase took.
struct PlanStatistics {
  Status status{Status::exhausted};
  std::string reason;     ///< why there is no trajectory; "" when solved
  std::string found_by;   ///< the strategy that found the path, as "RRT-Connect" or a lattice as in `graph`
  std::string note;       ///< what was changed on the way in (a start clamped onto a limit, or escaped from); mostly ""
  double plan_time_s{};   ///< checks of start and goal, IK, heuristics, search, shortcut: until the path is ready
  double total_time_s{};  ///< call to return, timing and re-check included
  double ik_time_s{};
  double heuristic_time_s{};
  double search_time_s{};
  double shortcut_time_s{};
  double timing_time_s{};
  double verification_time_s{};
  std::uint64_t expansions{};
  std::uint64_t generated{};
  std::uint64_t edge_checks{};  ///< motions checked, shortcut included; the sum of the next four
  std::uint64_t edges_free_by_spheres{};
  std::uint64_t edges_colliding_by_spheres{};
  std::uint64_t edges_free_by_coal{};       ///< for the parts of them that spheres left open, if there were spheres
  std::uint64_t edges_colliding_by_coal{};  ///< the same
  std::uint64_t configurations{};           ///< kinematics computed for them
  std::uint64_t narrow_phase{};             ///< pairs that Coal decided
  std::uint64_t states{};                   ///< states of the lattice
  std::uint64_t memory_bytes{};     ///< the most that states, OPEN, search trees, roadmaps and grids took together
  int recovery_waypoints{};         ///< the path is free from this waypoint on; above 0: CommonOptions::recover_start
  double recovery_cost_rad{};       ///< joint-space length up to there, which no other cost here counts
  double search_cost_rad{};         ///< joint-space length of the search's cheapest path, before the shortcut
  double path_cost_rad{};           ///< joint-space length of the returned path
  double bound{};                   ///< path_cost_rad <= bound * the optimum of bound_graph; infinity = none proven
  std::string bound_graph;          ///< as Solution::graph
  std::vector<Solution> solutions;  ///< every path that was returned or improved on; costs and bounds never rise
  int goal_index{-1};               ///< which of the goals (all targets of all constraints, in order) was reached

  // Of plan_multi, whose costs are sums over the robots and whose goal_index says nothing.
  std::map<std::string, double> robot_cost_rad;  ///< by name
  std::uint64_t tree_nodes{};                    ///< of the constraint tree
  double makespan_s{};                           ///< until the last robot is at its goal
  double flow_time_s{};                          ///< sum of the times until each is
};

}  // namespace srmp
