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
  if (!(options_.more_expansions.fraction >= 0.0))
    throw InvalidArgument("a portfolio's more_expansions.fraction is " + to_text(options_.more_expansions.fraction) +
                          ", it must be at least 0");
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
    if (const auto stop = search.improve(deadline, options_.slices[i]))
      return result(cheapest(first_.value_or(i)), stop);
    if (options_.first_only && !first_ && search.finished() && search.solved()) {
      first_ = i;
      enough_ = enough_expansions();
    }
    if (first_ && statistics().expansions >= enough_) return result(cheapest(*first_), std::nullopt);
    working = true;
  }
  if (working) return std::nullopt;
  return result(cheapest(first_.value_or(0)), gave_up ? std::optional(Status::timed_out) : std::nullopt);
}

std::uint64_t Portfolio::enough_expansions() const {
  const std::uint64_t made = statistics().expansions;
  const double more = std::min(options_.more_expansions.fraction * static_cast<double>(made), 1e18);
  return made + std::min(options_.more_expansions.most, static_cast<std::uint64_t>(more));
}

/// Member `winner`, or one whose path costs less; once one has finished, of those that have: their bounds are proved.
std::size_t Portfolio::cheapest(std::size_t winner) const {
  for (std::size_t i = 0; i < searches_.size(); ++i) {
    const bool counts = searches_[i] && (!first_ || searches_[i]->finished());
    if (counts && searches_[i]->cost() < searches_[winner]->cost()) winner = i;
  }
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
