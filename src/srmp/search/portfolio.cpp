#include "srmp/search/portfolio.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "srmp/core/error.hpp"

namespace srmp::search {

Portfolio::Portfolio(std::size_t count, Make make, const PortfolioOptions& options)
    : make_(std::move(make)), options_(options), searches_(count) {
  if (count == 0) throw InvalidArgument("a portfolio needs at least one search");
  if (options_.slices.empty()) options_.slices.assign(count, options.slice);
  if (options_.slices.size() != count)
    throw InvalidArgument("a portfolio has " + std::to_string(options_.slices.size()) + " slices for " +
                          std::to_string(count) + " searches");
  if (std::count(options_.slices.begin(), options_.slices.end(), 0) > 0)
    throw InvalidArgument("a portfolio's slice must be at least one expansion");
}

std::optional<PortfolioResult> Portfolio::round(const Deadline& deadline) {
  bool working = false, gave_up = false;
  for (std::size_t i = 0; i < searches_.size(); ++i) {
    if (!searches_[i]) searches_[i] = make_(i);
    ResumableSearch& search = *searches_[i];
    if (search.finished()) continue;
    if (search.statistics().expansions >= options_.max_expansions) {
      gave_up = true;
      continue;
    }
    if (const auto stop = search.improve(deadline, options_.slices[i])) return result(cheapest(i), stop);
    if (options_.first_only && search.finished() && search.solved()) return result(i, std::nullopt);
    working = true;
  }
  if (working) return std::nullopt;
  return result(cheapest(0), gave_up ? std::optional(Status::timed_out) : std::nullopt);
}

/// Member `winner`, or one whose path costs less.
std::size_t Portfolio::cheapest(std::size_t winner) const {
  for (std::size_t i = 0; i < searches_.size(); ++i)
    if (searches_[i] && searches_[i]->cost() < searches_[winner]->cost()) winner = i;
  return winner;
}

PortfolioResult Portfolio::result(std::size_t winner, std::optional<Status> stop) const {
  PortfolioResult found{searches_[winner]->result(stop), winner, std::vector<char>(searches_.size(), 0)};
  found.result.statistics = statistics();
  for (std::size_t i = 0; i < searches_.size(); ++i)
    found.exhausted[i] = searches_[i] && searches_[i]->finished() && !searches_[i]->solved();
  return found;
}

Statistics Portfolio::statistics() const {
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

PortfolioResult portfolio(std::size_t count, Portfolio::Make make, const PortfolioOptions& options,
                          const Deadline& deadline) {
  Portfolio searches(count, std::move(make), options);
  while (true)
    if (auto result = searches.round(deadline)) return *std::move(result);
}

}  // namespace srmp::search
