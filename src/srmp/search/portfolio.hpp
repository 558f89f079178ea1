#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "srmp/search/alternating_search.hpp"

/// Several searches of one problem, each in a graph of its own, a slice of expansions at a time, round robin: takes at
/// most a few times as long as the quickest of them, whichever that is.
///
/// Paper: Huberman, Lukose, Hogg 1997, "An Economics Approach to Hard Computational Problems" (portfolios); the
/// searches are AlternatingSearch's. Guarantee: cost <= bound * optimal cost in the graph of the search that finished
/// first, bound <= weight unless the deadline came first. `exhausted` means that no graph holds a path. Slices are
/// counted in expansions, so the result does not depend on time.
namespace srmp::search {

struct PortfolioOptions {
  double weight{1.0};      ///< >= 1
  std::uint64_t slice{8};  ///< > 0: expansions of one search before the next one continues
  /// > 0; of one search; when all that are not exhausted have made as many, the result is timed_out.
  std::uint64_t max_expansions{std::numeric_limits<std::uint64_t>::max()};
  /// Called before each round; true: the problem is solved elsewhere, stop as at the deadline.
  std::function<bool()> before_round{};
};

template <Graph G, Heuristic H>
struct PortfolioMember {
  G* graph;
  std::vector<StateId> starts;
  H* heuristic;
  InadmissibleHeuristics inadmissible_heuristics;
};

struct PortfolioResult {
  Result result;                ///< statistics: of all searches together
  std::size_t winner{};         ///< member that found it
  std::vector<char> exhausted;  ///< by member: its graph holds no path
};

/// What the searches (null: not begun) have found when `winner` is finished, or all were stopped for a reason.
template <class Search>
PortfolioResult portfolio_result(const std::vector<std::unique_ptr<Search>>& searches, std::size_t winner,
                                 std::optional<Status> stop) {
  for (std::size_t i = 0; i < searches.size(); ++i)  // stopped before the proof: the cheapest path
    if (stop && searches[i] && searches[i]->cost() < searches[winner]->cost()) winner = i;
  PortfolioResult result{{}, winner, std::vector<char>(searches.size(), 0)};
  if (searches[winner])
    result.result = searches[winner]->result(stop);
  else
    result.result.status = *stop;
  result.result.statistics = {};
  for (std::size_t i = 0; i < searches.size(); ++i) {
    if (!searches[i]) continue;
    const Statistics s = searches[i]->statistics();
    result.result.statistics.expansions += s.expansions;
    result.result.statistics.generated += s.generated;
    result.result.statistics.evaluations += s.evaluations;
    result.result.statistics.memory += s.memory;
    result.exhausted[i] = searches[i]->finished() && !searches[i]->solved();
  }
  return result;
}

/// `make(i)` is called before the first slice of member i of `count`; graph and heuristic must outlive the call. Throws
/// InvalidArgument for no members and as AlternatingSearch does.
template <Graph G, Heuristic H, class Make>
PortfolioResult portfolio(std::size_t count, Make&& make, const PortfolioOptions& options, const Deadline& deadline) {
  require_weight(options.weight, "weight");
  if (count == 0) throw InvalidArgument("a portfolio needs at least one search");
  if (options.slice == 0) throw InvalidArgument("a portfolio's slice must be at least one expansion");
  using Search = AlternatingSearch<G, H>;
  std::vector<std::unique_ptr<Search>> searches(count);
  bool limit_reached = false;
  for (bool working = true; working;) {
    if (options.before_round && options.before_round()) return portfolio_result(searches, 0, Status::timed_out);
    working = limit_reached = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (!searches[i]) {
        PortfolioMember<G, H> member = make(i);
        searches[i] =
            std::make_unique<Search>(*member.graph, *member.heuristic, member.inadmissible_heuristics, options.weight);
        searches[i]->add_starts(member.starts);
      }
      if (searches[i]->finished()) continue;
      if (searches[i]->expansions() >= options.max_expansions) {
        limit_reached = true;
        continue;
      }
      if (const auto stop = searches[i]->improve(deadline, options.slice)) return portfolio_result(searches, i, stop);
      if (searches[i]->finished() && searches[i]->solved()) return portfolio_result(searches, i, std::nullopt);
      working = true;
    }
  }
  return portfolio_result(searches, 0, limit_reached ? std::optional(Status::timed_out) : std::nullopt);
}

}  // namespace srmp::search
