#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "srmp/search/weighted_search.hpp"

/// Several weighted A* searches of one question, each in a graph of its own, a few expansions at a time in turns: as
/// quick as a few times the quickest of them, whichever that is.
///
/// Paper: Huberman, Lukose, Hogg 1997, "An Economics Approach to Hard Computational Problems" (portfolios); the
/// searches are weighted_astar's. Guarantee: cost <= bound * optimal cost in the graph of the search that finished
/// first, bound <= weight. `exhausted` means that no graph holds a path. Turns are counted in expansions, so the answer
/// does not depend on time. Needs: of every graph and heuristic what weighted_astar needs.
namespace srmp::search {

struct PortfolioOptions {
  double weight{1.0};      ///< >= 1
  std::uint64_t turn{32};  ///< > 0: expansions of one search before it is the next one's turn
};

template <Graph G, Heuristic H>
struct PortfolioMember {
  G* graph;
  std::vector<StateId> starts;
  H* heuristic;
};

struct PortfolioResult {
  Result result;         ///< statistics: of all searches together
  std::size_t winner{};  ///< member that found it
};

/// Throws InvalidArgument for no members and as weighted_astar does.
template <Graph G, Heuristic H>
PortfolioResult portfolio(std::span<const PortfolioMember<G, H>> members, const PortfolioOptions& options,
                          const Deadline& deadline) {
  require_weight(options.weight, "weight");
  if (members.empty()) throw InvalidArgument("a portfolio needs at least one search");
  if (options.turn == 0) throw InvalidArgument("a portfolio's turn must be at least one expansion");
  using Search = WeightedSearch<G, H>;
  std::vector<std::unique_ptr<Search>> searches;
  for (const auto& member : members) {
    searches.push_back(
        std::make_unique<Search>(*member.graph, *member.heuristic, options.weight, Search::Expand::once));
    searches.back()->add_starts(member.starts);
  }
  const auto finish = [&](std::size_t winner, std::optional<Status> stop) {
    PortfolioResult answer{searches[winner]->result(options.weight, stop), winner};
    answer.result.statistics = {};
    for (const auto& search : searches) {
      const Statistics s = search->statistics();
      answer.result.statistics.expansions += s.expansions;
      answer.result.statistics.generated += s.generated;
      answer.result.statistics.evaluations += s.evaluations;
      answer.result.statistics.memory += s.memory;
    }
    return answer;
  };
  for (bool working = true; working;) {
    working = false;
    for (std::size_t i = 0; i < searches.size(); ++i) {
      if (searches[i]->finished()) continue;
      if (const auto stop = searches[i]->improve(deadline, options.turn)) return finish(i, stop);
      if (searches[i]->finished() && searches[i]->solved()) return finish(i, std::nullopt);
      working = true;
    }
  }
  return finish(0, std::nullopt);
}

}  // namespace srmp::search
