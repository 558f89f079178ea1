#pragma once

#include <optional>
#include <string>

#include "srmp/lattice/lattice.hpp"
#include "srmp/planning/endpoints/search_endpoints.hpp"
#include "srmp/planning/strategies/lattice_portfolio.hpp"
#include "srmp/planning/strategies/robot_heuristics.hpp"

namespace srmp {

/// Makes the lattices of one robot's search, from the start or from the targets, and turns what a search found in them
/// into a path.
class RobotLattices : public LatticeFamily {
 public:
  /// Both outlive this and its lattices.
  RobotLattices(RobotContext& context, const SearchEndpoints& endpoints);

  /// Has the user given motion primitives? Then all lattices have these.
  bool own_primitives() const { return !context_.common.mprim_path.empty(); }
  RobotHeuristics& heuristics() { return heuristics_; }

  Lattice plain(SearchFrom from);  ///< with default_primitives, at the resolution that the options name
  /// With rich_primitives: of finest_scale times that resolution, with three coarser levels of double steps each. The
  /// user's own primitives have one level.
  Lattice multi_resolution(SearchFrom from);
  static constexpr double finest_scale = 0.4;
  /// With rich_primitives.
  Lattice lattice(const LatticeChoice& choice) override;
  search::InadmissibleHeuristics inadmissible_heuristics(Lattice& lattice) override {
    return heuristics_.inadmissible_heuristics(lattice);
  }
  std::string describe(const LatticeChoice& choice) const override;  ///< as Solution::graph
  /// The lower bound of the path is the search's own.
  FoundPath path_of(const search::Result& result, const Lattice& lattice, const LatticeChoice& choice) const override;
  std::string no_path_sentence(const search::Result& result, const std::string& no_path) const override {
    return context_.no_path_sentence(result, no_path);
  }

  /// A portfolio of these lattices, as direction and primitives allow; all steps are `finer` times the usual ones.
  LatticePortfolioOptions portfolio_options(double weight, double finer = 1.0, double max_length = search::infinity,
                                            std::uint64_t max_expansions = ~std::uint64_t{0}) const;
  /// Adds what the portfolio did to the statistics.
  void count(const LatticePortfolio& searches);

 private:
  Lattice make(const LatticeChoice& choice, PrimitiveSet primitives, std::vector<Lattice::CoarseLevel> coarser = {});
  Lattice::Projection projection() const;
  PrimitiveSet read_primitives() const;
  const std::vector<JointPair>& pairs();
  Eigen::VectorXd step(double scale = 1.0) const;
  double resolution(double scale) const;

  RobotContext& context_;
  const SearchEndpoints& endpoints_;
  RobotHeuristics heuristics_;
  GoalConnection goal_connection_;
  std::optional<std::vector<JointPair>> pairs_;  // once needed
};

}  // namespace srmp
