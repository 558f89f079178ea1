#pragma once

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "srmp/lattice/lattice.hpp"
#include "srmp/planning/strategies/strategy.hpp"
#include "srmp/search/alternating_search.hpp"
#include "srmp/search/portfolio.hpp"

namespace srmp {

/// The end of the path at which a search begins.
enum class SearchFrom { start, goals };

/// Which lattice of a family.
struct LatticeChoice {
  SearchFrom from{};
  double scale{1.0};  ///< > 0: its steps, as multiples of the resolution that the options name

  bool from_goals() const { return from == SearchFrom::goals; }
};

/// Lattices over one joint space: of one robot, or of several robots as one.
class LatticeFamily {
 public:
  virtual ~LatticeFamily() = default;
  virtual Lattice lattice(const LatticeChoice& choice) = 0;
  /// Of LatticePortfolio's own searches.
  virtual search::InadmissibleHeuristics inadmissible_heuristics(Lattice& lattice) = 0;
  /// Of a solved search in lattice(choice).
  virtual FoundPath path_of(const search::Result& result, const Lattice& lattice,
                            const LatticeChoice& choice) const = 0;
  virtual std::string describe(const LatticeChoice& choice) const = 0;
  /// Why a search that is not solved has no path; `no_path` begins the sentence.
  virtual std::string no_path_sentence(const search::Result& result, const std::string& no_path) const = 0;
};

/// One search of a portfolio and what it needs to live.
struct LatticeMember {
  LatticeChoice choice{};
  std::uint64_t slice{};                           ///< expansions in a round
  std::size_t variant{};                           ///< < LatticePortfolioOptions::variants
  std::unique_ptr<Lattice> lattice{};              ///< it cannot move
  std::vector<search::AnyHeuristic> heuristics{};  ///< of its search, which refers to them
};

/// Makes the search of a member's lattice.
using MakeLatticeSearch = std::function<std::unique_ptr<search::ResumableSearch>(LatticeMember&)>;

struct LatticePortfolioOptions {
  double weight{1.0};  ///< of each search, >= 1
  /// Resolutions of the lattices, as multiples of the one that the options name: coarse ones find paths in open space
  /// within a few expansions, fine ones find those through narrow places.
  std::vector<double> scales{3.0, 1.5, 0.75, 0.4};
  std::vector<SearchFrom> ends{SearchFrom::goals, SearchFrom::start};  ///< in this order
  /// Joint-space length: only states that may lie on a path shorter than this are searched.
  double max_length{std::numeric_limits<double>::infinity()};
  std::uint64_t max_expansions{std::numeric_limits<std::uint64_t>::max()};  ///< of one search
  std::vector<std::uint64_t> slices{8, 8};   ///< expansions of one search in a round, by end
  bool first_only{true};                     ///< search::PortfolioOptions::first_only
  search::MoreExpansions more_expansions{};  ///< with first_only
  std::size_t variants{1};                   ///< searches for each lattice
  MakeLatticeSearch search{};                ///< empty: search::AlternatingSearch
};

/// Lattices at several resolutions, from the start and from the goals, searched side by side a few expansions at a
/// time (search/portfolio.hpp); by default each by several heuristics (search/alternating_search.hpp). Searches with
/// the same steps from both ends are connected (Lattice::connect_trees). A round of attempts is one slice of each
/// search.
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
  /// Once an attempt has ended with a path: the search that found it.
  const LatticeMember& winner() const { return members_[winner_]; }
  /// Of all searches; memory includes the lattices.
  search::Statistics statistics() const;
  std::uint64_t states() const;  ///< of all lattices

 private:
  std::unique_ptr<search::ResumableSearch> begin(LatticeMember& member);
  void connect(Lattice& lattice, const LatticeChoice& choice);
  std::unique_ptr<search::ResumableSearch> alternating_search(LatticeMember& member) const;

  LatticeFamily& family_;
  const LatticePortfolioOptions options_;
  std::map<std::pair<SearchFrom, double>, search::ConfigurationTree> trees_;  // of what was expanded, by lattice
  std::vector<LatticeMember> members_;
  search::Portfolio searches_;
  std::vector<std::string> exhausted_graphs_;
  std::size_t winner_{};
};

}  // namespace srmp
