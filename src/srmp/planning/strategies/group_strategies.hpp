#pragma once

#include <optional>

#include "srmp/multi/conflict_search.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/strategies/composite_roadmap.hpp"
#include "srmp/planning/strategies/composite_space.hpp"
#include "srmp/planning/strategies/free_goals.hpp"
#include "srmp/planning/strategies/roadmap_levels.hpp"
#include "srmp/planning/strategies/strategy.hpp"

// The strategies that plan several robots of a world jointly. What they do grows from one round to the next. References
// outlive them; they add their work to the statistics.
namespace srmp {

/// Robots that move one after the other (one_by_one.hpp): quickest where they need not move at the same time.
class OneByOneStrategy : public Strategy {
 public:
  /// `known`: paths of some of the robots, which outlive this.
  OneByOneStrategy(MultiRobotWorld& world, const std::vector<std::size_t>& robots, std::vector<const JointPath*> known,
                   PlanStatistics& statistics)
      : world_(world), robots_(robots), known_(std::move(known)), statistics_(statistics) {}

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }

 private:
  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  const std::vector<const JointPath*> known_;
  PlanStatistics& statistics_;
  std::optional<FreeGoals> goals_;  // from the first attempt on
};

/// Roadmaps of the robots, searched jointly (composite_roadmap.hpp): quick where robots need only wait or retreat. Each
/// round goes to richer roadmaps. After the first path the same product is searched again less greedily, there and on
/// the next richer roadmaps: where robots may pass each other in many ways, similar problems get similar paths only if
/// these are near the best.
class CompositeRoadmapStrategy : public Strategy {
 public:
  CompositeRoadmapStrategy(MultiRobotWorld& world, const std::vector<std::size_t>& robots, RoadmapLevels& roadmaps,
                           PlanStatistics& statistics)
      : world_(world), robots_(robots), roadmaps_(roadmaps), statistics_(statistics) {}

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }

 private:
  std::optional<JointPath> find(std::size_t level, const AttemptBudget& budget, const Deadline& deadline);
  bool may_be_shorter(const JointPath& path) const;

  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  RoadmapLevels& roadmaps_;
  PlanStatistics& statistics_;
  std::size_t next_level_{0};
};

/// RRT-Connect in the joint space of all robots: quick where robots block each other from start to goal, of which no
/// lattice of so many joints holds a path that is found soon. Some samples take a hundred times as long as others
/// (Wedge, Branicky 2008, "On Heavy-tailed Runtimes and Restarts in RRTs"), so the trees begin anew with others after
/// one, one, two, one, one, two, four, … times as many attempts (Luby, Sinclair, Zuckerman 1993, "Optimal Speedup of
/// Las Vegas Algorithms").
class CompositeRrtStrategy : public Strategy {
 public:
  /// `known`: paths of some of the robots, or none. If all have one, every second pair of trees begins along these.
  CompositeRrtStrategy(MultiRobotWorld& world, const CompositeSpace& space, const std::vector<const JointPath*>& known,
                       const CommonOptions& options, PlanStatistics& statistics);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }

 private:
  std::optional<std::vector<Eigen::VectorXd>> grow_trees(std::uint64_t attempts, const Deadline& deadline);

  MultiRobotWorld& world_;
  const CompositeSpace& space_;
  std::vector<Eigen::VectorXd> known_;  // configurations along the known paths, or none
  const CommonOptions& options_;
  PlanStatistics& statistics_;
  std::uint64_t restarts_{};
};

/// Conflict-based search on the robots' lattices in discrete time (multi/conflict_search.hpp): CBS, ECBS, prioritised.
class ConflictSearchStrategy : public Strategy {
 public:
  /// `alone`: nothing else searches, so a round has no limit but the deadline.
  ConflictSearchStrategy(MultiRobotWorld& world, const std::vector<std::size_t>& robots, const PlannerOptions& options,
                         bool alone, PlanStatistics& statistics);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return true; }

 private:
  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  const PlannerOptions& options_;
  multi::ConflictSearchOptions search_options_;
  const bool alone_;
  PlanStatistics& statistics_;
};

/// One lattice search over all robots' joints (composite_search.hpp).
class CompositeLatticeStrategy : public Strategy {
 public:
  CompositeLatticeStrategy(const CompositeSpace& space, PlanStatistics& statistics)
      : space_(space), statistics_(statistics) {}

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }  // what spheres cannot prove may be free

 private:
  const CompositeSpace& space_;
  PlanStatistics& statistics_;
};

/// Of conflict-based search, as the planner's options have them.
multi::ConflictSearchOptions conflict_search_options(const PlannerOptions& options);

/// A conflict-based search of these robots of a world, with its work added to the statistics.
Attempt conflict_search_attempt(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                                const PlannerOptions& options, multi::ConflictSearchOptions search_options,
                                const std::string& found_by, const Deadline& deadline, PlanStatistics& statistics);

/// The same in a world that is not the plan's, whose checks this deadline stops: its states and checks are counted,
/// too.
Attempt conflict_search_apart(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                              const PlannerOptions& options, const multi::ConflictSearchOptions& search_options,
                              const std::string& found_by, const Deadline& deadline, PlanStatistics& statistics);

/// The robots of a world with other tasks and options.
std::unique_ptr<MultiRobotWorld> world_like(const MultiRobotWorld& world, std::vector<WorldTask> tasks,
                                            const MultiRobotWorld::Options& options);

/// "lattices of 15 degrees".
std::string describe_lattices(const MultiRobotWorld& world, const PlannerOptions& options);
/// "the robots' lattices of 15 degrees, in steps of 0.1 s, waiting counted".
std::string describe_graph(const MultiRobotWorld& world, const PlannerOptions& options);

}  // namespace srmp
