#include "srmp/planning/strategies/lattice_portfolio.hpp"

#include <algorithm>
#include <set>

namespace srmp {

namespace {

std::vector<LatticeMember> members_of(const LatticePortfolioOptions& options) {
  std::vector<LatticeMember> members;
  for (const double scale : options.scales)
    for (std::size_t end = 0; end < options.ends.size(); ++end)
      for (std::size_t variant = 0; variant < options.variants; ++variant)
        members.push_back(
            {.choice = {.from = options.ends[end], .scale = scale}, .slice = options.slices[end], .variant = variant});
  return members;
}

std::vector<std::uint64_t> slices_of(const std::vector<LatticeMember>& members) {
  std::vector<std::uint64_t> slices;
  for (const LatticeMember& member : members) slices.push_back(member.slice);
  return slices;
}

}  // namespace

LatticePortfolio::LatticePortfolio(LatticeFamily& family, const LatticePortfolioOptions& options)
    : family_(family),
      options_(options),
      members_(members_of(options)),
      searches_(members_.size(), [this](std::size_t i) { return begin(members_[i]); },
                {.slices = slices_of(members_),
                 .max_expansions = options.max_expansions,
                 .first_only = options.first_only,
                 .more_expansions = options.more_expansions}) {}

Attempt LatticePortfolio::attempt(const AttemptBudget&, const Deadline& deadline) {
  const auto found = searches_.round(deadline);
  if (!found) return {.status = Status::timed_out};
  const auto describe = [&](const LatticeMember& member) { return family_.describe(member.choice); };
  exhausted_graphs_.clear();
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (found->exhausted[i]) exhausted_graphs_.push_back(describe(members_[i]));
  if (found->result.status == Status::solved) {
    winner_ = found->winner;
    const LatticeMember& winner = members_[winner_];
    return {.status = Status::solved, .found = family_.path_of(found->result, *winner.lattice, winner.choice)};
  }
  std::set<std::string> lattices;  // several searches may share one
  for (const LatticeMember& member : members_) lattices.insert(describe(member));
  const std::size_t count = lattices.size();
  const std::string no_path =
      count > 1 ? "none of the " + std::to_string(count) + " lattices holds a" : *lattices.begin() + " holds no";
  return {.status = found->result.status, .reason = family_.no_path_sentence(found->result, no_path)};
}

Attempt LatticePortfolio::run(const Deadline& deadline) {
  while (true) {
    Attempt result = attempt({}, deadline);
    if (result.status != Status::timed_out || !result.reason.empty()) return result;
  }
}

search::Statistics LatticePortfolio::statistics() const {
  search::Statistics sum = searches_.statistics();
  for (const LatticeMember& member : members_)
    if (member.lattice) sum.memory += member.lattice->memory();
  for (const auto& [lattice, tree] : trees_) sum.memory += tree.memory();
  return sum;
}

std::uint64_t LatticePortfolio::states() const {
  std::uint64_t sum = 0;
  for (const LatticeMember& member : members_)
    if (member.lattice) sum += member.lattice->size();
  return sum;
}

std::unique_ptr<search::ResumableSearch> LatticePortfolio::begin(LatticeMember& member) {
  member.lattice.reset(new Lattice(family_.lattice(member.choice)));
  if (options_.ends.size() > 1) connect(*member.lattice, member.choice);
  return options_.search ? options_.search(member) : alternating_search(member);
}

/// With the searches of the same steps from the other end.
void LatticePortfolio::connect(Lattice& lattice, const LatticeChoice& choice) {
  const auto tree = [&](SearchFrom end) -> search::ConfigurationTree& {
    return trees_.try_emplace({end, choice.scale}, lattice.wraps()).first->second;
  };
  lattice.connect_trees(tree(choice.from), tree(choice.from_goals() ? SearchFrom::start : SearchFrom::goals));
}

std::unique_ptr<search::ResumableSearch> LatticePortfolio::alternating_search(LatticeMember& member) const {
  Lattice& lattice = *member.lattice;
  member.heuristics.emplace_back([&lattice, limit = options_.max_length](search::StateId s) {
    const double to_goal = lattice.distance_to_targets(s);
    if (limit == search::infinity || to_goal + lattice.distance_from_roots(s) < limit + 1e-9) return to_goal;
    return search::infinity;
  });
  return std::make_unique<search::AlternatingSearch<Lattice, search::AnyHeuristic>>(
      lattice, lattice.starts(), member.heuristics.front(), family_.inadmissible_heuristics(lattice), options_.weight);
}

}  // namespace srmp
