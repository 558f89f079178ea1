#include "srmp/planning/strategies/group_search.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/smoothing/large_neighbourhood_search.hpp"
#include "srmp/planning/strategies/composite_sampling.hpp"
#include "srmp/planning/strategies/composite_search.hpp"
#include "srmp/planning/world_subset.hpp"

namespace srmp {

namespace {

constexpr std::uint64_t max_expansions = 16'000;  // on roadmaps
constexpr std::uint64_t max_attempts = 2048;      // of trees that may be better
/// Times the best: of a way that may be the best once each arm was looked at by itself; and of one that is so much
/// better that it is taken in place of a way of another kind, so that similar questions have similar answers.
constexpr double worth_a_look = 1.1, worth_a_change = 0.98;
constexpr double worth_trying = 1.05;       // times the length of the arms' ways alone
constexpr double share_for_shorter = 0.25;  // of the time that is left, once there is a way on roadmaps

multi::ConflictSearchOptions search_options(const PlannerOptions& options) {
  multi::ConflictSearchOptions search;
  const auto weights = [&](const auto& o) {
    search.low_level_weight = o.weight_low_level_heuristic;
    search.low_focal = o.low_level_focal_suboptimality;
    search.high_focal = o.high_level_focal_suboptimality;
  };
  if (const auto* ecbs = std::get_if<ECBS>(&options)) weights(*ecbs);
  if (const auto* xecbs = std::get_if<XECBS>(&options)) {
    weights(*xecbs);
    search.experience = search.priorities = true;
  }
  if (const auto* prioritised = std::get_if<Prioritised>(&options)) {
    search.low_level_weight = prioritised->weight_low_level_heuristic;
    search.experience = search.priorities_only = true;
  }
  if (const auto* any = std::get_if<Auto>(&options)) {
    search.low_level_weight = any->weight;
    search.low_focal = search.high_focal = 1.3;
    search.experience = search.priorities = true;
  }
  return search;
}

/// No ways of these arms are shorter together.
double direct(const MultiRobotWorld& world, const std::vector<std::size_t>& arms) {
  double sum = 0.0;
  for (const std::size_t i : arms) sum += world.direct(i);
  return sum;
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
  double lower = direct(world_, arms);
  std::optional<CompositeSpace> space;
  if (composite) space.emplace(world_, arms);
  std::size_t level = 0, levels = 1;
  for (std::uint64_t effort = 1;; effort *= 4) {
    if (composite) {
      for (; level < max_levels && level <= levels; ++level)
        if (auto path = on_roadmaps(arms, level, effort, options.bound() * lower, deadline, statistics))
          return {std::move(*path), lower};
      ++levels;
      // Trees of other sequences: some take a hundred times as long as others (Wedge, Branicky 2008).
      search::RrtConnect trees(rrt_space(*space), (effort - 1) << 16);  // none of those that anew() takes
      const auto way = trees.grow(2048 * effort, deadline);
      statistics.expansions += trees.attempts();
      note_memory(statistics, trees.memory());
      if (way) {
        JointPath path = space->path(*way);
        if (common.shortcut) path = shortened(std::move(path), world_, deadline);  // they go far astray
        if (path.length() <= options.bound() * lower) return {std::move(path), lower};
      }
      options.max_evaluations = 128 * effort;
    }
    WorldSubset team(world_, arms);
    const multi::ConflictSearchResult found = multi::conflict_search(team, options, deadline);
    statistics.expansions += found.statistics.low.expansions;
    statistics.generated += found.statistics.low.generated;
    statistics.tree_nodes += found.statistics.tree_nodes;
    statistics.edge_checks += found.statistics.low.evaluations;
    note_memory(statistics, found.statistics.memory);
    lower = std::max(lower, found.lower);
    if (found.status == Status::solved) return {joint_path(world_, arms, found.paths), lower};
    if (!composite || deadline.stop_requested()) require_solved(found);
    CompositeResult one = composite_search(*space, {.max_expansions = 16 * effort}, deadline);
    statistics.expansions += one.statistics.expansions;
    statistics.generated += one.statistics.generated;
    note_memory(statistics, one.statistics.memory);
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

CompositeRoadmap& GroupSearch::roadmaps(std::size_t level) {
  const std::lock_guard lock(mutex_);
  auto& slot = roadmaps_[level];
  if (!slot)
    slot = std::make_unique<CompositeRoadmap>(world_, CompositeRoadmapOptions{.retreats = std::size_t{2} << level});
  return *slot;
}

CompositeRoadmap::Result GroupSearch::on_roadmaps(const std::vector<std::size_t>& arms, std::size_t level,
                                                  const CompositeRoadmap::SearchBudget& effort,
                                                  const Deadline& deadline, PlanStatistics& statistics) {
  CompositeRoadmap::Result found = roadmaps(level).run(arms, effort, deadline);
  statistics.expansions += found.expansions;
  note_memory(statistics, found.memory);
  return found;
}

/// A path of length `most` at most. Then less and less greedily, here and on richer roadmaps: where arms may get by
/// each other in many ways, similar questions get similar answers only if these are near the best.
std::optional<JointPath> GroupSearch::on_roadmaps(const std::vector<std::size_t>& arms, std::size_t level,
                                                  std::uint64_t effort, double most, const Deadline& deadline,
                                                  PlanStatistics& statistics) {
  CompositeRoadmap::Result best = on_roadmaps(arms, level, {max_expansions, 2'000 * effort}, deadline, statistics);
  if (best.status != Status::solved || best.path.length() > most) return std::nullopt;
  // Other searches may follow this one.
  const Deadline until(share_for_shorter * deadline.remaining(), [&] { return deadline.cancelled(); });
  for (const std::size_t last = std::min(level + 1, max_levels - 1); level <= last; ++level)
    for (const double greed : {3.0, 1.5}) {
      if (!may_be_shorter(best.path) || until.stop_requested()) return std::move(best.path);
      const double below = std::min(best.cost, most);
      CompositeRoadmap::Result found =
          on_roadmaps(arms, level, {max_expansions, 8'000, greed, below}, until, statistics);
      if (found.status == Status::solved) best = std::move(found);
    }
  return std::move(best.path);
}

/// By number in the world, of arms that were planned on roadmaps.
std::vector<std::vector<Eigen::VectorXd>> GroupSearch::places_aside(const std::vector<std::size_t>& arms) const {
  std::vector<std::vector<Eigen::VectorXd>> places(world_.size());
  if (const CompositeRoadmap* first = roadmaps_.front().get())
    for (const std::size_t i : arms) places[i] = first->retreats(i);
  return places;
}

std::size_t GroupSearch::memory() const {
  std::size_t sum = 0;
  for (const auto& roadmaps : roadmaps_)
    if (roadmaps) sum += roadmaps->memory();
  return sum;
}

// --- better ways

/// Is there more than a little to gain on roadmaps, which are made of the arms' ways alone?
bool GroupSearch::may_be_shorter(const JointPath& known) const {
  double alone = 0.0;
  for (const std::size_t i : known.arms) alone += world_.alone(i);
  return known.length() > worth_trying * alone;
}

JointPath GroupSearch::each_by_itself(JointPath path, const Deadline& deadline) {
  const auto places = places_aside(path.arms);
  for (double before = search::infinity; path.length() < 0.99 * before;) {
    before = path.length();
    JointPath better = reroute_one_robot(path, world_, deadline, places);
    if (better.length() < before) path = shortened(std::move(better), world_, deadline);
  }
  return tightened(std::move(path), world_, deadline);
}

bool GroupSearch::may_change(const JointPath& known) const {
  return worth_a_change * known.length() > direct(world_, known.arms);
}

JointPath GroupSearch::anew(const JointPath& known, std::uint64_t sequence, const Deadline& deadline,
                            PlanStatistics& statistics) {
  const CompositeSpace space(world_, known.arms);
  search::RrtConnect trees(rrt_space(space), sequence);
  const auto way = trees.grow(max_attempts, deadline);
  statistics.expansions += trees.attempts();
  note_memory(statistics, trees.memory());
  if (!way) return known;
  JointPath path = shortened(space.path(*way), world_, deadline);
  if (path.length() >= worth_a_look * known.length()) return known;
  path = each_by_itself(std::move(path), deadline);
  return path.length() < worth_a_change * known.length() ? path : known;
}

}  // namespace srmp
