#include "srmp/planner/multi_arm/group_search.hpp"

#include <algorithm>

#include "srmp/planner/multi_arm/arm_team.hpp"
#include "srmp/planner/multi_arm/composite_search.hpp"
#include "srmp/planner/multi_arm/composite_trees.hpp"
#include "srmp/planner/multi_arm/reroute.hpp"
#include "srmp/planner/phase_timer.hpp"

namespace srmp {

namespace {

constexpr std::uint64_t most_attempts = 2048;  // of trees that may be better
/// Times the best: of a way that may be the best once each arm was looked at by itself; and of one that is so much
/// better that it is taken in place of a way of another kind, so that similar questions have similar answers.
constexpr double worth_a_look = 1.1, worth_a_change = 0.98;

multi::ConflictSearchOptions search_options(const PlannerOptions& options) {
  multi::ConflictSearchOptions search;
  const auto weights = [&](const auto& o) {
    search.guide_weight = o.weight_low_level_heuristic;
    search.low_focal = o.low_level_focal_suboptimality;
    search.high_focal = o.high_level_focal_suboptimality;
  };
  if (const auto* ecbs = std::get_if<ECBS>(&options)) weights(*ecbs);
  if (const auto* xecbs = std::get_if<XECBS>(&options)) {
    weights(*xecbs);
    search.experience = search.priorities = true;
  }
  if (const auto* prioritised = std::get_if<Prioritised>(&options)) {
    search.guide_weight = prioritised->weight_low_level_heuristic;
    search.experience = search.priorities_only = true;
  }
  if (const auto* any = std::get_if<Auto>(&options)) {
    search.guide_weight = any->weight;
    search.low_focal = search.high_focal = 1.3;
    search.experience = search.priorities = true;
  }
  return search;
}

void note_memory(PlanStatistics& statistics, std::uint64_t held) {
  statistics.memory_bytes = std::max(statistics.memory_bytes, held);
}

}  // namespace

GroupWays GroupSearch::run(const std::vector<std::size_t>& arms, const Deadline& deadline, PlanStatistics& statistics) {
  const PhaseTimer timer(deadline, statistics.search_time_s);
  const CommonOptions& common = common_options(options_);
  const bool composite = std::holds_alternative<Auto>(options_) || std::holds_alternative<XECBS>(options_);
  multi::ConflictSearchOptions options = search_options(options_);
  double lower = 0.0;
  for (const std::size_t i : arms) lower += world_.direct(i);
  std::optional<CompositeSpace> space;
  std::optional<search::TwoTrees> trees;
  if (composite) trees.emplace(tree_space(space.emplace(world_, arms)));
  std::size_t level = 0, levels = 1;
  for (std::uint64_t effort = 1;; effort *= 4) {
    if (composite) {
      for (; level < most_levels && level <= levels; ++level)
        if (const auto path = on_roadmaps(arms, level, effort, deadline, statistics);
            path && path->length() <= options.bound() * lower)
          return {*path, lower};
      ++levels;
      const std::uint64_t before = trees->attempts();
      const auto way = trees->grow(2048 * effort, deadline);
      statistics.expansions += trees->attempts() - before;
      note_memory(statistics, trees->memory());
      if (way) {
        CoupledPath path = space->path(*way);
        if (common.shortcut) path = shortened(std::move(path), world_, deadline);  // they go far astray
        if (path.length() <= options.bound() * lower) return {std::move(path), lower};
      }
      options.max_evaluations = 128 * effort;
    }
    ArmTeam team(world_, arms);
    const multi::ConflictSearchResult found = multi::conflict_search(team, options, deadline);
    statistics.expansions += found.statistics.low.expansions;
    statistics.generated += found.statistics.low.generated;
    statistics.tree_nodes += found.statistics.tree_nodes;
    statistics.edge_checks += found.statistics.low.evaluations;
    const std::uint64_t beside = trees ? trees->memory() : 0;
    note_memory(statistics, beside + found.statistics.memory);
    lower = std::max(lower, found.lower);
    if (found.status == Status::solved) return {coupled_path(world_, arms, found.paths), lower};
    if (!composite || deadline.stop_requested()) require_solved(found);
    CompositeResult one = composite_search(*space, {.max_expansions = 16 * effort}, deadline);
    statistics.expansions += one.statistics.expansions;
    statistics.generated += one.statistics.generated;
    note_memory(statistics, beside + one.statistics.memory);
    if (one.status == Status::solved && one.path.length() <= options.bound() * lower)
      return {std::move(one.path), lower};
    const bool no_more = found.status == Status::exhausted && one.status == Status::exhausted;
    if (no_more || deadline.stop_requested()) require_solved(found);
  }
}

void GroupSearch::require_solved(const multi::ConflictSearchResult& found) const {
  const CommonOptions& common = common_options(options_);
  const std::string work = std::to_string(found.statistics.tree_nodes) + " nodes of the constraint tree, " +
                           std::to_string(found.statistics.low.expansions) + " states expanded";
  switch (found.status) {
    case Status::solved: return;
    case Status::cancelled:
      throw PlanningError(found.status, "the plan was cancelled during the search (" + work + ")");
    case Status::exhausted:
      throw PlanningError(found.status, "the robots' " + describe_lattices() +
                                            " hold no paths on which they do not meet (" + work +
                                            "); a finer resolution, or other primitives, may hold some");
    default:
      throw PlanningError(Status::timed_out,
                          "no paths within the time limit of " + to_text(common.time_limit) + " s (" + work + ")");
  }
}

std::string GroupSearch::describe_lattices() const {
  return "lattices of " + to_text(common_options(options_).resolution) + " degrees" +
         (world_.has_own_primitives() ? " or of their own primitives" : "");
}

// --- roadmaps

RoadmapSearch& GroupSearch::roadmaps(std::size_t level) {
  const std::lock_guard lock(mutex_);
  auto& slot = roadmaps_[level];
  if (!slot) slot = std::make_unique<RoadmapSearch>(world_, 2 << level);
  return *slot;
}

/// On roadmaps that are the richer the more effort there was before.
std::optional<CoupledPath> GroupSearch::on_roadmaps(const std::vector<std::size_t>& arms, std::size_t level,
                                                    std::uint64_t effort, const Deadline& deadline,
                                                    PlanStatistics& statistics) {
  RoadmapSearch::Result found = roadmaps(level).run(arms, 16'000, 2'000 * effort, deadline);
  statistics.expansions += found.expansions;
  note_memory(statistics, found.memory);
  if (found.status != Status::solved) return std::nullopt;
  return std::move(found.path);
}

/// By number in the world, of arms that were planned on roadmaps.
std::vector<std::vector<Eigen::VectorXd>> GroupSearch::places_aside(const std::vector<std::size_t>& arms) const {
  std::vector<std::vector<Eigen::VectorXd>> places(world_.size());
  if (const RoadmapSearch* first = roadmaps_.front().get())
    for (const std::size_t i : arms) places[i] = first->places_aside(i);
  return places;
}

std::size_t GroupSearch::memory() const {
  std::size_t sum = 0;
  for (const auto& roadmaps : roadmaps_)
    if (roadmaps) sum += roadmaps->memory();
  return sum;
}

// --- better ways

CoupledPath GroupSearch::each_by_itself(CoupledPath path, const Deadline& deadline) {
  const auto places = places_aside(path.arms);
  for (double before = search::infinity; path.length() < 0.99 * before;) {
    before = path.length();
    CoupledPath better = rerouted(path, world_, deadline, places);
    if (better.length() < before) path = shortened(std::move(better), world_, deadline);
  }
  return tightened(std::move(path), world_, deadline);
}

CoupledPath GroupSearch::anew(const CoupledPath& known, std::uint64_t sequence, const Deadline& deadline,
                              PlanStatistics& statistics) {
  const CompositeSpace space(world_, known.arms);
  search::TwoTrees trees(tree_space(space), sequence);
  const auto way = trees.grow(most_attempts, deadline);
  statistics.expansions += trees.attempts();
  note_memory(statistics, trees.memory());
  if (!way) return known;
  CoupledPath path = shortened(space.path(*way), world_, deadline);
  if (path.length() >= worth_a_look * known.length()) return known;
  path = each_by_itself(std::move(path), deadline);
  return path.length() < worth_a_change * known.length() ? path : known;
}

}  // namespace srmp
