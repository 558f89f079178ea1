#pragma once

#include "srmp/planning/options.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/strategies/roadmap_levels.hpp"
#include "srmp/planning/strategies/strategy.hpp"

namespace srmp {

/// When a group's path may be replaced by one of another kind.
struct ReplanOptions {
  std::uint64_t attempts{2'048};  ///< to extend the trees
  /// Times the length of the known path: longer ones are not smoothed.
  double worth_smoothing{1.1};
  /// Times the length of the known path: only shorter ones replace it, so that similar problems keep similar paths.
  double worth_a_change{0.98};
};

/// Plans groups of robots of a world jointly. Threads may share it, each with groups of its own, and with statistics of
/// its own, whose memory leaves the world and memory() out.
class GroupPlanner {
 public:
  /// References outlive this.
  GroupPlanner(MultiRobotWorld& world, const PlannerOptions& options)
      : world_(world), options_(options), roadmaps_(world) {}

  /// By the strategies that the planner's options name: conflict-based search alone, or RRT-Connect alone; for
  /// `auto` a portfolio of robots one after the other, RRT-Connect, composite roadmaps, conflict-based search and
  /// composite lattices. Throws PlanningError.
  /// `known`: paths of groups of these robots, in conflict with each other.
  FoundPath find(const std::vector<std::size_t>& robots, const std::vector<const JointPath*>& known,
                 const Deadline& deadline, PlanStatistics& statistics);

  /// As short as it can be while no more than one robot changes its path at a time.
  JointPath reroute_each(JointPath path, const Deadline& deadline);

  /// Has one of them path constraints? Composite roadmaps, trees and lattices are not projected onto them.
  bool constrained(const std::vector<std::size_t>& robots) const;

  /// Could there be a path that replan() takes in its place?
  bool may_change(const JointPath& known) const;

  /// By RRT-Connect with another seed: a path that is shorter than `known` for its robots, or `known`.
  JointPath replan(const JointPath& known, std::uint64_t seed, const Deadline& deadline, PlanStatistics& statistics);

  std::size_t memory() const { return roadmaps_.memory(); }  ///< bytes of the roadmaps

 private:
  double direct(const std::vector<std::size_t>& robots) const;

  MultiRobotWorld& world_;
  const PlannerOptions& options_;
  const ReplanOptions replan_{};
  RoadmapLevels roadmaps_;
};

}  // namespace srmp
