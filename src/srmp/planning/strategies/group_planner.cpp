#include "srmp/planning/strategies/group_planner.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/smoothing/joint_shortcut.hpp"
#include "srmp/planning/smoothing/large_neighbourhood_search.hpp"
#include "srmp/planning/strategies/composite_sampling.hpp"
#include "srmp/planning/strategies/experience_conflict_search.hpp"
#include "srmp/planning/strategies/group_strategies.hpp"
#include "srmp/planning/strategies/lattice_conflict_search.hpp"

namespace srmp {

FoundPath GroupPlanner::find(const std::vector<std::size_t>& robots, const std::vector<const JointPath*>& known,
                             const Deadline& deadline, PlanStatistics& statistics) {
  const PhaseTimer timer(deadline, statistics.search_time_s);
  const bool portfolio = std::holds_alternative<Auto>(options_) && !constrained(robots);
  const bool trees_alone = std::holds_alternative<RRTConnect>(options_);
  std::optional<CompositeSpace> space;
  Strategies strategies;
  if (portfolio) strategies.push_back(std::make_unique<OneByOneStrategy>(world_, robots, known, statistics));
  if (portfolio || trees_alone) {
    space.emplace(world_, robots);
    strategies.push_back(std::make_unique<CompositeRrtStrategy>(
        world_, *space, portfolio ? known : std::vector<const JointPath*>{}, common_options(options_), statistics));
  }
  if (portfolio)
    strategies.push_back(std::make_unique<CompositeRoadmapStrategy>(world_, robots, roadmaps_, statistics));
  const auto with_graph = [&](FoundPath found) {
    const bool is_of_lattices = found.lower > direct(robots);  // which were searched before
    if (found.graph == every_path && is_of_lattices) found.graph = describe_graph(world_, options_);
    return found;
  };
  if (trees_alone) return with_graph(attempt_in_rounds(strategies, direct(robots), search::infinity, deadline));
  if (std::holds_alternative<XECBS>(options_))
    strategies.push_back(std::make_unique<ExperienceConflictSearch>(world_, robots, options_, statistics));
  else if (const auto* ecbs = std::get_if<ECBS>(&options_);
           ecbs && ecbs->multi_resolution && !world_.has_own_primitives())
    strategies.push_back(std::make_unique<LatticeConflictSearch>(world_, robots, options_, statistics));
  else
    strategies.push_back(std::make_unique<ConflictSearchStrategy>(world_, robots, options_, !portfolio, statistics));
  if (portfolio) strategies.push_back(std::make_unique<CompositeLatticeStrategy>(*space, statistics));
  const auto* any = std::get_if<Auto>(&options_);
  const auto used_up = [&, before = statistics.expansions]() -> std::optional<std::string> {
    if (!any || any->max_group_expansions == 0) return std::nullopt;
    const std::uint64_t expansions = statistics.expansions - before;  // a round does four times the work of the last
    if (expansions < static_cast<std::uint64_t>(any->max_group_expansions)) return std::nullopt;
    return "no paths within max_group_expansions, " + std::to_string(any->max_group_expansions) + " (" +
           std::to_string(expansions) + " states expanded)";
  };
  const double weight = conflict_search_options(options_).bound();
  return with_graph(attempt_in_rounds(strategies, direct(robots), weight, deadline, used_up));
}

/// No paths of these robots are shorter together.
double GroupPlanner::direct(const std::vector<std::size_t>& robots) const {
  double sum = 0.0;
  for (const std::size_t i : robots) sum += world_.direct(i);
  return sum;
}

JointPath GroupPlanner::reroute_each(JointPath path, const Deadline& deadline) {
  const auto retreats = roadmaps_.retreats(path.robots);
  for (double before = search::infinity; path.length() < 0.99 * before;) {
    before = path.length();
    JointPath better = reroute_one_robot(path, world_, deadline, retreats);
    if (better.length() < before) path = shortened(std::move(better), world_, deadline);
  }
  return tightened(std::move(path), world_, deadline);
}

bool GroupPlanner::constrained(const std::vector<std::size_t>& robots) const {
  return std::any_of(robots.begin(), robots.end(),
                     [&](std::size_t i) { return world_.task(i).constraints != nullptr; });
}

bool GroupPlanner::may_change(const JointPath& known) const {
  if (constrained(known.robots)) return false;
  return replan_.worth_a_change * known.length() > direct(known.robots);
}

JointPath GroupPlanner::replan(const JointPath& known, std::uint64_t seed, const Deadline& deadline,
                               PlanStatistics& statistics) {
  const CompositeSpace space(world_, known.robots);
  search::RrtConnect trees(rrt_space(space), seed);
  const auto rows = trees.grow(replan_.attempts, deadline);
  statistics.samples += trees.attempts();
  statistics.memory_bytes = std::max<std::uint64_t>(statistics.memory_bytes, trees.memory());
  if (!rows) return known;
  JointPath path = shortened(space.path(*rows), world_, deadline);
  if (path.length() >= replan_.worth_smoothing * known.length()) return known;
  path = reroute_each(std::move(path), deadline);
  return path.length() < replan_.worth_a_change * known.length() ? path : known;
}

}  // namespace srmp
