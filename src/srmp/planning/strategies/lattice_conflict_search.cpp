#include "srmp/planning/strategies/lattice_conflict_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace srmp {

namespace {

constexpr std::uint64_t first_evaluations = 4096;  // of the first round on each of the lattices; it grows fourfold

/// Steps of the lattices, as multiples of the resolution: coarse ones are quick, fine ones find narrow passages.
std::vector<double> scales(double resolution) {
  std::vector<double> all;
  for (const double scale : {6.0, 3.0, 1.5, 0.75}) {
    const double limited = std::min(scale, M_PI / 2.0 / resolution);
    if (all.empty() || limited < all.back()) all.push_back(limited);
  }
  return all;
}

}  // namespace

LatticeConflictSearch::LatticeConflictSearch(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                                             const PlannerOptions& options, PlanStatistics& statistics)
    : world_(world), robots_(robots), options_(options), statistics_(statistics) {
  for (const double scale : scales(world.options().resolution)) lattices_.push_back({.scale = scale});
}

Attempt LatticeConflictSearch::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  for (Lattices& lattices : lattices_) {
    if (lattices.last.status == Status::exhausted || deadline.stop_requested()) continue;
    lattices.last = search(lattices, first_evaluations << 2 * budget.round, deadline);
    if (lattices.last.status == Status::solved) return std::move(lattices.last);
  }
  const auto open = std::find_if(lattices_.begin(), lattices_.end(),
                                 [](const Lattices& lattices) { return lattices.last.status != Status::exhausted; });
  return open == lattices_.end() ? lattices_.back().last : open->last;
}

Attempt LatticeConflictSearch::search(Lattices& lattices, std::uint64_t evaluations, const Deadline& deadline) {
  if (!lattices.world) {
    std::vector<WorldTask> tasks;
    for (std::size_t i = 0; i < world_.size(); ++i) tasks.push_back(world_.task(i));
    MultiRobotWorld::Options options = world_.options();
    options.scale = lattices.scale;
    lattices.world = world_like(world_, std::move(tasks), options);
  }
  multi::ConflictSearchOptions options = conflict_search_options(options_);
  options.max_evaluations = evaluations;
  Attempt attempt = conflict_search_apart(*lattices.world, robots_, options_, options, "conflict-based search",
                                          deadline, statistics_);
  attempt.found.lower = std::exchange(attempt.lower, 0.0);  // of these lattices alone
  return attempt;
}

}  // namespace srmp
