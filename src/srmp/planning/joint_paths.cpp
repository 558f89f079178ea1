#include "srmp/planning/joint_paths.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "srmp/io/primitives.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/smoothing/joint_shortcut.hpp"
#include "srmp/planning/solution_record.hpp"
#include "srmp/planning/strategies/group_planner.hpp"
#include "srmp/planning/strategies/group_strategies.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

class IndependenceDetection {
 public:
  IndependenceDetection(const PlanProblem& problem, ParallelWork& work, const Deadline& deadline,
                        PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        deadline_(deadline),
        statistics_(statistics),
        count_(problem.robots.size()),
        work_(work) {}

  JointPaths run(std::vector<RobotPath> alone) {
    const MultiRobotWorld::Options lattice{common_.resolution * M_PI / 180.0, common_.prismatic_resolution};
    world_ = std::make_unique<MultiRobotWorld>(problem_.checkers.planning, tasks(std::move(alone)), lattice);
    world_->stop_at(deadline_);
    planner_ = std::make_unique<GroupPlanner>(*world_, problem_.options);
    statistics_.bound_graph = graph_of_bound();
    try {
      find_groups();
      statistics_.bound_graph = graph_of_bound();
      smooth();
      improve();
    } catch (...) {
      count_work();
      throw;
    }
    count_work();
    JointPaths paths{{}, smoothed_paths(), {}, lower()};
    for (Group& group : groups_) paths.raw.push_back(std::move(group.found.path));
    paths.world = std::move(world_);
    return paths;
  }

 private:
  /// Robots that are planned jointly, or one alone.
  struct Group {
    FoundPath found;
    JointPath smoothed;
    int number{};
  };

  void count_work() {
    statistics_.states += world_->states();
    statistics_.edge_checks += world_->pair_checks();
    statistics_.memory_bytes += world_->memory() + planner_->memory();
  }

  std::vector<WorldTask> tasks(std::vector<RobotPath> alone) const {
    std::vector<WorldTask> tasks;
    for (std::size_t i = 0; i < count_; ++i) {
      RobotEndpoints& endpoints = alone[i].endpoints;
      tasks.push_back({.start = std::move(endpoints.start),
                       .targets = std::move(endpoints.targets),
                       .single_robot_path = unstack_waypoints(alone[i].waypoints),
                       .anywhere = problem_.robots[i].may_end_anywhere(),
                       .constraints = problem_.robots[i].constraints,
                       .limits = problem_.robots[i].limits});
      const std::string file = common_options(problem_.options, problem_.robots[i].robot).mprim_path;
      if (file.empty()) continue;
      tasks.back().primitives = io::read_primitives(file, problem_.checkers.planning.alone(i).robot().joints());
    }
    return tasks;
  }

  // --- groups

  void find_groups() {
    statistics_.independence_detection = independence_detection(problem_.options);
    if (statistics_.independence_detection)
      for (std::size_t i = 0; i < count_; ++i) add_group(alone(i));
    else
      add_groups(connected());
    for (auto pairs = pairs_in_conflict(); !pairs.empty(); pairs = pairs_in_conflict()) merge(pairs);
    for (const Group& group : groups_) statistics_.search_cost_rad += group.found.path.length();
  }

  void add_group(FoundPath found) { groups_.push_back({std::move(found), {}, next_number_++}); }

  FoundPath alone(std::size_t i) const {
    const WorldTask& task = world_->task(i);
    const std::vector<Eigen::VectorXd> stay{task.start};
    return {.path = joint_path(*world_, i, task.anywhere ? stay : task.single_robot_path),
            .lower = world_->direct(i),
            .graph = every_path,
            .found_by = "each robot alone"};
  }

  /// Robots that are to be planned jointly, and paths of some of them.
  struct Coupled {
    std::vector<std::size_t> robots;
    std::vector<const JointPath*> known{};
  };

  void add_groups(const std::vector<Coupled>& all) {
    std::vector<FoundPath> found(all.size());
    work_.run(all.size(), deadline_, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      found[k] = planner_->find(all[k].robots, all[k].known, deadline, statistics);
    });
    for (FoundPath& path : found) add_group(std::move(path));
  }

  /// Pairs of groups become groups.
  void merge(const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
    std::vector<Coupled> all;
    std::vector<char> merged(groups_.size(), false);
    for (const auto& [i, j] : pairs) {
      const JointPath &a = groups_[i].found.path, &b = groups_[j].found.path;
      Coupled& both = all.emplace_back();
      std::ranges::merge(a.robots, b.robots, std::back_inserter(both.robots));
      both.known = {&a, &b};
      merged[i] = merged[j] = true;
    }
    std::vector<Group> before = std::exchange(groups_, {});
    for (std::size_t g = 0; g < before.size(); ++g)
      if (!merged[g]) groups_.push_back(std::move(before[g]));
    add_groups(all);  // from paths of `before`
  }

  /// Robots that can reach each other, directly or by way of others.
  std::vector<Coupled> connected() const {
    std::vector<Coupled> all;
    std::vector<char> taken(count_, false);
    for (std::size_t i = 0; i < count_; ++i) {
      if (taken[i]) continue;
      std::vector<std::size_t> robots{i};
      taken[i] = true;
      for (std::size_t k = 0; k < robots.size(); ++k)
        for (std::size_t j = 0; j < count_; ++j)
          if (!taken[j] && world_->may_conflict(robots[k], j)) {
            robots.push_back(j);
            taken[j] = true;
          }
      std::sort(robots.begin(), robots.end());
      all.push_back({std::move(robots)});
    }
    return all;
  }

  /// Pairs of groups that collide. Each group is in one pair at most: with the first group that it collides with.
  std::vector<std::pair<std::size_t, std::size_t>> pairs_in_conflict() {
    std::vector<std::pair<std::size_t, std::size_t>> unknown, pairs;
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t j = i + 1; j < groups_.size(); ++j)
        if (!conflicts_.contains(numbers(i, j))) unknown.emplace_back(i, j);
    std::vector<char> collide(unknown.size());
    work_.run(unknown.size(), deadline_, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      const PhaseTimer timer(deadline, statistics.search_time_s);
      collide[k] = in_conflict(*world_, groups_[unknown[k].first].found.path, groups_[unknown[k].second].found.path);
    });
    for (std::size_t k = 0; k < unknown.size(); ++k)
      conflicts_[numbers(unknown[k].first, unknown[k].second)] = collide[k];
    std::vector<char> taken(groups_.size(), false);
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t j = i + 1; j < groups_.size() && !taken[i]; ++j)
        if (!taken[j] && conflicts_.at(numbers(i, j))) {
          pairs.emplace_back(i, j);
          taken[i] = taken[j] = true;
        }
    return pairs;
  }

  std::pair<int, int> numbers(std::size_t i, std::size_t j) const {
    return std::minmax({groups_[i].number, groups_[j].number});
  }

  // --- smoothing

  void smooth() {
    work_.run(groups_.size(), deadline_, [&](std::size_t g, const Deadline& deadline, PlanStatistics& statistics) {
      const PhaseTimer timer(deadline, statistics.shortcut_time_s);
      const JointPath& found = groups_[g].found.path;
      groups_[g].smoothed = common_.shortcut ? shortened(found, *world_, deadline) : found;
    });
    record();
  }

  /// Shorter paths of robots that are planned jointly: of each robot by itself, while the others do as before; then,
  /// for as long as requested, of all of them, by RRT-Connect with other seeds.
  void improve() {
    const Improvement more = improvement(problem_.options);
    const Deadline until = deadline_.within(more.max_time());
    std::vector<std::size_t> coupled;  // groups
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (groups_[g].found.path.robots.size() > 1) coupled.push_back(g);
    if (coupled.empty()) return;
    statistics_.large_neighbourhood_search =
        more.requested() || (common_.shortcut && large_neighbourhood_search(problem_.options));
    if (statistics_.large_neighbourhood_search)
      try_for(coupled, until, [&](const Group& group, const Deadline& deadline, PlanStatistics& statistics) {
        const PhaseTimer timer(deadline, statistics.shortcut_time_s);
        return FoundPath{.path = planner_->reroute_each(group.smoothed, deadline), .found_by = group.found.found_by};
      });
    const auto good_enough = [&] {
      return until.stop_requested() || statistics_.bound <= std::max(more.final_weight, 1.0 + 1e-9);
    };
    for (int round = 0; more.goes_on_after(round) && !good_enough(); ++round) {
      std::erase_if(coupled, [&](std::size_t g) { return !planner_->may_change(groups_[g].smoothed); });
      if (coupled.empty()) return;
      try_for(coupled, until, [&](const Group& group, const Deadline& deadline, PlanStatistics& statistics) {
        const PhaseTimer timer(deadline, statistics.search_time_s);
        const std::uint64_t seed = static_cast<std::uint64_t>(round) + 1;
        return FoundPath{.path = planner_->replan(group.smoothed, seed, deadline, statistics),
                         .found_by = "composite RRT-Connect"};
      });
    }
  }

  /// Takes what `find` has for each of these groups, where that is shorter and collides with no other group.
  template <class Find>
  void try_for(const std::vector<std::size_t>& groups, const Deadline& until, Find&& find) {
    std::vector<FoundPath> found(groups.size());
    work_.run(groups.size(), until, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      found[k] = find(groups_[groups[k]], deadline, statistics);
    });
    for (std::size_t k = 0; k < groups.size(); ++k) take_if_shorter(groups[k], std::move(found[k]));
  }

  void take_if_shorter(std::size_t g, FoundPath found) {
    Group& group = groups_[g];
    if (found.path.length() >= group.smoothed.length()) return;
    for (std::size_t other = 0; other < groups_.size(); ++other)
      if (other != g && in_conflict(*world_, found.path, groups_[other].found.path)) return;
    group.found.path = group.smoothed = std::move(found.path);
    group.found.found_by = std::move(found.found_by);
    record();
  }

  // --- costs

  std::vector<JointPath> smoothed_paths() const {
    std::vector<JointPath> paths;
    for (const Group& group : groups_) paths.push_back(group.smoothed);
    return paths;
  }

  /// What the groups' paths say, without repetitions.
  std::string each_once(std::string FoundPath::* text, const char* separator) const {
    std::string all;
    for (const Group& group : groups_)
      if (all.find(group.found.*text) == std::string::npos) all += (all.empty() ? "" : separator) + group.found.*text;
    return all;
  }

  /// xECBS proves no more than that no path is shorter than the straight line.
  std::string graph_of_bound() const {
    if (std::holds_alternative<XECBS>(problem_.options)) return every_path;
    if (std::holds_alternative<Prioritised>(problem_.options)) return describe_graph(*world_, problem_.options);
    const std::string graphs = each_once(&FoundPath::graph, "; ");
    return graphs.empty() ? describe_graph(*world_, problem_.options) : graphs;
  }

  /// Zero where nothing is proven.
  double lower() const {
    double sum = 0.0;
    if (std::holds_alternative<Prioritised>(problem_.options)) return sum;
    for (const Group& group : groups_) sum += group.found.lower;
    return sum;
  }

  void record() {
    statistics_.found_by = each_once(&FoundPath::found_by, ", ");
    record_costs(problem_, smoothed_paths(), lower(), deadline_, statistics_);
  }

  const PlanProblem& problem_;
  const CommonOptions& common_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::size_t count_;
  ParallelWork& work_;
  std::unique_ptr<MultiRobotWorld> world_;
  std::unique_ptr<GroupPlanner> planner_;
  std::vector<Group> groups_;
  int next_number_{0};
  std::map<std::pair<int, int>, bool> conflicts_;  // of groups, by number, where that is known
};

}  // namespace

JointPaths find_joint_paths(const PlanProblem& problem, std::vector<RobotPath> alone, ParallelWork& work,
                            const Deadline& deadline, PlanStatistics& statistics) {
  return IndependenceDetection(problem, work, deadline, statistics).run(std::move(alone));
}

void record_costs(const PlanProblem& problem, const std::vector<JointPath>& paths, double lower,
                  const Deadline& deadline, PlanStatistics& statistics) {
  statistics.path_cost_rad = 0.0;
  for (const JointPath& path : paths)
    for (std::size_t i = 0; i < path.robots.size(); ++i) {
      double& cost = statistics.robot_cost_rad[problem.robots[path.robots[i]].robot];
      statistics.path_cost_rad += cost = path.length(i);
    }
  record_solution(statistics, lower, deadline);
}

}  // namespace srmp
