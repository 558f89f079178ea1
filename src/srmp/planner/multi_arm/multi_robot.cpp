#include "srmp/planner/multi_arm/multi_robot.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "srmp/multi/conflict_search.hpp"
#include "srmp/planner/multi_arm/arm_team.hpp"
#include "srmp/planner/multi_arm/arm_world.hpp"
#include "srmp/planner/multi_arm/composite_search.hpp"
#include "srmp/planner/multi_arm/composite_trees.hpp"
#include "srmp/planner/multi_arm/coupled_path.hpp"
#include "srmp/planner/multi_arm/coupled_post_process.hpp"
#include "srmp/planner/multi_arm/ends_apart.hpp"
#include "srmp/planner/multi_arm/reroute.hpp"
#include "srmp/planner/multi_arm/roadmap_search.hpp"
#include "srmp/planner/multi_arm/way_alone.hpp"
#include "srmp/planner/phase_timer.hpp"
#include "srmp/planner/post_process.hpp"

namespace srmp {

namespace {

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

class MultiRobotPlan {
 public:
  MultiRobotPlan(const MultiRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        deadline_(deadline),
        statistics_(statistics),
        count_(problem.moving.size()) {}

  MultiTrajectory run() {
    find_tasks();
    std::vector<ArmEnds> ends;
    for (const ArmTask& task : tasks_) ends.push_back({task.start, task.targets});
    require_ends_apart(problem_.checkers, ends);
    find_paths();
    statistics_.plan_time_s = deadline_.elapsed();
    return post_process();
  }

 private:
  [[noreturn]] void fail(Status status, const std::string& reason) const { throw PlanningError(status, reason); }

  const std::string& name(std::size_t i) const { return problem_.moving[i].robot; }

  // --- each robot alone

  /// What every robot would do if it were alone.
  void find_tasks() {
    for (std::size_t i = 0; i < count_; ++i) {
      const MultiRobotPart& part = problem_.moving[i];
      RobotPath path = find_way_alone(problem_, part, problem_.checkers.alone(i), deadline_, statistics_);
      const bool aside = part.goal.type == GoalType::aside;
      tasks_.push_back({std::move(path.start), std::move(path.targets), std::move(path.waypoints), aside});
    }
  }

  // --- all of them

  /// Arms that are planned together, and what is known of them: no way of theirs costs less than `lower`.
  struct Group {
    CoupledPath path;
    double lower{};
    int number{};
  };

  /// Each arm alone first; those that meet are planned together (independence detection: Standley 2010).
  void find_paths() {
    const ArmWorld::Options lattice{common_.resolution * M_PI / 180.0, common_.prismatic_resolution};
    world_ = std::make_unique<ArmWorld>(problem_.checkers, std::move(tasks_), lattice);
    const bool apart_first =
        !std::holds_alternative<CBS>(problem_.options) && !std::holds_alternative<ECBS>(problem_.options);
    if (apart_first)
      for (std::size_t i = 0; i < count_; ++i) add_group(alone(i));
    else
      for (const std::vector<std::size_t>& arms : connected()) add_group(together(arms));
    while (const auto pair = first_that_meet()) {
      const CoupledPath &a = groups_[pair->first].path, &b = groups_[pair->second].path;
      std::vector<std::size_t> arms;
      std::merge(a.arms.begin(), a.arms.end(), b.arms.begin(), b.arms.end(), std::back_inserter(arms));
      groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(pair->second));
      groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(pair->first));
      add_group(together(arms));
    }
    statistics_.states += world_->states();
    note_memory(0);
    for (const Group& group : groups_) statistics_.search_cost_rad += group.path.length();
    for (const Group& group : groups_) {
      const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
      shortened_.push_back(common_.shortcut ? shortened(group.path, *world_, deadline_) : group.path);
    }
    set_costs(shortened_);
    improve();
    statistics_.edge_checks += world_->pair_checks();
  }

  /// Better and better paths of arms that are planned together: of each by itself, while the others do as before; then,
  /// as long as asked, of all of them anew, by trees of other sequences.
  void improve() {
    const Improvement asked = improvement(problem_.options);
    const Deadline until(asked.time_of(deadline_.remaining()), [this] { return deadline_.cancelled(); });
    std::vector<std::size_t> coupled;  // groups
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (groups_[g].path.arms.size() > 1) coupled.push_back(g);
    if (common_.shortcut || asked.wanted()) {
      const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
      for (const std::size_t g : coupled) take_if_shorter(g, each_by_itself(shortened_[g], until), 1.0);
    }
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    const auto good_enough = [&] {
      return until.stop_requested() || statistics_.bound <= std::max(asked.final_weight, 1.0 + 1e-9);
    };
    for (int round = 0; !coupled.empty() && asked.goes_on_after(round) && !good_enough(); ++round)
      for (const std::size_t g : coupled) try_anew(g, static_cast<std::uint64_t>(round) + 1, until);
  }

  void try_anew(std::size_t g, std::uint64_t sequence, const Deadline& until) {
    const CompositeSpace space(*world_, groups_[g].path.arms);
    search::TwoTrees trees(tree_space(space), sequence);
    const auto way = trees.grow(most_attempts, until);
    statistics_.expansions += trees.attempts();
    note_memory(trees.memory());
    if (!way) return;
    CoupledPath path = shortened(space.path(*way), *world_, until);
    if (path.length() < worth_a_look * shortened_[g].length())
      take_if_shorter(g, each_by_itself(std::move(path), until), worth_a_change);
  }

  /// As short as it can be while no more than one arm changes its way at a time.
  CoupledPath each_by_itself(CoupledPath path, const Deadline& until) {
    for (double before = search::infinity; path.length() < 0.99 * before;) {
      before = path.length();
      CoupledPath better = rerouted(path, *world_, until, places_aside());
      if (better.length() < before) path = shortened(std::move(better), *world_, until);
    }
    return tightened(std::move(path), *world_, until);
  }

  /// By that factor, unless another arm is met on it.
  void take_if_shorter(std::size_t g, CoupledPath path, double factor) {
    if (path.length() >= factor * shortened_[g].length()) return;
    for (std::size_t other = 0; other < groups_.size(); ++other)
      if (other != g && meet(*world_, path, groups_[other].path)) return;
    groups_[g].path = shortened_[g] = std::move(path);
    set_costs(shortened_);
  }

  /// Of each arm, where it has a roadmap.
  std::vector<std::vector<Eigen::VectorXd>> places_aside() const {
    std::vector<std::vector<Eigen::VectorXd>> places(count_);
    if (!roadmaps_.empty())
      for (std::size_t i = 0; i < count_; ++i) places[i] = roadmaps_.front()->places_aside(i);
    return places;
  }

  void add_group(Group group) {
    group.number = next_number_++;
    groups_.push_back(std::move(group));
  }

  Group alone(std::size_t i) const {
    const ArmTask& task = world_->task(i);
    const std::vector<Eigen::VectorXd> stay{task.start};
    return {coupled_path(*world_, i, task.anywhere ? stay : task.backbone), direct(i)};
  }

  /// Straight to the nearest goal.
  double direct(std::size_t i) const {
    const ArmTask& task = world_->task(i);
    double least = task.anywhere ? 0.0 : search::infinity;
    for (const Eigen::VectorXd& target : task.targets)
      least = std::min(least, world_->robot(i).difference(task.start, target).norm());
    return least;
  }

  /// Arms that can meet, by way of others too.
  std::vector<std::vector<std::size_t>> connected() const {
    std::vector<std::vector<std::size_t>> all;
    std::vector<char> taken(count_, false);
    for (std::size_t i = 0; i < count_; ++i) {
      if (taken[i]) continue;
      std::vector<std::size_t> arms{i};
      taken[i] = true;
      for (std::size_t k = 0; k < arms.size(); ++k)
        for (std::size_t j = 0; j < count_; ++j)
          if (!taken[j] && world_->may_meet(arms[k], j)) {
            arms.push_back(j);
            taken[j] = true;
          }
      std::sort(arms.begin(), arms.end());
      all.push_back(std::move(arms));
    }
    return all;
  }

  std::optional<std::pair<std::size_t, std::size_t>> first_that_meet() {
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t j = i + 1; j < groups_.size(); ++j) {
        const std::pair numbers = std::minmax({groups_[i].number, groups_[j].number});
        if (apart_.contains(numbers)) continue;
        if (meet(*world_, groups_[i].path, groups_[j].path)) return std::pair(i, j);
        apart_.insert(numbers);
      }
    return std::nullopt;
  }

  /// Where the planner may, four searches in turns with more and more effort: on roadmaps, which is quick where arms
  /// need only wait or step aside; by trees of all arms' joints, for arms that are in each other's way; conflict-based
  /// search, for arms that get by each other; and one search on a lattice of all arms' joints. Else conflict-based
  /// search alone.
  Group together(const std::vector<std::size_t>& arms) {
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    const bool composite =
        std::holds_alternative<Auto>(problem_.options) || std::holds_alternative<XECBS>(problem_.options);
    multi::ConflictSearchOptions options = search_options(problem_.options);
    double lower = 0.0;
    for (const std::size_t i : arms) lower += direct(i);
    std::optional<CompositeSpace> space;
    std::optional<search::TwoTrees> trees;
    if (composite) trees.emplace(tree_space(space.emplace(*world_, arms)));
    std::size_t level = 0, levels = 1;
    for (std::uint64_t effort = 1;; effort *= 4) {
      if (composite) {
        for (; level < most_levels && level <= levels; ++level)
          if (const auto path = on_roadmaps(arms, level, effort); path && path->length() <= options.bound() * lower)
            return {*path, lower};
        ++levels;
        const std::uint64_t before = trees->attempts();
        const auto way = trees->grow(2048 * effort, deadline_);
        statistics_.expansions += trees->attempts() - before;
        note_memory(trees->memory());
        if (way) {
          CoupledPath path = space->path(*way);
          if (common_.shortcut) path = shortened(std::move(path), *world_, deadline_);  // they go far astray
          if (path.length() <= options.bound() * lower) return {std::move(path), lower};
        }
        options.max_evaluations = 128 * effort;
      }
      ArmTeam team(*world_, arms);
      const multi::ConflictSearchResult found = multi::conflict_search(team, options, deadline_);
      count(found);
      const std::uint64_t beside = trees ? trees->memory() : 0;
      note_memory(beside + found.statistics.memory);
      lower = std::max(lower, found.lower);
      if (found.status == Status::solved) return {coupled_path(*world_, arms, found.paths), lower};
      if (!composite || deadline_.stop_requested()) require_solved(found);
      CompositeResult one = composite_search(*space, {.max_expansions = 16 * effort}, deadline_);
      statistics_.expansions += one.statistics.expansions;
      statistics_.generated += one.statistics.generated;
      note_memory(beside + one.statistics.memory);
      if (one.status == Status::solved && one.path.length() <= options.bound() * lower)
        return {std::move(one.path), lower};
      const bool no_more = found.status == Status::exhausted && one.status == Status::exhausted;
      if (no_more || deadline_.stop_requested()) require_solved(found);
    }
  }

  /// On roadmaps that are the richer the more effort there was before.
  std::optional<CoupledPath> on_roadmaps(const std::vector<std::size_t>& arms, std::size_t level,
                                         std::uint64_t effort) {
    if (roadmaps_.size() <= level) roadmaps_.push_back(std::make_unique<RoadmapSearch>(*world_, 2 << level));
    RoadmapSearch::Result found = roadmaps_[level]->run(arms, 16'000, 2'000 * effort, deadline_);
    statistics_.expansions += found.expansions;
    note_memory(found.memory);
    if (found.status != Status::solved) return std::nullopt;
    return std::move(found.path);
  }

  /// Of the paths as they will be returned.
  void set_costs(const std::vector<CoupledPath>& paths) {
    double lower = 0.0;
    statistics_.path_cost_rad = 0.0;
    for (const Group& group : groups_) lower += group.lower;
    for (const CoupledPath& path : paths)
      for (std::size_t i = 0; i < path.arms.size(); ++i)
        statistics_.path_cost_rad += statistics_.robot_cost_rad[name(path.arms[i])] = path.length(i);
    const double cost = std::min(statistics_.path_cost_rad, statistics_.search_cost_rad);
    const bool proved = !std::holds_alternative<Prioritised>(problem_.options);
    statistics_.bound = !proved         ? search::infinity
                        : cost <= lower ? 1.0
                        : lower > 0.0   ? cost / lower
                                        : search::infinity;
    statistics_.bound_graph = "the robots' lattices of " + to_text(common_.resolution) + " degrees, in steps of " +
                              to_text(world_->step_time()) + " s, waiting counted";
    std::vector<Solution>& solutions = statistics_.solutions;
    while (!solutions.empty() && solutions.back().cost_rad < statistics_.path_cost_rad) solutions.pop_back();
    if (solutions.empty() || solutions.back().cost_rad > statistics_.path_cost_rad)
      solutions.push_back({deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, statistics_.bound_graph});
  }

  MultiTrajectory post_process() {
    std::vector<CoupledPath> raw;
    for (const Group& group : groups_) raw.push_back(group.path);
    return coupled_post_process(
        problem_, *world_, raw, shortened_, [this](const std::vector<CoupledPath>& paths) { set_costs(paths); },
        deadline_, statistics_);
  }

  /// What a search holds, beside the arms' lattices and roadmaps.
  void note_memory(std::uint64_t held) {
    held += world_->memory();
    for (const auto& roadmaps : roadmaps_) held += roadmaps->memory();
    statistics_.memory_bytes = std::max(statistics_.memory_bytes, held);
  }

  void count(const multi::ConflictSearchResult& found) {
    statistics_.expansions += found.statistics.low.expansions;
    statistics_.generated += found.statistics.low.generated;
    statistics_.tree_nodes += found.statistics.tree_nodes;
    statistics_.edge_checks += found.statistics.low.evaluations;
  }

  void require_solved(const multi::ConflictSearchResult& found) const {
    const std::string work = std::to_string(found.statistics.tree_nodes) + " nodes of the constraint tree, " +
                             std::to_string(found.statistics.low.expansions) + " states expanded";
    switch (found.status) {
      case Status::solved: return;
      case Status::cancelled: fail(found.status, "the plan was cancelled during the search (" + work + ")");
      case Status::exhausted:
        fail(found.status, "the robots' lattices of " + to_text(common_.resolution) +
                               " degrees hold no paths on which they do not meet (" + work +
                               "); a finer resolution may hold some");
      default:
        fail(Status::timed_out,
             "no paths within the time limit of " + to_text(common_.time_limit) + " s (" + work + ")");
    }
  }

  static constexpr std::size_t most_levels = 4;         // of roadmaps
  static constexpr std::uint64_t most_attempts = 2048;  // of trees that may be better
  /// Times the best: of a way that may be the best once each arm was looked at by itself; and of one that is so much
  /// better that it is taken in place of a way of another kind, so that similar questions have similar answers.
  static constexpr double worth_a_look = 1.1, worth_a_change = 0.98;

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::size_t count_;
  std::vector<ArmTask> tasks_;
  std::unique_ptr<ArmWorld> world_;
  std::vector<std::unique_ptr<RoadmapSearch>> roadmaps_;  // richer and richer
  std::vector<Group> groups_;
  std::vector<CoupledPath> shortened_;  // of each group
  int next_number_{0};
  std::set<std::pair<int, int>> apart_;  // groups, by number
};

}  // namespace

MultiTrajectory plan_multi_robot(const MultiRobotProblem& problem, const Deadline& deadline,
                                 PlanStatistics& statistics) {
  MultiRobotPlan plan(problem, deadline, statistics);
  try {
    MultiTrajectory result = plan.run();
    statistics.status = Status::solved;
    statistics.total_time_s = deadline.elapsed();
    return result;
  } catch (const PlanningError& error) {
    note_failure(error, deadline, statistics);
    throw;
  }
}

}  // namespace srmp
