#pragma once

#include <memory>
#include <string>
#include <vector>

#include "srmp/planning/strategies/best_path.hpp"
#include "srmp/planning/strategies/robot_lattices.hpp"

namespace srmp {

/// Does the option multi_resolution ask for it? False for planners without.
bool searches_several_lattices(const PlannerOptions& options);

/// The planners of one robot that search lattices and nothing else: A*, weighted A*, ARA*, MHA*, wPA*SE, AMRA*. One
/// search of one lattice or, with the option `multi_resolution`, one search of each of several lattices, side by side.
/// An attempt is the whole search; the anytime planners hand each path that is better than the one before to `best`.
class LatticeSearch : public Strategy {
 public:
  /// References outlive this. Throws NotSupported for the options of a planner for many robots.
  /// `direct` is the length of the straight line between the path's ends.
  LatticeSearch(RobotContext& context, const SearchEndpoints& endpoints, RobotLattices& lattices, BestPath& best,
                double direct);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return true; }

 private:
  bool anytime() const;
  Lattice make_lattice(const LatticeChoice& choice);
  LatticePortfolioOptions portfolio_options();
  /// From both ends, from the one with less clearance more often.
  void prefer_narrow_end(LatticePortfolioOptions& options);
  SearchFrom narrower_end();
  double clearance(const Eigen::VectorXd& q);
  Attempt run(LatticePortfolio& searches, const Deadline& deadline);
  std::unique_ptr<search::ResumableSearch> make_search(LatticeMember& member);
  std::unique_ptr<search::ResumableSearch> make_ara_star(LatticeMember& member, const ARAStar& options);
  std::unique_ptr<search::ResumableSearch> make_amra_star(LatticeMember& member, const AMRAStar& options);
  search::AnyHeuristic heuristic(LatticeMember& member);
  bool take(const search::Result& better, const LatticeMember& member, double final_weight);
  FoundPath found_path(const search::Result& result, const LatticeMember& member) const;
  void bound(FoundPath& found) const;

  RobotContext& context_;
  const SearchEndpoints& endpoints_;
  RobotLattices& lattices_;
  BestPath& best_;
  const double direct_;
  const bool several_;       // lattices
  bool good_enough_{false};  // of an anytime planner: no better path is required
};

}  // namespace srmp
