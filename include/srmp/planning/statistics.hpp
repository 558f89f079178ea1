#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/status.hpp"

namespace srmp {

/// A path that was better, or was proved to be better, than those known before. It begins where the start-state
/// recovery ended, if there was one.
struct Solution {
  double time_s{};    ///< [s] since the call of plan
  double cost_rad{};  ///< joint-space length of the path as it would be returned [rad, prismatic joints m]
  double bound{};     ///< cost_rad <= bound * the optimum of `graph`; infinity = none proven
  std::string graph;  ///< "the lattice of 22.5 degrees from the start"; "every path": of all there are in joint space
};

/// Receives each solution with its waypoints (n, dof) [rad or m] while the plan runs. Returns false when it is good
/// enough; then the plan ends with it.
using OnSolution = std::function<bool(const Solution&, ConstRows waypoints)>;

/// What a plan did, and how long each phase took.
struct PlanStatistics {
  Status status{Status::exhausted};  ///< how the plan ended
  std::string reason;                ///< why there is no trajectory; "" when solved
  std::string found_by;              ///< strategy that found the path: "RRT-Connect", a lattice as in `graph`, …
  std::string note;       ///< what was changed in the request (a start clamped onto a limit, or recovered); mostly ""
  double plan_time_s{};   ///< [s] checks of start and goal, IK, heuristics, search, shortcut: until the path is ready
  double total_time_s{};  ///< [s] from call to return, timing and verification included
  double ik_time_s{};     ///< [s] inverse kinematics
  double heuristic_time_s{};                   ///< [s] preparing heuristics
  double search_time_s{};                      ///< [s] search
  double shortcut_time_s{};                    ///< [s] shortcut
  double timing_time_s{};                      ///< [s] time parameterisation
  double verification_time_s{};                ///< [s] certificate
  std::uint64_t expansions{};                  ///< states expanded
  std::uint64_t generated{};                   ///< successors generated
  std::uint64_t samples{};                     ///< configurations that RRT-Connect drew: it expands no states
  std::uint64_t edge_checks{};                 ///< motions checked, shortcut included; the sum of the next four
  std::uint64_t edges_free_by_spheres{};       ///< decided by spheres alone
  std::uint64_t edges_colliding_by_spheres{};  ///< decided by spheres alone; how many may differ by instruction set
  std::uint64_t edges_free_by_coal{};          ///< decided by Coal, for the parts that spheres left open
  std::uint64_t edges_colliding_by_coal{};     ///< decided by Coal, as before
  std::uint64_t configurations{};              ///< configurations whose kinematics were computed for them
  std::uint64_t narrow_phase{};                ///< pairs of bodies that Coal decided
  std::uint64_t states{};                      ///< states of the lattice
  std::uint64_t memory_bytes{};     ///< maximum of what states, OPEN, search trees, roadmaps and grids took together
  int recovery_waypoints{};         ///< the path is free from this waypoint on; above 0: CommonOptions::recover_start
  double recovery_cost_rad{};       ///< joint-space length up to there, which no other cost here counts
  double search_cost_rad{};         ///< joint-space length of the search's cheapest path, before the shortcut
  double path_cost_rad{};           ///< joint-space length of the returned path
  double bound{};                   ///< path_cost_rad <= bound * the optimum of bound_graph; infinity = none proven
  std::string bound_graph;          ///< as Solution::graph
  std::vector<Solution> solutions;  ///< every path that was returned or improved; costs and bounds never rise
  int goal_index{-1};               ///< which of the goals (all targets of all constraints, in order) was reached

  // Of plan_multi, whose costs are sums over the robots and whose goal_index says nothing.
  std::map<std::string, double> robot_cost_rad;  ///< path_cost_rad of each robot, by name
  std::uint64_t tree_nodes{};                    ///< nodes of the constraint tree
  bool independence_detection{};                 ///< robots that did not conflict kept the paths found for each alone
  bool large_neighbourhood_search{};             ///< paths planned jointly were rerouted, one robot at a time
  double makespan_s{};                           ///< [s] until the last robot is at its goal
  double flow_time_s{};                          ///< [s] sum over the robots of the times until each is
};

}  // namespace srmp
