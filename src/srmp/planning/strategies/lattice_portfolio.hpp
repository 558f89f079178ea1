#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "srmp/lattice/lattice.hpp"
#include "srmp/planning/strategies/strategy.hpp"
#include "srmp/search/portfolio.hpp"

namespace srmp {

/// Lattices over one joint space: of one robot, or of several robots as one. They begin at the start or, backward, at
/// the goals, and have steps of `scale` times the resolution that the options name.
class LatticeFamily {
 public:
  virtual ~LatticeFamily() = default;
  virtual Lattice lattice(bool backward, double scale) = 0;
  virtual search::InadmissibleHeuristics inadmissible_heuristics(Lattice& lattice) = 0;
  /// Of a solved search in lattice(backward, scale).
  virtual FoundPath path_of(const search::Result& result, const Lattice& lattice, bool backward,
                            double scale) const = 0;
  virtual std::string describe(bool backward, double scale) const = 0;
  /// Why a search that is not solved has no path; `no_path` begins the sentence.
  virtual std::string no_path_sentence(const search::Result& result, const std::string& no_path) const = 0;
};

struct LatticePortfolioOptions {
  double weight{1.0};  ///< of each search, >= 1
  /// Resolutions of the lattices, as multiples of the one that the options name: coarse ones find paths in open space
  /// within a few expansions, fine ones find those through narrow places.
  std::vector<double> scales{3.0, 1.5, 0.75, 0.4};
  std::vector<bool> directions{true, false};  ///< backward? in this order
  /// Joint-space length: only states that may lie on a path shorter than this are searched.
  double max_length{std::numeric_limits<double>::infinity()};
  std::uint64_t max_expansions{std::numeric_limits<std::uint64_t>::max()};  ///< of one search
};

/// Lattices at several resolutions, from the start and from the goals, searched side by side a few expansions at a
/// time, each by several heuristics (search/portfolio.hpp). A round of attempts is one slice of each search.
class LatticePortfolio : public Strategy {
 public:
  /// The family outlives this.
  LatticePortfolio(LatticeFamily& family, const LatticePortfolioOptions& options);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return true; }
  /// Rounds until there is a path, or all lattices are exhausted, or the expansions or the time are used up.
  Attempt run(const Deadline& deadline);

  /// Names of the lattices that were exhausted: none holds a path shorter than max_length.
  const std::vector<std::string>& exhausted_graphs() const { return exhausted_graphs_; }
  bool all_exhausted() const { return exhausted_graphs_.size() == members_.size(); }
  /// Of all searches; memory includes the lattices.
  search::Statistics statistics() const;
  std::uint64_t states() const;  ///< of all lattices

 private:
  /// One search and what it needs to live.
  struct Member {
    std::unique_ptr<Lattice> lattice;  // it cannot move
    search::AnyHeuristic anchor;
    bool backward;
    double scale;
  };
  using Searches = search::Portfolio<Lattice, search::AnyHeuristic>;

  search::PortfolioMember<Lattice, search::AnyHeuristic> make_search(Member& member) const;

  LatticeFamily& family_;
  const LatticePortfolioOptions options_;
  std::vector<Member> members_;
  std::unique_ptr<Searches> searches_;
  std::vector<std::string> exhausted_graphs_;
};

}  // namespace srmp
