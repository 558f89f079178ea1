#include "srmp/planning/strategies/free_goals.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "srmp/planning/strategies/robot_sampling.hpp"
#include "srmp/search/rrt_connect.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

namespace {

using Path = std::vector<Eigen::VectorXd>;

class GoalChoice {
 public:
  GoalChoice(MultiRobotWorld& world, const std::vector<std::size_t>& robots, const Deadline& deadline,
             const FreeGoalsOptions& options)
      : world_(world), robots_(robots), deadline_(deadline), options_(options), chosen_(robots.size(), 0) {
    for (const std::size_t robot : robots) {
      const WorldTask& task = world.task(robot);
      Path& own = own_.emplace_back(task.anywhere ? Path{task.start} : task.single_robot_path);
      Path& goals = goals_.emplace_back();
      if (own.empty()) continue;
      goals.push_back(own.back());
      if (task.anywhere) continue;
      for (const Eigen::VectorXd& target : task.targets)
        if (target != own.back()) goals.push_back(target);
    }
  }

  FreeGoals run() {
    const bool can_choose = std::ranges::any_of(goals_, [](const Path& goals) { return goals.size() > 1; });
    const bool all_have_paths = std::ranges::none_of(own_, &Path::empty);
    FreeGoals result{own_, 0};
    if (can_choose && all_have_paths && choose(0))
      for (std::size_t i = 0; i < robots_.size(); ++i) result.paths[i] = path_to(i, chosen_[i]);
    result.attempts = attempts_;
    return result;
  }

 private:
  /// The goal of robot i and of those after it.
  bool choose(std::size_t i) {
    if (i == robots_.size()) return have_paths();
    for (std::size_t goal = 0; goal < goals_[i].size(); ++goal) {
      if (steps_++ >= options_.steps || deadline_.stop_requested()) return false;
      if (!is_free(i, goal)) continue;
      chosen_[i] = goal;
      if (choose(i + 1)) return true;
    }
    return false;
  }

  bool is_free(std::size_t i, std::size_t goal) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!world_.may_conflict(robots_[k], robots_[i])) continue;
      const auto [known, added] = free_.try_emplace({{k, chosen_[k]}, {i, goal}}, false);
      if (added) {
        const Eigen::VectorXd &a = goals_[k][chosen_[k]], &b = goals_[i][goal];
        known->second = world_.are_collision_free(robots_[k], a, a, robots_[i], b, b);
      }
      if (!known->second) return false;
    }
    return true;
  }

  bool have_paths() {
    for (std::size_t i = 0; i < robots_.size(); ++i)
      if (path_to(i, chosen_[i]).empty()) return false;
    return true;
  }

  /// Of robot i alone; empty: none is found.
  const Path& path_to(std::size_t i, std::size_t goal) {
    if (goal == 0) return own_[i];
    const auto [known, added] = paths_.try_emplace({i, goal});
    if (added && std::ssize(paths_) <= options_.paths) known->second = search(robots_[i], goals_[i][goal]);
    return known->second;
  }

  Path search(std::size_t robot, const Eigen::VectorXd& goal) {
    search::RrtSpace space = rrt_space(world_.model(robot), world_.task(robot).start, {goal});
    const auto is_free = [this, robot](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return world_.is_free_for_one(robot, a, b);
    };
    space.is_motion_free = is_free;
    const ShortcutOptions few_rounds{.max_rounds = 2, .continuous = {space.wraps.begin(), space.wraps.end()}};
    search::RrtConnect trees(std::move(space));
    const auto rows = trees.grow(options_.attempts, deadline_);
    attempts_ += trees.attempts();
    if (!rows) return {};
    const RowMatrix unwrapped = unwrap_waypoints(stack_waypoints(*rows), few_rounds.continuous);
    return unstack_waypoints(shortcut(unwrapped, is_free, deadline_, few_rounds).waypoints);
  }

  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  const Deadline& deadline_;
  const FreeGoalsOptions& options_;
  std::vector<Path> own_;
  std::vector<Path> goals_;  // by robot: the end of its own path, then the others
  std::vector<std::size_t> chosen_;
  std::map<std::pair<std::pair<std::size_t, std::size_t>, std::pair<std::size_t, std::size_t>>, bool> free_;
  std::map<std::pair<std::size_t, std::size_t>, Path> paths_;  // to other goals
  std::uint64_t steps_{}, attempts_{};
};

}  // namespace

FreeGoals paths_to_free_goals(MultiRobotWorld& world, const std::vector<std::size_t>& robots, const Deadline& deadline,
                              const FreeGoalsOptions& options) {
  return GoalChoice(world, robots, deadline, options).run();
}

}  // namespace srmp
