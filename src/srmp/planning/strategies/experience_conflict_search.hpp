#pragma once

#include <memory>
#include <string>
#include <vector>

#include "srmp/multi/conflict_search.hpp"
#include "srmp/planning/multi_robot_world.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/strategies/composite_space.hpp"
#include "srmp/planning/strategies/strategy.hpp"

namespace srmp {

/// xECBS of a group of robots: conflict-based search that reuses what lattice searches have found (experience: Shaoul,
/// Mishani, Likhachev, Li 2024), and nothing else.
///
/// 1. The robots move on their paths alone, back and forth, and give way to each other there.
/// 2. The same with more paths of each robot, which lead around the others at their starts or goals. They are found by
///    searches of the robot's lattices from both ends, while the others stand still.
/// 3. The robots search lattices, whose waypoints are all these paths: coarse ones first, with budgets that grow from
///    round to round.
class ExperienceConflictSearch : public Strategy {
 public:
  /// References outlive this.
  ExperienceConflictSearch(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                           const PlannerOptions& options, PlanStatistics& statistics);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  /// What spheres do not prove apart may be apart, and another lattice may hold paths.
  bool can_exhaust() const override { return world_.has_own_primitives(); }

 private:
  struct Scaled {
    double scale;                            ///< of the lattices' steps, as multiples of the world's
    std::unique_ptr<MultiRobotWorld> world;  ///< null: not made yet
  };

  Attempt along_known_paths(const Deadline& deadline);
  Attempt on_lattices(Scaled& lattices, std::uint64_t evaluations, const Deadline& deadline);
  Attempt search(MultiRobotWorld& world, const multi::ConflictSearchOptions& options, const std::string& found_by,
                 const Deadline& deadline);
  std::unique_ptr<MultiRobotWorld> make_world(double scale) const;
  // True: there are more known paths than before.
  bool add_paths_around_each(const Deadline& deadline);
  bool add_paths_in_sequence(const Deadline& deadline);
  enum class Pass { no, on_known_path, on_new_path };
  Pass can_pass(std::size_t robot, const CompositeSpace::Others& others, const Deadline& deadline);
  static bool passes(const std::vector<Eigen::VectorXd>& path, const CompositeSpace& space);
  const Eigen::VectorXd& goal(std::size_t robot) const;

  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  const PlannerOptions& options_;
  PlanStatistics& statistics_;
  std::vector<WorldTask> tasks_;  // of all robots, with what is known of these
  std::vector<Scaled> lattices_;
};

}  // namespace srmp
