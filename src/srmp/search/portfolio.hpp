#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "srmp/search/alternating_search.hpp"

/// Several guided searches of one question, each in a graph of its own, a few expansions at a time in turns: as quick
/// as a few times the quickest of them, whichever that is.
///
/// Paper: Huberman, Lukose, Hogg 1997, "An Economics Approach to Hard Computational Problems" (portfolios); the
/// searches are AlternatingSearch's. Guarantee: cost <= bound * optimal cost in the graph of the search that finished
/// first, bound <= weight unless the deadline came first. `exhausted` means that no graph holds a path. Turns are
/// counted in expansions, so the answer does not depend on time.
namespace srmp::search {

struct PortfolioOptions {
  double weight{1.0};     ///< >= 1
  std::uint64_t turn{8};  ///< > 0: expansions of one search before it is the next one's turn
  /// > 0; of one search; when all that are not exhausted have had as many, the answer is timed_out.
  std::uint64_t max_expansions{std::numeric_limits<std::uint64_t>::max()};
  /// Called before each may have its next turn; true: what is asked is known from elsewhere, stop as at the deadline.
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

/// `make(i)` is called when member i of `count` has its first turn; graph and heuristic must outlive the call. Throws
/// InvalidArgument for no members and as AlternatingSearch does.
template <Graph G, Heuristic H, class Make>
PortfolioResult portfolio(std::size_t count, Make&& make, const PortfolioOptions& options, const Deadline& deadline) {
  require_weight(options.weight, "weight");
  if (count == 0) throw InvalidArgument("a portfolio needs at least one search");
  if (options.turn == 0) throw InvalidArgument("a portfolio's turn must be at least one expansion");
  using Search = AlternatingSearch<G, H>;
  std::vector<std::unique_ptr<Search>> searches(count);
  const auto finish = [&](std::size_t winner, std::optional<Status> stop) {
    for (std::size_t i = 0; i < count; ++i)  // stopped before the proof: the cheapest path
      if (stop && searches[i] && searches[i]->cost() < searches[winner]->cost()) winner = i;
    PortfolioResult answer{{}, winner, std::vector<char>(count, 0)};
    if (searches[winner])
      answer.result = searches[winner]->result(stop);
    else
      answer.result.status = *stop;
    answer.result.statistics = {};
    for (std::size_t i = 0; i < count; ++i) {
      if (!searches[i]) continue;
      const Statistics s = searches[i]->statistics();
      answer.result.statistics.expansions += s.expansions;
      answer.result.statistics.generated += s.generated;
      answer.result.statistics.evaluations += s.evaluations;
      answer.result.statistics.memory += s.memory;
      answer.exhausted[i] = searches[i]->finished() && !searches[i]->solved();
    }
    return answer;
  };
  bool gave_up = false;
  for (bool working = true; working;) {
    if (options.before_round && options.before_round()) return finish(0, Status::timed_out);
    working = gave_up = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (!searches[i]) {
        PortfolioMember<G, H> member = make(i);
        searches[i] =
            std::make_unique<Search>(*member.graph, *member.heuristic, member.inadmissible_heuristics, options.weight);
        searches[i]->add_starts(member.starts);
      }
      if (searches[i]->finished()) continue;
      if (searches[i]->expansions() >= options.max_expansions) {
        gave_up = true;
        continue;
      }
      if (const auto stop = searches[i]->improve(deadline, options.turn)) return finish(i, stop);
      if (searches[i]->finished() && searches[i]->solved()) return finish(i, std::nullopt);
      working = true;
    }
  }
  return finish(0, gave_up ? std::optional(Status::timed_out) : std::nullopt);
}

}  // namespace srmp::search
