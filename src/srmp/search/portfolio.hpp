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

/// The searches of a portfolio, which go on round after round.
template <Graph G, Heuristic H>
class Portfolio {
 public:
  using Make = std::function<PortfolioMember<G, H>(std::size_t)>;

  /// `make(i)` is called when member i of `count` has its first slice; graph and heuristic must outlive this. Throws
  /// InvalidArgument for no members.
  Portfolio(std::size_t count, Make make, const PortfolioOptions& options)
      : make_(std::move(make)), options_(options), searches_(count) {
    require_weight(options.weight, "weight");
    if (count == 0) throw InvalidArgument("a portfolio needs at least one search");
    if (options.slice == 0) throw InvalidArgument("a portfolio's slice must be at least one expansion");
  }

  /// A slice of every search that has not finished. Nothing: another round may help. Throws as AlternatingSearch does.
  std::optional<PortfolioResult> round(const Deadline& deadline) {
    bool working = false, gave_up = false;
    for (std::size_t i = 0; i < searches_.size(); ++i) {
      if (!searches_[i]) begin(i);
      if (searches_[i]->finished()) continue;
      if (searches_[i]->expansions() >= options_.max_expansions) {
        gave_up = true;
        continue;
      }
      if (const auto stop = searches_[i]->improve(deadline, options_.slice)) return result(i, stop);
      if (searches_[i]->finished() && searches_[i]->solved()) return result(i, std::nullopt);
      working = true;
    }
    if (working) return std::nullopt;
    return result(0, gave_up ? std::optional(Status::timed_out) : std::nullopt);
  }

  /// Of all searches together.
  Statistics statistics() const {
    Statistics sum;
    for (const auto& search : searches_) {
      if (!search) continue;
      const Statistics s = search->statistics();
      sum.expansions += s.expansions;
      sum.generated += s.generated;
      sum.evaluations += s.evaluations;
      sum.memory += s.memory;
    }
    return sum;
  }

 private:
  using Search = AlternatingSearch<G, H>;

  void begin(std::size_t i) {
    PortfolioMember<G, H> member = make_(i);
    searches_[i] =
        std::make_unique<Search>(*member.graph, *member.heuristic, member.inadmissible_heuristics, options_.weight);
    searches_[i]->add_starts(member.starts);
  }

  PortfolioResult result(std::size_t winner, std::optional<Status> stop) {
    for (std::size_t i = 0; i < searches_.size(); ++i)  // stopped before the proof: the cheapest path
      if (stop && searches_[i] && searches_[i]->cost() < searches_[winner]->cost()) winner = i;
    PortfolioResult found{{}, winner, std::vector<char>(searches_.size(), 0)};
    found.result = searches_[winner]->result(stop);
    found.result.statistics = statistics();
    for (std::size_t i = 0; i < searches_.size(); ++i)
      found.exhausted[i] = searches_[i] && searches_[i]->finished() && !searches_[i]->solved();
    return found;
  }

  Make make_;
  PortfolioOptions options_;
  std::vector<std::unique_ptr<Search>> searches_;
};

/// Rounds of a portfolio until it has a result. Throws as Portfolio does.
template <Graph G, Heuristic H, class Make>
PortfolioResult portfolio(std::size_t count, Make&& make, const PortfolioOptions& options, const Deadline& deadline) {
  Portfolio<G, H> searches(count, std::forward<Make>(make), options);
  while (true)
    if (auto result = searches.round(deadline)) return *std::move(result);
}

}  // namespace srmp::search
