#pragma once

#include "srmp/planning/strategies/best_path.hpp"
#include "srmp/planning/strategies/robot_lattices.hpp"

namespace srmp {

/// The planners that search one lattice of one robot: A*, weighted A*, ARA*, MHA*, wPA*SE. An attempt is the whole
/// search; ARA* hands each path that is better than the one before to `best`.
class LatticeSearch : public Strategy {
 public:
  /// References outlive this.
  LatticeSearch(RobotContext& context, const RobotEndpoints& endpoints, RobotLattices& lattices, BestPath& best)
      : context_(context), endpoints_(endpoints), lattices_(lattices), best_(best) {}

  /// Throws NotSupported for the options of a planner for many robots.
  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return true; }

 private:
  void choose_direction();
  double clearance(const Eigen::VectorXd& q);
  search::Result search(Lattice& lattice);
  search::Result run_search(Lattice& lattice, const search::AnyHeuristic& heuristic);
  FoundPath found_path(const search::Result& result, const Lattice& lattice) const;

  RobotContext& context_;
  const RobotEndpoints& endpoints_;
  RobotLattices& lattices_;
  BestPath& best_;
  bool backward_{false};
};

}  // namespace srmp
