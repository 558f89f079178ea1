#pragma once

#include <memory>
#include <string>
#include <vector>

#include "srmp/planning/strategies/group_strategies.hpp"

namespace srmp {

/// Conflict-based search of a group of robots on lattices of several steps (`multi_resolution` of ECBS): from round to
/// round each of them is searched anew with four times the work, the coarse ones first. Which of them is quick differs
/// from problem to problem. The bound holds for the lattices in which the paths were found.
class LatticeConflictSearch : public Strategy {
 public:
  /// References outlive this. The robots have no primitives of their own.
  LatticeConflictSearch(MultiRobotWorld& world, const std::vector<std::size_t>& robots, const PlannerOptions& options,
                        PlanStatistics& statistics);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return true; }

 private:
  struct Lattices {
    double scale;                              ///< of their steps, as multiples of the world's
    std::unique_ptr<MultiRobotWorld> world{};  ///< null: not made yet
    Attempt last{};
  };

  Attempt search(Lattices& lattices, std::uint64_t evaluations, const Deadline& deadline);

  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  const PlannerOptions& options_;
  PlanStatistics& statistics_;
  std::vector<Lattices> lattices_;
};

}  // namespace srmp
