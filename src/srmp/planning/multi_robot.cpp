#include "srmp/planning/multi_robot.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "srmp/io/primitives.hpp"
#include "srmp/planning/coupled_post_process.hpp"
#include "srmp/planning/endpoints/joint_endpoints.hpp"
#include "srmp/planning/multi_robot_world.hpp"
#include "srmp/planning/parallel_work.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/post_process.hpp"
#include "srmp/planning/single_robot_path.hpp"
#include "srmp/planning/smoothing/joint_path.hpp"
#include "srmp/planning/strategies/group_search.hpp"

namespace srmp {

namespace {

class MultiRobotPlan {
 public:
  MultiRobotPlan(const MultiRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        deadline_(deadline),
        statistics_(statistics),
        count_(problem.moving.size()),
        work_(static_cast<std::size_t>(num_threads(problem.options)), statistics) {}

  MultiTrajectory run() {
    find_tasks();
    std::vector<RobotEndpoints> ends;
    for (const WorldTask& task : tasks_) ends.push_back({task.start, task.targets});
    require_joint_endpoints(problem_.checkers, ends);
    find_paths();
    note_work();
    statistics_.plan_time_s = deadline_.elapsed();
    return post_process();
  }

 private:
  const std::string& name(std::size_t i) const { return problem_.moving[i].robot; }

  /// What every robot would do if it were alone.
  void find_tasks() {
    std::vector<RobotPath> ways(count_);
    work_.run(count_, deadline_, [&](std::size_t i, const Deadline& deadline, PlanStatistics& statistics) {
      ways[i] = find_way_alone(problem_, problem_.moving[i], problem_.checkers.alone(i), deadline, statistics);
    });
    for (std::size_t i = 0; i < count_; ++i) {
      const bool any = problem_.moving[i].goal.type == GoalType::any;
      tasks_.push_back({std::move(ways[i].start), std::move(ways[i].targets), std::move(ways[i].waypoints), any});
      const std::string path = common_options(problem_.options, name(i)).mprim_path;
      if (path.empty()) continue;
      tasks_.back().primitives = io::read_primitives(path, problem_.checkers.alone(i).robot().joints());
    }
  }

  // --- groups of arms that are planned together

  struct Group {
    GroupWays ways;
    JointPath shortened;
    int number{};
  };

  /// Each arm alone first; those that meet are planned together (independence detection: Standley 2010).
  void find_paths() {
    const MultiRobotWorld::Options lattice{common_.resolution * M_PI / 180.0, common_.prismatic_resolution};
    world_ = std::make_unique<MultiRobotWorld>(problem_.checkers, std::move(tasks_), lattice);
    search_ = std::make_unique<GroupSearch>(*world_, problem_.options);
    const bool apart_first =
        !std::holds_alternative<CBS>(problem_.options) && !std::holds_alternative<ECBS>(problem_.options);
    if (apart_first)
      for (std::size_t i = 0; i < count_; ++i) add_group(alone(i));
    else
      add_groups(connected());
    for (auto pairs = pairs_that_meet(); !pairs.empty(); pairs = pairs_that_meet()) merge(pairs);
    for (const Group& group : groups_) statistics_.search_cost_rad += group.ways.path.length();
    work_.run(groups_.size(), deadline_, [&](std::size_t g, const Deadline& deadline, PlanStatistics& statistics) {
      const PhaseTimer timer(deadline, statistics.shortcut_time_s);
      const JointPath& found = groups_[g].ways.path;
      groups_[g].shortened = common_.shortcut ? shortened(found, *world_, deadline) : found;
    });
    set_costs();
    improve();
  }

  void add_group(GroupWays ways) { groups_.push_back({std::move(ways), {}, next_number_++}); }

  GroupWays alone(std::size_t i) const {
    const WorldTask& task = world_->task(i);
    const std::vector<Eigen::VectorXd> stay{task.start};
    return {joint_path(*world_, i, task.anywhere ? stay : task.backbone), world_->direct(i)};
  }

  void add_groups(const std::vector<std::vector<std::size_t>>& all) {
    std::vector<GroupWays> found(all.size());
    work_.run(all.size(), deadline_, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      found[k] = search_->run(all[k], deadline, statistics);
    });
    for (GroupWays& ways : found) add_group(std::move(ways));
  }

  /// Pairs of groups become groups.
  void merge(const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
    std::vector<std::vector<std::size_t>> all;
    std::vector<char> gone(groups_.size(), false);
    for (const auto& [i, j] : pairs) {
      const auto &a = groups_[i].ways.path.arms, &b = groups_[j].ways.path.arms;
      std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all.emplace_back()));
      gone[i] = gone[j] = true;
    }
    std::vector<Group> kept;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (!gone[g]) kept.push_back(std::move(groups_[g]));
    groups_ = std::move(kept);
    add_groups(all);
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
          if (!taken[j] && world_->may_conflict(arms[k], j)) {
            arms.push_back(j);
            taken[j] = true;
          }
      std::sort(arms.begin(), arms.end());
      all.push_back(std::move(arms));
    }
    return all;
  }

  /// Groups, each in one pair at most: the first that each meets.
  std::vector<std::pair<std::size_t, std::size_t>> pairs_that_meet() {
    std::vector<std::pair<std::size_t, std::size_t>> unknown, pairs;
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t j = i + 1; j < groups_.size(); ++j)
        if (!meet_.contains(numbers(i, j))) unknown.emplace_back(i, j);
    std::vector<char> met(unknown.size());
    work_.run(unknown.size(), deadline_, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      const PhaseTimer timer(deadline, statistics.search_time_s);
      met[k] = meet(*world_, groups_[unknown[k].first].ways.path, groups_[unknown[k].second].ways.path);
    });
    for (std::size_t k = 0; k < unknown.size(); ++k) meet_[numbers(unknown[k].first, unknown[k].second)] = met[k];
    std::vector<char> taken(groups_.size(), false);
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t j = i + 1; j < groups_.size() && !taken[i]; ++j)
        if (!taken[j] && meet_.at(numbers(i, j))) {
          pairs.emplace_back(i, j);
          taken[i] = taken[j] = true;
        }
    return pairs;
  }

  std::pair<int, int> numbers(std::size_t i, std::size_t j) const {
    return std::minmax({groups_[i].number, groups_[j].number});
  }

  // --- better paths

  /// Better and better paths of arms that are planned together: of each by itself, while the others do as before; then,
  /// as long as asked, of all of them anew, by trees of other sequences.
  void improve() {
    const Improvement asked = improvement(problem_.options);
    const Deadline until(asked.time_of(deadline_.remaining()), [this] { return deadline_.cancelled(); });
    std::vector<std::size_t> coupled;  // groups
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (groups_[g].ways.path.arms.size() > 1) coupled.push_back(g);
    if (coupled.empty()) return;
    if (common_.shortcut || asked.wanted())
      try_for(coupled, until, [&](const Group& group, const Deadline& deadline, PlanStatistics& statistics) {
        const PhaseTimer timer(deadline, statistics.shortcut_time_s);
        return search_->each_by_itself(group.shortened, deadline);
      });
    const auto good_enough = [&] {
      return until.stop_requested() || statistics_.bound <= std::max(asked.final_weight, 1.0 + 1e-9);
    };
    for (int round = 0; asked.goes_on_after(round) && !good_enough(); ++round) {
      std::erase_if(coupled, [&](std::size_t g) { return !search_->may_change(groups_[g].shortened); });
      if (coupled.empty()) return;
      try_for(coupled, until, [&](const Group& group, const Deadline& deadline, PlanStatistics& statistics) {
        const PhaseTimer timer(deadline, statistics.search_time_s);
        return search_->anew(group.shortened, static_cast<std::uint64_t>(round) + 1, deadline, statistics);
      });
    }
  }

  /// Takes what `find` has for each of these groups, where that is shorter and meets no other.
  template <class Find>
  void try_for(const std::vector<std::size_t>& groups, const Deadline& until, Find&& find) {
    std::vector<JointPath> found(groups.size());
    work_.run(groups.size(), until, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      found[k] = find(groups_[groups[k]], deadline, statistics);
    });
    for (std::size_t k = 0; k < groups.size(); ++k) take_if_shorter(groups[k], std::move(found[k]));
  }

  void take_if_shorter(std::size_t g, JointPath path) {
    Group& group = groups_[g];
    if (path.length() >= group.shortened.length()) return;
    for (std::size_t other = 0; other < groups_.size(); ++other)
      if (other != g && meet(*world_, path, groups_[other].ways.path)) return;
    group.ways.path = group.shortened = std::move(path);
    set_costs();
  }

  // --- what became of it

  void set_costs() {
    std::vector<JointPath> paths;
    for (const Group& group : groups_) paths.push_back(group.shortened);
    set_costs(paths);
  }

  /// Of the paths as they will be returned.
  void set_costs(const std::vector<JointPath>& paths) {
    double lower = 0.0;
    statistics_.path_cost_rad = 0.0;
    for (const Group& group : groups_) lower += group.ways.lower;
    for (const JointPath& path : paths)
      for (std::size_t i = 0; i < path.arms.size(); ++i)
        statistics_.path_cost_rad += statistics_.robot_cost_rad[name(path.arms[i])] = path.length(i);
    const double cost = std::min(statistics_.path_cost_rad, statistics_.search_cost_rad);
    const bool proved = !std::holds_alternative<Prioritised>(problem_.options);
    statistics_.bound = !proved         ? search::infinity
                        : cost <= lower ? 1.0
                        : lower > 0.0   ? cost / lower
                                        : search::infinity;
    statistics_.bound_graph = "the robots' " + search_->describe_lattices() + ", in steps of " +
                              to_text(world_->step_time()) + " s, waiting counted";
    std::vector<Solution>& solutions = statistics_.solutions;
    while (!solutions.empty() && solutions.back().cost_rad < statistics_.path_cost_rad) solutions.pop_back();
    if (solutions.empty() || solutions.back().cost_rad > statistics_.path_cost_rad)
      solutions.push_back({deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, statistics_.bound_graph});
  }

  MultiTrajectory post_process() {
    std::vector<JointPath> raw, shortened;
    for (const Group& group : groups_) {
      raw.push_back(group.ways.path);
      shortened.push_back(group.shortened);
    }
    return coupled_post_process(
        problem_, *world_, raw, shortened, [this](const std::vector<JointPath>& paths) { set_costs(paths); }, work_,
        deadline_, statistics_);
  }

  /// What the world and the search know has grown until now.
  void note_work() {
    statistics_.states += world_->states();
    statistics_.edge_checks += world_->pair_checks();
    statistics_.memory_bytes += world_->memory() + search_->memory();
  }

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::size_t count_;
  ParallelWork work_;
  std::vector<WorldTask> tasks_;
  std::unique_ptr<MultiRobotWorld> world_;
  std::unique_ptr<GroupSearch> search_;
  std::vector<Group> groups_;
  int next_number_{0};
  std::map<std::pair<int, int>, bool> meet_;  // groups, by number: do they, where that is known
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
