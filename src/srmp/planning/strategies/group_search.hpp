#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "srmp/multi/conflict_search.hpp"
#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/strategies/composite_roadmap.hpp"
#include "srmp/planning/strategies/composite_space.hpp"

namespace srmp {

/// Ways of arms that are planned together, and what is known of them: none cost less than `lower`.
struct GroupWays {
  JointPath path;
  double lower{};
};

/// Plans groups of arms of a world. Threads may share it, each with groups of its own, and with statistics of its own,
/// whose memory leaves the world and memory() out.
class GroupSearch {
 public:
  /// References outlive this.
  GroupSearch(MultiRobotWorld& world, const PlannerOptions& options)
      : world_(world), options_(options), roadmaps_(max_levels) {}

  /// Where the planner may, four searches in turns with more and more effort: on roadmaps, which is quick where arms
  /// need only wait or step aside; by trees of all arms' joints, for arms that are in each other's way; conflict-based
  /// search, for arms that get by each other; and one search on a lattice of all arms' joints. Else conflict-based
  /// search alone. Throws PlanningError.
  GroupWays run(const std::vector<std::size_t>& arms, const Deadline& deadline, PlanStatistics& statistics);

  /// As short as it can be while no more than one arm changes its way at a time.
  JointPath each_by_itself(JointPath path, const Deadline& deadline);

  /// Could there be a way that anew() takes in its place?
  bool may_change(const JointPath& known) const;

  /// By trees of another sequence: a way that is better than `known` for its arms, or `known`.
  JointPath anew(const JointPath& known, std::uint64_t sequence, const Deadline& deadline, PlanStatistics& statistics);

  std::size_t memory() const;             ///< bytes of the roadmaps
  std::string describe_lattices() const;  ///< as in "lattices of 15 degrees"

 private:
  static constexpr std::size_t max_levels = 4;  // of roadmaps

  CompositeRoadmap& roadmaps(std::size_t level);
  CompositeRoadmap::Result on_roadmaps(const std::vector<std::size_t>& arms, std::size_t level,
                                       const CompositeRoadmap::SearchBudget& effort, const Deadline& deadline,
                                       PlanStatistics& statistics);
  std::optional<JointPath> on_roadmaps(const std::vector<std::size_t>& arms, std::size_t level, std::uint64_t effort,
                                       double most, const Deadline& deadline, PlanStatistics& statistics);
  bool may_be_shorter(const JointPath& known) const;
  std::vector<std::vector<Eigen::VectorXd>> places_aside(const std::vector<std::size_t>& arms) const;
  void require_solved(const multi::ConflictSearchResult& found) const;

  MultiRobotWorld& world_;
  const PlannerOptions& options_;
  std::mutex mutex_;                                         // of the making of roadmaps
  std::vector<std::unique_ptr<CompositeRoadmap>> roadmaps_;  // richer and richer; null: not made yet
};

}  // namespace srmp
