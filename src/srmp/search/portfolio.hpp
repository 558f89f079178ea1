#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "srmp/search/resumable_search.hpp"

/// Several searches of one problem, each in a graph of its own, a slice of expansions at a time, round robin: takes at
/// most a few times as long as the quickest of them, whichever that is.
///
/// Paper: Huberman, Lukose, Hogg 1997, "An Economics Approach to Hard Computational Problems" (portfolios). Guarantee:
/// that of the search whose path is returned, in its graph. `exhausted` means that no graph holds a path. Slices are
/// counted in expansions, so the result does not depend on time.
namespace srmp::search {

/// How long the searches of a portfolio go on together once one has finished with a path; of the paths that are found
/// by then, the cheapest is returned.
struct MoreExpansions {
  double fraction{0.0};           ///< >= 0; of the expansions that all had made
  std::uint64_t most{unlimited};  ///< no more than this
};

struct PortfolioOptions {
  std::uint64_t slice{8};               ///< > 0: expansions of one search before the next one continues
  std::vector<std::uint64_t> slices{};  ///< the same by search; empty: `slice` for all
  /// > 0; of one search; when all that are not exhausted have made as many, the result is timed_out.
  std::uint64_t max_expansions{unlimited};
  /// Do the searches end once one has finished with a path, or do they go on until all have finished?
  bool first_only{true};
  MoreExpansions more_expansions{};  ///< with first_only, after that
};

struct PortfolioResult {
  Result result;                ///< statistics: of all searches together
  std::size_t winner{};         ///< member that found its path
  std::vector<char> exhausted;  ///< by member: its graph holds no path
};

/// The searches of a portfolio, which go on round after round.
class Portfolio {
 public:
  using Make = std::function<std::unique_ptr<ResumableSearch>(std::size_t)>;

  /// `make(i)` is called when member i of `count` has its first slice. Throws InvalidArgument for no members.
  Portfolio(std::size_t count, Make make, const PortfolioOptions& options);

  /// A slice of every search that has not finished. Nothing: another round may help. Throws as the searches do.
  std::optional<PortfolioResult> round(const Deadline& deadline);

  /// Of all searches together.
  Statistics statistics() const;

 private:
  PortfolioResult result(std::size_t winner, std::optional<Status> stop) const;
  std::size_t cheapest(std::size_t winner) const;
  std::uint64_t enough_expansions() const;

  Make make_;
  PortfolioOptions options_;
  std::vector<std::unique_ptr<ResumableSearch>> searches_;
  std::optional<std::size_t> first_;  // member that finished first with a path
  std::uint64_t enough_{};            // expansions of all searches, once one has
};

/// Rounds of a portfolio until it has a result. Throws as Portfolio does.
PortfolioResult portfolio(std::size_t count, Portfolio::Make make, const PortfolioOptions& options,
                          const Deadline& deadline);

}  // namespace srmp::search
