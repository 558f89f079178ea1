#include "srmp/planning/strategies/group_strategies.hpp"

#include <algorithm>
#include <bit>

#include "srmp/core/error.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/planning/smoothing/joint_shortcut.hpp"
#include "srmp/planning/strategies/composite_sampling.hpp"
#include "srmp/planning/strategies/composite_search.hpp"
#include "srmp/planning/strategies/one_by_one.hpp"
#include "srmp/planning/trace_recorders.hpp"
#include "srmp/planning/world_paths.hpp"
#include "srmp/planning/world_subset.hpp"

namespace srmp {

namespace {

/// Work of the first round; it grows fourfold from round to round, of robots that move one after the other twofold.
struct GroupBudget {
  std::uint64_t path_expansions{512};             ///< of the first level, before there are retreats; the same
  std::uint64_t roadmap_expansions{4'096};        ///< until there is a path; the same in every round
  std::uint64_t roadmap_checks{2'000};            ///< of motions of two robots, until there is a path
  std::uint64_t shorter_expansions{16'000};       ///< of each search after it; the same in every round
  std::uint64_t shorter_checks{8'000};            ///< of each search after it; the same in every round
  std::vector<double> shorter_weights{3.0, 1.5};  ///< of those searches
  double worth_shortening{1.05};  ///< only if the path is longer by this factor than the robots' paths alone
  std::uint64_t rrt_attempts{4'096};
  std::uint64_t shortest_trees{1'024};      ///< attempts before trees begin anew for the first time; the same
  std::uint64_t conflict_evaluations{128};  ///< of lattice edges
  /// Of each search of the composite lattices, which rarely find what other trees do not: it grows twofold.
  std::uint64_t lattice_expansions{16};
};
const GroupBudget budgets;

std::uint64_t growth(const AttemptBudget& budget) { return std::uint64_t{1} << 2 * budget.round; }

void note_memory(PlanStatistics& statistics, std::uint64_t held) {
  statistics.memory_bytes = std::max(statistics.memory_bytes, held);
}

Attempt accepted(JointPath path, const std::string& found_by) {
  Attempt attempt{.status = Status::solved};
  attempt.found.cost = path.length();
  attempt.found.path = std::move(path);
  attempt.found.graph = every_path;
  attempt.found.found_by = found_by;
  return attempt;
}

std::string stopped_reason(Status status, const CommonOptions& options, const std::string& work) {
  if (status == Status::cancelled) return "the plan was cancelled during the search (" + work + ")";
  return "no paths within the time limit of " + to_text(options.time_limit) + " s (" + work + ")";
}

}  // namespace

// --- one robot after the other

Attempt OneByOneStrategy::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  OneByOneOptions options;
  for (std::uint64_t* attempts :
       {&options.attempts, &options.attempts_of_all, &options.pair_attempts, &options.pair_attempts_of_all,
        &options.known_attempts, &options.known_attempts_of_all})
    *attempts <<= budget.round;
  options.max_cost = budget.max_cost;
  options.seed = static_cast<std::uint64_t>(budget.round);
  if (!goals_) {
    goals_ = paths_to_free_goals(world_, robots_, deadline);
    statistics_.samples += goals_->attempts;
  }
  OneByOneResult found = one_by_one(world_, robots_, goals_->paths, known_, options, deadline);
  statistics_.expansions += found.work.expansions;
  statistics_.samples += found.work.attempts;
  note_memory(statistics_, found.work.memory);
  if (!found.path) return {};
  return accepted(std::move(*found.path), "one robot after the other");
}

// --- roadmaps

Attempt CompositeRoadmapStrategy::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  const auto last = static_cast<std::size_t>(budget.round) + 1;
  for (; next_level_ < RoadmapLevels::count && next_level_ <= last; ++next_level_)
    if (auto path = find(next_level_, budget, deadline)) return accepted(std::move(*path), "composite roadmap");
  return {};
}

std::optional<JointPath> CompositeRoadmapStrategy::find(std::size_t level, const AttemptBudget& budget,
                                                        const Deadline& deadline) {
  const auto run = [&](const CompositeRoadmap::SearchBudget& work) {
    CompositeRoadmap::Result found = roadmaps_.at(level).run(robots_, work, deadline);
    statistics_.expansions += found.expansions;
    note_memory(statistics_, found.memory);
    return found;
  };
  CompositeRoadmap::Result best = run({.max_expansions = budgets.roadmap_expansions,
                                       .max_checks = budgets.roadmap_checks * growth(budget),
                                       .path_expansions = level == 0 ? budgets.path_expansions : 0});
  if (best.status != Status::solved || best.path.length() > budget.max_cost) return std::nullopt;
  for (const std::size_t last = std::min(level + 1, RoadmapLevels::count - 1); level <= last; ++level)
    for (const double weight : budgets.shorter_weights) {
      if (!may_be_shorter(best.path) || deadline.stop_requested()) return std::move(best.path);
      const double max_cost = std::min(best.cost, budget.max_cost);
      CompositeRoadmap::Result found = run({.max_expansions = budgets.shorter_expansions,
                                            .max_checks = budgets.shorter_checks,
                                            .weight = weight,
                                            .max_cost = max_cost});
      if (found.status == Status::exhausted) break;  // no weight finds a shorter path on this level
      if (found.status == Status::solved) best = std::move(found);
    }
  return std::move(best.path);
}

/// Is there more than a little to gain on roadmaps, which are made of the robots' paths alone?
bool CompositeRoadmapStrategy::may_be_shorter(const JointPath& path) const {
  double alone = 0.0;
  for (const std::size_t i : path.robots) alone += world_.alone(i);
  return path.length() > budgets.worth_shortening * alone;
}

// --- RRT-Connect

namespace {

/// Element number n = 0, 1, 2, … of 1, 1, 2, 1, 1, 2, 4, …
std::uint64_t luby(std::uint64_t n) {
  for (++n;;) {
    const std::uint64_t power = std::bit_floor(n);
    if (n + 1 == 2 * power) return power;
    n -= power - 1;
  }
}

}  // namespace

CompositeRrtStrategy::CompositeRrtStrategy(MultiRobotWorld& world, const CompositeSpace& space,
                                           const std::vector<const JointPath*>& known, const CommonOptions& options,
                                           PlanStatistics& statistics)
    : world_(world), space_(space), options_(options), statistics_(statistics) {
  const JointPath all = side_by_side(known);
  if (!known.empty() && all.robots.size() == space.size()) known_ = space.configurations(all);
}

std::optional<std::vector<Eigen::VectorXd>> CompositeRrtStrategy::grow_trees(std::uint64_t attempts,
                                                                             const Deadline& deadline) {
  while (attempts > 0 && !deadline.stop_requested()) {
    const std::uint64_t now = std::min(attempts, budgets.shortest_trees * luby(restarts_));
    const std::uint64_t number = restarts_++, seed = number << 16;  // none of those that GroupPlanner::replan takes
    search::RrtConnect trees(rrt_space(space_), seed);
    if (number % 2 == 1 && !known_.empty()) trees.follow(known_, deadline);
    const auto rows = trees.grow(now, deadline);
    statistics_.samples += trees.attempts();
    note_memory(statistics_, trees.memory());
    if (rows) return rows;
    attempts -= now;
  }
  return std::nullopt;
}

Attempt CompositeRrtStrategy::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  const auto rows = grow_trees(budgets.rrt_attempts * growth(budget), deadline);
  if (!rows) {
    const Status status = stop_status(deadline).value_or(Status::timed_out);
    const std::string work = std::to_string(statistics_.samples) + " configurations sampled";
    return {.status = status, .reason = stopped_reason(status, options_, work)};
  }
  JointPath path = space_.path(*rows);
  // Random paths make large detours, and the budget is one of shortened paths.
  if (options_.shortcut) path = shortened(std::move(path), world_, deadline);
  return path.length() <= budget.max_cost ? accepted(std::move(path), "composite RRT-Connect") : Attempt{};
}

// --- conflict-based search

namespace {

std::string no_paths_reason(const MultiRobotWorld& world, const PlannerOptions& options,
                            const multi::ConflictSearchResult& found) {
  const std::string work = std::to_string(found.statistics.tree_nodes) + " nodes of the constraint tree, " +
                           std::to_string(found.statistics.low.expansions) + " states expanded";
  if (found.status != Status::exhausted) return stopped_reason(found.status, common_options(options), work);
  return "the robots' " + describe_lattices(world, options) + " hold no paths without collisions (" + work +
         "); a finer resolution, or other primitives, may hold some";
}

}  // namespace

Attempt conflict_search_attempt(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                                const PlannerOptions& options, multi::ConflictSearchOptions search_options,
                                const std::string& found_by, const Deadline& deadline, PlanStatistics& statistics) {
  WorldSubset subset(world, robots);
  search_options.on_opened = constraint_tree_recorder(world, robots);
  const multi::ConflictSearchResult found = multi::conflict_search(subset, search_options, deadline);
  statistics.expansions += found.statistics.low.expansions;
  statistics.generated += found.statistics.low.generated;
  statistics.tree_nodes += found.statistics.tree_nodes;
  statistics.edge_checks += found.statistics.low.evaluations;
  note_memory(statistics, found.statistics.memory);
  Attempt attempt{.status = found.status};
  if (found.status == Status::solved) {
    attempt = accepted(joint_path(world, robots, found.paths), found_by);
    attempt.found.graph = describe_graph(world, options);
  } else {
    attempt.reason = no_paths_reason(world, options, found);
  }
  attempt.lower = found.lower;
  return attempt;
}

Attempt conflict_search_apart(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                              const PlannerOptions& options, const multi::ConflictSearchOptions& search_options,
                              const std::string& found_by, const Deadline& deadline, PlanStatistics& statistics) {
  world.stop_at(deadline);
  const std::uint64_t states = world.states(), checks = world.pair_checks();
  Attempt attempt = conflict_search_attempt(world, robots, options, search_options, found_by, deadline, statistics);
  statistics.states += world.states() - states;
  statistics.edge_checks += world.pair_checks() - checks;
  return attempt;
}

std::unique_ptr<MultiRobotWorld> world_like(const MultiRobotWorld& world, std::vector<WorldTask> tasks,
                                            const MultiRobotWorld::Options& options) {
  return std::make_unique<MultiRobotWorld>(world.checkers(), std::move(tasks), options);
}

ConflictSearchStrategy::ConflictSearchStrategy(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                                               const PlannerOptions& options, bool alone, PlanStatistics& statistics)
    : world_(world),
      robots_(robots),
      options_(options),
      search_options_(conflict_search_options(options)),
      alone_(alone),
      statistics_(statistics) {}

Attempt ConflictSearchStrategy::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  if (!alone_) search_options_.max_evaluations = budgets.conflict_evaluations * growth(budget);
  return conflict_search_attempt(world_, robots_, options_, search_options_, "conflict-based search", deadline,
                                 statistics_);
}

multi::ConflictSearchOptions conflict_search_options(const PlannerOptions& options) {
  multi::ConflictSearchOptions search;
  const auto take_weights = [&](const auto& o) {
    search.low_level_weight = o.weight_low_level_heuristic;
    search.low_focal = o.low_level_focal_suboptimality;
    search.high_focal = o.high_level_focal_suboptimality;
  };
  if (const auto* ecbs = std::get_if<ECBS>(&options)) take_weights(*ecbs);
  if (const auto* xecbs = std::get_if<XECBS>(&options)) {
    take_weights(*xecbs);
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

std::string describe_lattices(const MultiRobotWorld& world, const PlannerOptions& options) {
  return "lattices of " + to_text(world.options().scale * common_options(options).resolution) + " degrees" +
         (world.has_own_primitives() ? " or of their own primitives" : "");
}

std::string describe_graph(const MultiRobotWorld& world, const PlannerOptions& options) {
  return "the robots' " + describe_lattices(world, options) + ", in steps of " + to_text(world.step_time()) +
         " s, waiting counted";
}

// --- the composite lattice

Attempt CompositeLatticeStrategy::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  CompositeResult found =
      composite_search(space_, {.max_expansions = budgets.lattice_expansions << budget.round}, deadline);
  statistics_.expansions += found.statistics.expansions;
  statistics_.generated += found.statistics.generated;
  note_memory(statistics_, found.statistics.memory);
  if (found.status == Status::solved && found.path.length() <= budget.max_cost)
    return accepted(std::move(found.path), "composite lattice");
  return {.status = found.status == Status::solved ? Status::timed_out : found.status};
}

}  // namespace srmp
