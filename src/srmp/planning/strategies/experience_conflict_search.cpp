#include "srmp/planning/strategies/experience_conflict_search.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/planning/strategies/composite_search.hpp"
#include "srmp/planning/strategies/group_strategies.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

namespace {

/// What the search trades; budgets are counted in work.
struct ExperienceOptions {
  std::uint64_t known_path_evaluations{4096};
  std::uint64_t lattice_evaluations{4096};  ///< of the first round on each lattice; it grows fourfold
  std::uint64_t parts{16};                  ///< a search of one robot has this part of them, at most
  std::uint64_t path_expansions{48};        ///< of each search for a path around another robot
  /// Robots whose sequences are tried, of which there are as many as subsets of them: more may solve larger groups
  /// without a lattice, and take twice as long for each.
  std::size_t max_in_sequence{4};
  /// Steps of the lattices, as multiples of the resolution: coarse ones are quick, fine ones find narrow passages.
  std::vector<double> lattice_scales{3.0, 1.5, 0.75};
};
const ExperienceOptions experience_options;

/// With waypoints no farther apart than `step`: robots may wait there.
std::vector<Eigen::VectorXd> densified(const RobotModel& model, const std::vector<Eigen::VectorXd>& path, double step) {
  std::vector<Eigen::VectorXd> dense;
  for (const Eigen::VectorXd& q : path) {
    if (!dense.empty()) {
      const Eigen::VectorXd from = dense.back(), motion = model.difference(from, q);
      const int parts = static_cast<int>(std::ceil(motion.norm() / step - 1e-9));
      for (int k = 1; k < parts; ++k) dense.push_back(from + static_cast<double>(k) / parts * motion);
    }
    dense.push_back(q);
  }
  return dense;
}

}  // namespace

ExperienceConflictSearch::ExperienceConflictSearch(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                                                   const PlannerOptions& options, PlanStatistics& statistics)
    : world_(world), robots_(robots), options_(options), statistics_(statistics) {
  for (std::size_t i = 0; i < world.size(); ++i) {
    tasks_.push_back(world.task(i));
    tasks_.back().single_robot_path =
        densified(world.model(i), tasks_.back().single_robot_path, world.options().resolution);
  }
  for (const double scale : experience_options.lattice_scales) lattices_.push_back({scale, nullptr});
  if (world.has_own_primitives()) lattices_.resize(1);
}

Attempt ExperienceConflictSearch::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  if (budget.round == 0) {
    Attempt found = along_known_paths(deadline);
    if (found.status != Status::solved && add_paths_around_each(deadline)) found = along_known_paths(deadline);
    if (found.status != Status::solved && robots_.size() > 2 && robots_.size() <= experience_options.max_in_sequence &&
        add_paths_in_sequence(deadline))
      found = along_known_paths(deadline);
    if (found.status == Status::solved) return found;
  }
  Attempt last;
  for (Scaled& lattices : lattices_) {
    last = on_lattices(lattices, experience_options.lattice_evaluations << 2 * budget.round, deadline);
    if (last.status == Status::solved) break;
  }
  return last;
}

Attempt ExperienceConflictSearch::along_known_paths(const Deadline& deadline) {
  multi::ConflictSearchOptions options = conflict_search_options(options_);
  options.known_paths_only = true;
  options.max_evaluations = experience_options.known_path_evaluations;
  options.max_priority_evaluations = options.max_evaluations / experience_options.parts;
  const auto world = make_world(experience_options.lattice_scales.front());
  return search(*world, options, "conflict-based search along known paths", deadline);
}

Attempt ExperienceConflictSearch::on_lattices(Scaled& lattices, std::uint64_t evaluations, const Deadline& deadline) {
  multi::ConflictSearchOptions options = conflict_search_options(options_);
  options.max_evaluations = evaluations;
  options.max_priority_evaluations = evaluations / experience_options.parts;
  if (!lattices.world) lattices.world = make_world(lattices.scale);
  return search(*lattices.world, options, "conflict-based search on lattices", deadline);
}

Attempt ExperienceConflictSearch::search(MultiRobotWorld& world, const multi::ConflictSearchOptions& options,
                                         const std::string& found_by, const Deadline& deadline) {
  Attempt attempt = conflict_search_apart(world, robots_, options_, options, found_by, deadline, statistics_);
  attempt.lower = 0.0;  // of these lattices alone
  if (attempt.status == Status::exhausted && !can_exhaust()) attempt.status = Status::timed_out;
  return attempt;
}

std::unique_ptr<MultiRobotWorld> ExperienceConflictSearch::make_world(double scale) const {
  MultiRobotWorld::Options options = world_.options();
  options.scale = scale;
  options.sparse = true;
  options.by_spheres = !can_exhaust();
  return world_like(world_, tasks_, options);
}

/// Around one other robot at a time.
bool ExperienceConflictSearch::add_paths_around_each(const Deadline& deadline) {
  bool added = false;
  for (const std::size_t robot : robots_)
    for (const std::size_t other : robots_) {
      if (robot == other) continue;
      const WorldTask& task = tasks_[other];
      added |= can_pass(robot, {{other, task.start}}, deadline) == Pass::on_new_path;
      if (!task.anywhere) added |= can_pass(robot, {{other, goal(other)}}, deadline) == Pass::on_new_path;
    }
  return added;
}

/// Around all others, some of which have moved from start to goal before: robots that can move one after the other.
bool ExperienceConflictSearch::add_paths_in_sequence(const Deadline& deadline) {
  bool added = false;
  std::vector<char> reached(std::size_t{1} << robots_.size(), false);  // by the set of those that have moved
  reached[0] = true;
  for (std::size_t moved = 0; moved < reached.size(); ++moved)
    for (std::size_t k = 0; k < robots_.size() && reached[moved]; ++k) {
      const std::size_t next = moved | std::size_t{1} << k;
      if (next == moved || reached[next]) continue;
      CompositeSpace::Others others;
      for (std::size_t i = 0; i < robots_.size(); ++i)
        if (i != k) others.push_back({robots_[i], moved >> i & 1 ? goal(robots_[i]) : tasks_[robots_[i]].start});
      const Pass pass = can_pass(robots_[k], others, deadline);
      added |= pass == Pass::on_new_path;
      reached[next] = pass != Pass::no;
    }
  return added;
}

const Eigen::VectorXd& ExperienceConflictSearch::goal(std::size_t robot) const {
  const WorldTask& task = tasks_[robot];
  return task.anywhere || task.single_robot_path.empty() ? task.start : task.single_robot_path.back();
}

/// Can the robot get to its goal while others stand still? Adds a path on which it can, unless one is known.
ExperienceConflictSearch::Pass ExperienceConflictSearch::can_pass(std::size_t robot,
                                                                  const CompositeSpace::Others& others,
                                                                  const Deadline& deadline) {
  WorldTask& task = tasks_[robot];
  if (task.single_robot_path.size() < 2 || task.anywhere) return Pass::on_known_path;
  if (deadline.stop_requested()) return Pass::no;
  const CompositeSpace space(world_, {robot}, others);
  if (!space.is_free_of_others(task.start) || !space.is_free_of_others(goal(robot))) return Pass::no;
  if (passes(task.single_robot_path, space)) return Pass::on_known_path;
  for (const std::vector<Eigen::VectorXd>& path : task.alternatives)
    if (passes(path, space)) return Pass::on_known_path;
  if (task.constraints) return Pass::no;  // states of a composite lattice are not projected onto them
  const CompositeResult found =
      composite_search(space, {.max_expansions = experience_options.path_expansions}, deadline);
  statistics_.expansions += found.statistics.expansions;
  statistics_.generated += found.statistics.generated;
  if (found.status != Status::solved) return Pass::no;
  const auto is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return space.is_motion_free(a, b); };
  const RowMatrix shorter = shortcut(found.path.positions.front(), is_free, deadline,
                                     {.max_rounds = 0, .continuous = default_limits(world_.model(robot)).continuous})
                                .waypoints;
  task.alternatives.push_back(densified(world_.model(robot), unstack_waypoints(shorter), world_.options().resolution));
  return Pass::on_new_path;
}

bool ExperienceConflictSearch::passes(const std::vector<Eigen::VectorXd>& path, const CompositeSpace& space) {
  for (std::size_t k = 1; k < path.size(); ++k)
    if (!space.is_motion_free(path[k - 1], path[k])) return false;
  return true;
}

}  // namespace srmp
