#include "srmp/planning/multi_robot_world.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <mutex>
#include <unordered_map>

#include "srmp/core/interruption.hpp"
#include "srmp/core/memory_of.hpp"
#include "srmp/core/number_hash.hpp"
#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

using multi::Move;
using search::StateId;

namespace {

/// That are remembered: of large groups so many that freeing them does not take long.
constexpr std::size_t max_motions_of_pair = 4'096, max_motions_of_all = 262'144;
constexpr double min_edge_cost = 1e-12;  // of edges, whose costs must be more than 0: a start may be a goal

/// The result of a check; false where the deadline of its workspace cuts it off.
template <class Check>
bool unless_stopped(Check&& check) {
  try {
    return check();
  } catch (const MotionCheckStopped&) {
    return false;
  }
}

/// Has the deadline passed? Then the result of a check is not to be remembered.
bool may_be_cut_off(const Checker::Workspace& workspace) { return workspace.deadline && workspace.deadline->expired(); }

}  // namespace

class MultiRobotWorld::RobotAgent : public multi::Agent {
 public:
  RobotAgent(const Checker& checker, WorldTask task, const Options& options)
      : checker_(checker),
        robot_(checker.robot()),
        workspace_(checker.make_workspace()),
        limits_(default_limits(robot_)),
        wait_cost_(0.1 * options.resolution),
        sparse_(options.sparse),
        task_(std::move(task)),
        constraints_(task_.constraints ? std::make_unique<ConstraintChecker>(*task_.constraints) : nullptr),
        lattice_(robot_, {task_.start}, task_.targets,
                 {.primitives = primitives(options), .waypoints = waypoints(), .projection = projection(options)},
                 [this](std::size_t, const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_free(a, b); }) {
    torques_.add(robot_, checker_.base(), checker_.other_positions(), task_.limits);
    add_rest(task_.single_robot_path);
    for (const auto& path : task_.alternatives) add_rest(path);
  }

  StateId start() override { return 0; }
  void successors(StateId state, std::vector<search::Successor>& out) override {
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    lattice_.successors(state, out);
    if (sparse_) drop_far_waypoints(state, out, first);
  }
  bool known_missing(StateId from, StateId to) const override {
    if (!sparse_) return false;
    const auto known = costs_.find(std::uint64_t{from} << 32 | to);
    return known != costs_.end() && known->second == search::infinity;
  }
  std::vector<std::vector<StateId>> known_paths() override {
    std::vector<std::vector<StateId>> paths;
    auto next = static_cast<StateId>(1 + task_.targets.size());  // of waypoints
    const auto add = [&](const std::vector<Eigen::VectorXd>& path) {
      if (path.size() < 2) return;
      std::vector<StateId> states{0};
      for (std::size_t k = 1; k + 1 < path.size(); ++k) states.push_back(next++);
      for (StateId goal = 1; goal <= task_.targets.size(); ++goal)
        if (lattice_.distance(lattice_.configuration(goal), path.back()) < 1e-9) {
          states.push_back(goal);
          break;
        }
      paths.push_back(std::move(states));
    };
    add(task_.single_robot_path);
    for (const auto& path : task_.alternatives) add(path);
    return paths;
  }
  bool is_goal(StateId state) override { return task_.anywhere || lattice_.is_goal(state); }
  double heuristic(StateId state) override { return task_.anywhere ? 0.0 : lattice_.distance_to_targets(state); }
  double wait_cost() override { return wait_cost_; }
  int duration(StateId from, StateId to) override {
    const double time = time_of(lattice_.configuration(from), lattice_.configuration(to));
    return std::max(1, static_cast<int>(std::ceil(time / step_time - 1e-9)));
  }
  double lower_cost(StateId from, StateId to) override {
    return lattice_.distance(lattice_.configuration(from), lattice_.configuration(to));
  }
  int lower_steps(StateId from, StateId to) override { return from == to ? 0 : duration(from, to); }

  /// Along a known path, from where one gets onto it.
  double inadmissible_heuristic(StateId state) override {
    double least = heuristic(state);
    if (known_.empty() || least == 0.0) return least;
    const Eigen::VectorXd q = lattice_.configuration(state);
    least = search::infinity;
    for (const auto& [waypoint, rest] : known_) least = std::min(least, lattice_.distance(q, waypoint) + rest);
    return least;
  }

  double evaluate(StateId from, StateId to) override {
    const std::uint64_t key = std::uint64_t{from} << 32 | to;
    if (const auto known = costs_.find(key); known != costs_.end()) return known->second;
    const double length = lattice_.distance(configuration(from), configuration(to));
    const search::Edge edge{from, to, std::max(length, min_edge_cost)};
    double cost = 0.0;
    lattice_.evaluate({&edge, 1}, {&cost, 1});
    if (!may_be_cut_off(*workspace_)) costs_.emplace(key, cost);
    return cost;
  }

  bool is_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
               double of_tolerances = constraint_fractions.motions) {
    if (constraints_ && !constraints_->keeps(a, b, of_tolerances)) return false;
    if (!torques_.empty() && !torques_.can_hold(a, b)) return false;
    return unless_stopped([&] { return checker_.is_motion_free(a, b, *workspace_, {.start_is_free = true}); });
  }

  bool is_free(const Eigen::VectorXd& q) {
    return unless_stopped([&] { return checker_.is_free(q, *workspace_); });
  }
  void stop_at(const Deadline& deadline) { checker_.stop_at(deadline, *workspace_); }

  double time_of(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    return (robot_.difference(a, b).array().abs() / limits_.velocity.array()).maxCoeff();
  }
  const WorldTask& task() const { return task_; }
  double length_alone() const { return length_alone_; }
  const MotionLimits& limits() const { return limits_; }
  Eigen::VectorXd configuration(StateId state) const { return lattice_.configuration(state); }
  const RobotModel& robot() const { return robot_; }
  std::size_t states() const { return lattice_.size(); }
  std::size_t memory() const { return lattice_.memory() + memory_of(costs_); }

  double step_time{};  // [s]

 private:
  /// Leaves the edges to the nearest waypoint of the single-robot path, and to those 1, 2, 4, … waypoints from there.
  void drop_far_waypoints(StateId state, std::vector<search::Successor>& out, std::ptrdiff_t first) const {
    const auto begin = static_cast<StateId>(1 + task_.targets.size());
    const auto end = static_cast<StateId>(begin + waypoints().size());
    StateId nearest = state;
    double least = search::infinity;
    if (state < begin || state >= end)
      for (auto edge = out.begin() + first; edge != out.end(); ++edge)
        if (begin <= edge->state && edge->state < end && edge->cost < least) {
          least = edge->cost;
          nearest = edge->state;
        }
    out.erase(std::remove_if(out.begin() + first, out.end(),
                             [&](const search::Successor& edge) {
                               if (edge.state < begin || edge.state >= end) return false;
                               return !std::has_single_bit(edge.state > nearest ? edge.state - nearest
                                                                                : nearest - edge.state) &&
                                      edge.state != nearest;
                             }),
              out.end());
  }

  PrimitiveSet primitives(const Options& options) const {
    if (task_.primitives) return *task_.primitives;
    const std::vector<Joint>& joints = robot_.joints();
    const Eigen::VectorXd step =
        lattice_step(joints, options.scale * options.resolution, options.scale * options.prismatic_resolution);
    return rich_primitives(joints, step, parallel_pairs(robot_));
  }
  /// As that of one robot alone: cells have half the size of steps.
  Lattice::Projection projection(const Options& options) const {
    if (!constraints_) return {};
    return {[&checker = *constraints_](Eigen::VectorXd& q) {
              return checker.project(q, constraint_fractions.configurations);
            },
            0.5 * lattice_step(robot_.joints(), options.resolution, options.prismatic_resolution)};
  }
  std::vector<Eigen::VectorXd> waypoints() const {
    std::vector<Eigen::VectorXd> inner;
    const auto add = [&](const std::vector<Eigen::VectorXd>& path) {
      if (path.size() > 2) inner.insert(inner.end(), path.begin() + 1, path.end() - 1);
    };
    add(task_.single_robot_path);
    for (const auto& path : task_.alternatives) add(path);
    return inner;
  }

  void add_rest(const std::vector<Eigen::VectorXd>& path) {
    double left = 0.0;
    for (std::size_t k = path.size(); k-- > 0;) {
      if (k + 1 < path.size()) left += lattice_.distance(path[k], path[k + 1]);
      if (path.size() > 2) known_.emplace_back(path[k], left);
    }
    if (length_alone_ == 0.0) length_alone_ = left;
  }

  const Checker& checker_;
  const RobotModel& robot_;
  Checker::WorkspacePtr workspace_;
  MotionLimits limits_;
  double wait_cost_;
  bool sparse_;
  WorldTask task_;
  std::unique_ptr<ConstraintChecker> constraints_;  // null: there are none
  JointTorques torques_;
  std::vector<std::pair<Eigen::VectorXd, double>> known_;  // waypoints of known paths, and what is left from there
  double length_alone_{};
  Lattice lattice_;
  std::unordered_map<std::uint64_t, double> costs_;  // of edges
};

/// What is known of two robots, a < b. Threads share it.
class MultiRobotWorld::Pair {
 public:
  /// Remembers so many motions.
  Pair(const GroupCheckers& checkers, std::size_t a, std::size_t b, std::size_t max_motions)
      : checkers_(checkers),
        a_(a),
        b_(b),
        max_motions_(max_motions),
        exact_{checkers.pair(a, b), checkers.pair(a, b)->make_workspace()} {}

  bool are_collision_free(const Eigen::VectorXd& from_a, const Eigen::VectorXd& to_a, const Eigen::VectorXd& from_b,
                          const Eigen::VectorXd& to_b, const MotionQuery& query) {
    const std::lock_guard lock(mutex_);
    if (query.spheres_only) return check(from_a, to_a, from_b, to_b, query);
    std::vector<std::uint64_t> key{query.start_is_free};
    for (const Eigen::VectorXd* q : {&from_a, &to_a, &from_b, &to_b})
      for (const double value : *q) key.push_back(std::bit_cast<std::uint64_t>(value));
    if (const auto known = motions_free_.find(key); known != motions_free_.end()) return known->second;
    const bool is_free = check(from_a, to_a, from_b, to_b, query);
    if (may_be_cut_off(*exact_.workspace)) return is_free;
    if (motions_free_.size() >= max_motions_) motions_free_.clear();
    motions_free_.emplace(std::move(key), is_free);
    return is_free;
  }

  void stop_at(const Deadline& deadline) {
    const std::lock_guard lock(mutex_);
    deadline_ = &deadline;
    for (const Checking* checking : {&exact_, &by_spheres_})
      if (checking->checker) checking->checker->stop_at(deadline, *checking->workspace);
  }

  /// By spheres alone. Rows of a's configurations, then b's.
  std::vector<char> collision_free_with(const RowMatrix& both) {
    const std::lock_guard lock(mutex_);
    const auto count = static_cast<std::size_t>(both.rows());
    const auto free = std::make_unique<bool[]>(count);
    const bool checked = unless_stopped([&] {
      const Checking& spheres = checking(true);
      spheres.checker->are_free(both, {free.get(), count}, *spheres.workspace, {.spheres_only = true});
      return true;
    });
    if (!checked) std::fill_n(free.get(), count, false);
    return {free.get(), free.get() + count};
  }

  /// `ends` of the moves where both are under way: of a, then of b, each from and to.
  template <class Ends>
  bool in_conflict(const Move& move_a, const Move& move_b, int first, int last, bool by_spheres, Ends&& ends) {
    // Of a wait only the place counts, and the time as far as the other one moves.
    const auto since = [first](const Move& move, int step) {
      return move.waits() ? 0u : static_cast<std::uint32_t>(step - first);
    };
    const bool still = move_a.waits() && move_b.waits();
    const MovePair key{
        move_a.from, move_a.to, since(move_a, move_a.start), since(move_a, move_a.end),
        move_b.from, move_b.to, since(move_b, move_b.start), still ? 0u : static_cast<std::uint32_t>(last - first)};
    const std::lock_guard lock(mutex_);
    if (const auto known = conflicts_.find(key); known != conflicts_.end()) return known->second;
    const std::array<Eigen::VectorXd, 4> q = ends();
    const bool collide = !check(q[0], q[1], q[2], q[3], {.spheres_only = by_spheres});
    if (!may_be_cut_off(*exact_.workspace)) conflicts_.emplace(key, collide);
    return collide;
  }

  std::uint64_t checks() const {
    const std::lock_guard lock(mutex_);
    return checks_;
  }
  std::size_t memory() const {
    const std::lock_guard lock(mutex_);
    const std::size_t key = motions_free_.empty() ? 0 : memory_of(motions_free_.begin()->first);  // all are as long
    return memory_of(conflicts_) + memory_of(motions_free_) + motions_free_.size() * key;
  }

 private:
  struct Checking {
    const Checker* checker{};
    Checker::WorkspacePtr workspace;
  };
  /// The caller has the lock. Throws MotionCheckStopped at the deadline, because the first covers of a robot take long.
  const Checking& checking(bool spheres_only) {
    if (!spheres_only) return exact_;
    if (!by_spheres_.checker) {
      const auto stop_if_late = [this, outer = interruption_check()] {
        if (outer) outer();
        if (deadline_ && deadline_->expired()) throw MotionCheckStopped();
      };
      stop_if_late();
      const InterruptionScope scope(stop_if_late);
      by_spheres_.checker = checkers_.pair_by_spheres(a_, b_);
      by_spheres_.workspace = by_spheres_.checker->make_workspace();
      if (deadline_) by_spheres_.checker->stop_at(*deadline_, *by_spheres_.workspace);
    }
    return by_spheres_;
  }

  bool check(const Eigen::VectorXd& from_a, const Eigen::VectorXd& to_a, const Eigen::VectorXd& from_b,
             const Eigen::VectorXd& to_b, const MotionQuery& query) {
    ++checks_;
    from_.resize(from_a.size() + from_b.size());
    to_.resize(from_.size());
    from_ << from_a, from_b;
    to_ << to_a, to_b;
    return unless_stopped([&] {
      const Checking& by = checking(query.spheres_only);
      return by.checker->is_motion_free(from_, to_, *by.workspace, query);
    });
  }

  const GroupCheckers& checkers_;
  const std::size_t a_, b_, max_motions_;
  mutable std::mutex mutex_;
  Checking exact_, by_spheres_;  // the latter is made when it is first needed
  const Deadline* deadline_{};
  Eigen::VectorXd from_, to_;
  std::uint64_t checks_{};
  /// Two moves of two robots, times since the later of their starts.
  using MovePair = std::array<std::uint32_t, 8>;
  std::unordered_map<MovePair, bool, NumberHash> conflicts_;  // as far as checked: is it one?
  /// Motions that were checked exactly, by the bits of their ends, up to max_motions_; then it begins anew. Paths are
  /// smoothed in rounds, and each begins with motions of the one before.
  std::unordered_map<std::vector<std::uint64_t>, bool, NumberHash> motions_free_;
};

MultiRobotWorld::MultiRobotWorld(const GroupCheckers& checkers, std::vector<WorldTask> tasks, const Options& options)
    : checkers_(checkers), options_(options) {
  for (std::size_t i = 0; i < checkers.size(); ++i) {
    agents_.push_back(std::make_unique<RobotAgent>(checkers.alone(i), std::move(tasks[i]), options));
    step_time_ = std::max(step_time_, options.resolution / agents_.back()->limits().velocity.mean());
    for (std::size_t j = i + 1; j < checkers.size(); ++j)
      if (checkers.may_conflict(i, j)) pairs_.emplace(std::pair(i, j), nullptr);
  }
  const std::size_t max_motions =
      std::min(max_motions_of_pair, max_motions_of_all / std::max<std::size_t>(1, pairs_.size()));
  for (auto& [numbers, pair] : pairs_)
    pair = std::make_unique<Pair>(checkers, numbers.first, numbers.second, max_motions);
  for (const auto& robot : agents_) robot->step_time = step_time_;
}
MultiRobotWorld::~MultiRobotWorld() = default;

void MultiRobotWorld::stop_at(const Deadline& deadline) {
  deadline_ = &deadline;
  for (const auto& robot : agents_) robot->stop_at(deadline);
  for (const auto& [numbers, pair] : pairs_) pair->stop_at(deadline);
}

multi::Agent& MultiRobotWorld::agent(std::size_t i) { return *agents_[i]; }

MultiRobotWorld::Pair* MultiRobotWorld::pair(std::size_t a, std::size_t b) const {
  const auto found = pairs_.find({a, b});
  return found == pairs_.end() ? nullptr : found->second.get();
}

std::uint64_t MultiRobotWorld::pair_checks() const {
  std::uint64_t sum = 0;
  for (const auto& [numbers, pair] : pairs_) sum += pair->checks();
  return sum;
}

std::uint64_t MultiRobotWorld::states() const {
  std::uint64_t sum = 0;
  for (const auto& robot : agents_) sum += robot->states();
  return sum;
}

std::size_t MultiRobotWorld::memory() const {
  std::size_t sum = 0;
  for (const auto& robot : agents_) sum += robot->memory();
  for (const auto& [numbers, pair] : pairs_) sum += pair->memory();
  return sum;
}

Eigen::VectorXd MultiRobotWorld::at(std::size_t robot, const Move& move, int step) const {
  const RobotAgent& a = *agents_[robot];
  const Eigen::VectorXd from = a.configuration(move.from);
  if (move.waits() || step <= move.start) return from;
  const Eigen::VectorXd to = a.configuration(move.to);
  if (step >= move.end) return to;
  const double fraction = static_cast<double>(step - move.start) / (move.end - move.start);
  return from + fraction * a.robot().difference(from, to);
}

bool MultiRobotWorld::in_conflict(std::size_t a, const Move& move_a, std::size_t b, const Move& move_b) {
  if (a > b) return in_conflict(b, move_b, a, move_a);
  const auto [first, last] = multi::overlap(move_a, move_b);
  Pair* both = pair(a, b);
  if (first >= last || !both) return false;
  const auto touches_end = [](const Move& move, const RobotAgent& robot) {
    return std::min(move.from, move.to) <= robot.task().targets.size();  // 0 is the start, then come the targets
  };
  const bool by_spheres =
      options_.by_spheres && !(touches_end(move_a, *agents_[a]) && touches_end(move_b, *agents_[b]));
  return both->in_conflict(move_a, move_b, first, last, by_spheres, [&, first = first, last = last] {
    return std::array{at(a, move_a, first), at(a, move_a, last), at(b, move_b, first), at(b, move_b, last)};
  });
}

bool MultiRobotWorld::has_own_primitives() const {
  return std::any_of(agents_.begin(), agents_.end(),
                     [](const auto& robot) { return robot->task().primitives.has_value(); });
}

int MultiRobotWorld::duration(std::size_t robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  return std::max(1, static_cast<int>(std::ceil(agents_[robot]->time_of(from, to) / step_time_ - 1e-9)));
}

RowMatrix MultiRobotWorld::unwrapped(std::size_t robot, ConstRows rows) const {
  return unwrap_waypoints(rows, agents_[robot]->limits().continuous);
}

const WorldTask& MultiRobotWorld::task(std::size_t robot) const { return agents_[robot]->task(); }

double MultiRobotWorld::direct(std::size_t robot) const {
  const WorldTask& task = agents_[robot]->task();
  double least = task.anywhere ? 0.0 : search::infinity;
  for (const Eigen::VectorXd& target : task.targets)
    least = std::min(least, model(robot).difference(task.start, target).norm());
  return least;
}

double MultiRobotWorld::alone(std::size_t robot) const {
  return task(robot).anywhere ? 0.0 : agents_[robot]->length_alone();
}

bool MultiRobotWorld::are_collision_free(std::size_t a, const Eigen::VectorXd& from_a, const Eigen::VectorXd& to_a,
                                         std::size_t b, const Eigen::VectorXd& from_b, const Eigen::VectorXd& to_b,
                                         const MotionQuery& query) {
  if (a > b) return are_collision_free(b, from_b, to_b, a, from_a, to_a, query);
  Pair* both = pair(a, b);
  return !both || both->are_collision_free(from_a, to_a, from_b, to_b, query);
}

std::vector<char> MultiRobotWorld::collision_free_with(std::size_t a, const Eigen::VectorXd& q, std::size_t b,
                                                       std::span<const Eigen::VectorXd> points) {
  Pair* both = pair(std::min(a, b), std::max(a, b));
  if (!both || points.empty()) return std::vector<char>(points.size(), true);
  const RowMatrix rows = stack_waypoints(points);
  return both->collision_free_with(side_by_side(rows, q.transpose().replicate(rows.rows(), 1), a < b));
}

bool MultiRobotWorld::is_free_for_one(std::size_t robot, const Eigen::VectorXd& q) {
  return agents_[robot]->is_free(q);
}

bool MultiRobotWorld::is_free_for_one(std::size_t robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                                      double of_tolerances) {
  return agents_[robot]->is_free(from, to, of_tolerances);
}

}  // namespace srmp
