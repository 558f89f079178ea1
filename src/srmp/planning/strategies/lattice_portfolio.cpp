#include "srmp/planning/strategies/lattice_portfolio.hpp"

#include <algorithm>

namespace srmp {

LatticePortfolio::LatticePortfolio(LatticeFamily& family, const LatticePortfolioOptions& options)
    : family_(family), options_(options) {
  for (const double scale : options.scales)
    for (const bool backward : options.directions) members_.push_back({nullptr, {}, backward, scale});
  searches_ = std::make_unique<Searches>(
      members_.size(), [this](std::size_t i) { return make_search(members_[i]); },
      search::PortfolioOptions{.weight = options.weight, .max_expansions = options.max_expansions});
}

Attempt LatticePortfolio::attempt(const AttemptBudget&, const Deadline& deadline) {
  const auto found = searches_->round(deadline);
  if (!found) return {.status = Status::timed_out};
  const auto describe = [&](const Member& member) { return family_.describe(member.backward, member.scale); };
  exhausted_graphs_.clear();
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (found->exhausted[i]) exhausted_graphs_.push_back(describe(members_[i]));
  if (found->result.status == Status::solved) {
    const Member& winner = members_[found->winner];
    return {.status = Status::solved,
            .found = family_.path_of(found->result, *winner.lattice, winner.backward, winner.scale)};
  }
  const std::size_t count = members_.size();
  const std::string no_path = count > 1 ? "none of the " + std::to_string(count) + " lattices holds a"
                                        : describe(members_.front()) + " holds no";
  return {.status = found->result.status, .reason = family_.no_path_sentence(found->result, no_path)};
}

Attempt LatticePortfolio::run(const Deadline& deadline) {
  while (true) {
    Attempt result = attempt({}, deadline);
    if (result.status != Status::timed_out || !result.reason.empty()) return result;
  }
}

search::Statistics LatticePortfolio::statistics() const {
  search::Statistics sum = searches_->statistics();
  for (const Member& member : members_)
    if (member.lattice) sum.memory += member.lattice->memory();
  return sum;
}

std::uint64_t LatticePortfolio::states() const {
  std::uint64_t sum = 0;
  for (const Member& member : members_)
    if (member.lattice) sum += member.lattice->size();
  return sum;
}

search::PortfolioMember<Lattice, search::AnyHeuristic> LatticePortfolio::make_search(Member& member) const {
  member.lattice.reset(new Lattice(family_.lattice(member.backward, member.scale)));
  Lattice& lattice = *member.lattice;
  member.anchor = [&lattice, limit = options_.max_length](search::StateId s) {
    const double to_goal = lattice.distance_to_targets(s);
    if (limit == search::infinity || to_goal + lattice.distance_from_roots(s) < limit + 1e-9) return to_goal;
    return search::infinity;
  };
  return {&lattice, lattice.starts(), &member.anchor, family_.inadmissible_heuristics(lattice)};
}

}  // namespace srmp
