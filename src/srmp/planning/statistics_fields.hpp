#pragma once

#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"

namespace srmp {

/// Calls f(name, field) for every field of a PlanStatistics: how Python and files see them.
template <class Statistics, class F>
void for_each_field(Statistics& s, F&& f) {
  f("status", s.status);
  f("reason", s.reason);
  f("found_by", s.found_by);
  f("note", s.note);
  f("plan_time_s", s.plan_time_s);
  f("total_time_s", s.total_time_s);
  f("ik_time_s", s.ik_time_s);
  f("heuristic_time_s", s.heuristic_time_s);
  f("search_time_s", s.search_time_s);
  f("shortcut_time_s", s.shortcut_time_s);
  f("timing_time_s", s.timing_time_s);
  f("verification_time_s", s.verification_time_s);
  f("expansions", s.expansions);
  f("generated", s.generated);
  f("samples", s.samples);
  f("edge_checks", s.edge_checks);
  f("edges_free_by_spheres", s.edges_free_by_spheres);
  f("edges_colliding_by_spheres", s.edges_colliding_by_spheres);
  f("edges_free_by_coal", s.edges_free_by_coal);
  f("edges_colliding_by_coal", s.edges_colliding_by_coal);
  f("configurations", s.configurations);
  f("narrow_phase", s.narrow_phase);
  f("states", s.states);
  f("memory_bytes", s.memory_bytes);
  f("recovery_waypoints", s.recovery_waypoints);
  f("recovery_cost_rad", s.recovery_cost_rad);
  f("search_cost_rad", s.search_cost_rad);
  f("path_cost_rad", s.path_cost_rad);
  f("bound", s.bound);
  f("bound_graph", s.bound_graph);
  f("solutions", s.solutions);
  f("goal_index", s.goal_index);
}

/// The same for those of plan_multi.
template <class Statistics, class F>
void for_each_multi_field(Statistics& s, F&& f) {
  f("robot_cost_rad", s.robot_cost_rad);
  f("tree_nodes", s.tree_nodes);
  f("independence_detection", s.independence_detection);
  f("large_neighbourhood_search", s.large_neighbourhood_search);
  f("makespan_s", s.makespan_s);
  f("flow_time_s", s.flow_time_s);
}

}  // namespace srmp
