#include "srmp/planning/obstacles/safe_intervals.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "srmp/core/memory_of.hpp"
#include "srmp/planning/group_checkers.hpp"
#include "srmp/planning/motion_checks.hpp"
#include "srmp/search/best_first.hpp"
#include "srmp/search/dijkstra.hpp"

namespace srmp {

SafeIntervals::SafeIntervals(const TimedTask& task, const Deadline& deadline, const SafeIntervalOptions& options)
    : task_(task), deadline_(deadline), options_(options), workspace_(task.checker.make_workspace()) {
  task.checker.stop_at(deadline, *workspace_);
  if (task.constraints) constraints_ = std::make_unique<ConstraintChecker>(*task.constraints);
  for (const MovingRobot& other : task.other_robots)
    last_step_ = std::max(last_step_, static_cast<int>(std::ceil(end_of(*other.motion) / time_step)));
  for (const MovingRobot& other : task.other_robots) {
    pair_workspaces_.push_back(other.checker->make_workspace());
    other.checker->stop_at(deadline, *pair_workspaces_.back());
    RowMatrix& rows = motions_.emplace_back(last_step_ + 1, other.motion->positions.cols());
    for (int step = 0; step <= last_step_; ++step)
      rows.row(step) = other.motion->sample(std::min(step * time_step, end_of(*other.motion))).transpose();
  }
  add(task.start);
  for (const Eigen::VectorXd& target : task.targets) add(target);
  const RobotModel& robot = task.checker.robot();
  for (std::size_t k = 1; k < task.path.size(); ++k) {
    const Eigen::VectorXd segment = robot.difference(task.path[k - 1], task.path[k]);
    const int parts = std::max(1, static_cast<int>(std::ceil(segment.norm() / options_.spacing)));
    for (int i = k == 1 ? 1 : 0; i < parts; ++i) add(task.path[k - 1] + static_cast<double>(i) / parts * segment);
  }
  connect();
}

// --- the roadmap

void SafeIntervals::add(Eigen::VectorXd q) {
  vertices_.push_back(std::move(q));
  intervals_.emplace_back();
}

void SafeIntervals::add_vertices(std::size_t count) {
  const RobotModel& robot = task_.checker.robot();
  const std::size_t max_samples = options_.max_samples_per_vertex * count;
  for (std::size_t samples = 0, added = 0; added < count && samples < max_samples; ++samples) {
    if (deadline_.stop_requested()) return;
    Eigen::VectorXd q = sample();
    if (constraints_ && !constraints_->project(q, constraint_fractions.configurations)) continue;
    if (robot.limit_violation(q) || !task_.checker.is_free(q, *workspace_)) continue;
    add(std::move(q));
    ++added;
  }
  connect();
}

/// A configuration of the path with some joints displaced.
Eigen::VectorXd SafeIntervals::sample() {
  const RobotModel& robot = task_.checker.robot();
  const std::size_t segments = task_.path.size() > 1 ? task_.path.size() - 1 : 0;
  Eigen::VectorXd q = task_.start;
  if (segments > 0) {
    const double at = random_.next() * static_cast<double>(segments);
    const std::size_t k = std::min(static_cast<std::size_t>(at), segments - 1);
    q = task_.path[k] + (at - static_cast<double>(k)) * robot.difference(task_.path[k], task_.path[k + 1]);
  }
  for (std::size_t j = 0; j < robot.dof(); ++j) {
    const double choice = random_.next(), by = 2.0 * random_.next() - 1.0;
    if (choice > options_.displaced_fraction) continue;
    const Joint& joint = robot.joints()[j];
    const bool prismatic = joint.kind == JointKind::prismatic;
    const auto i = static_cast<Eigen::Index>(j);
    q[i] += by * (prismatic ? options_.max_prismatic_displacement : options_.max_displacement);
    if (joint.kind != JointKind::continuous) q[i] = std::clamp(q[i], joint.lower, joint.upper);
  }
  return q;
}

/// Each vertex with its nearest neighbours, and with start and targets, both ways.
void SafeIntervals::connect() {
  for (auto p = static_cast<Vertex>(neighbours_.size()); p < vertices_.size(); ++p) {
    if (deadline_.stop_requested()) return;
    find_neighbours(p);
  }
  const auto size = static_cast<Vertex>(vertices_.size()), ends = static_cast<Vertex>(1 + task_.targets.size());
  edges_.assign(size, {});
  const auto connect_both = [&](Vertex a, Vertex b) {
    if (a == b) return;
    edges_[a].push_back(b);
    edges_[b].push_back(a);
  };
  for (Vertex p = 0; p < size; ++p) {
    for (Vertex end = 0; end < ends; ++end) connect_both(p, end);
    for (const auto& [distance, other] : neighbours_[p]) connect_both(p, other);
  }
  for (std::vector<Vertex>& edges : edges_) {
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  }
  compute_steps_to_go();
}

/// Among the vertices before p, which may become a neighbour of theirs too.
void SafeIntervals::find_neighbours(Vertex p) {
  neighbours_.emplace_back();
  const auto keep = [&](Vertex of, double distance, Vertex other) {
    Neighbours& nearest = neighbours_[of];
    const std::pair<double, Vertex> entry{distance, other};
    if (nearest.size() == options_.neighbours && nearest.back() < entry) return;
    nearest.insert(std::lower_bound(nearest.begin(), nearest.end(), entry), entry);
    if (nearest.size() > options_.neighbours) nearest.pop_back();
  };
  const RobotModel& robot = task_.checker.robot();
  for (Vertex other = 0; other < p; ++other) {
    const double distance = robot.difference(vertices_[p], vertices_[other]).norm();
    keep(p, distance, other);
    keep(other, distance, p);
  }
}

/// A consistent heuristic: no path takes fewer steps.
void SafeIntervals::compute_steps_to_go() {
  if (task_.targets.empty()) {
    steps_to_go_.assign(vertices_.size(), 0);
    return;
  }
  std::vector<Vertex> targets(task_.targets.size());
  std::iota(targets.begin(), targets.end(), Vertex{1});
  steps_to_go_ = search::costs_to_go<int>(
      vertices_.size(), targets,
      [&](Vertex to, auto&& relax) {
        for (const Vertex from : edges_[to]) relax(from, min_steps(from, to));
      },
      deadline_);
}

/// Of a straight motion whose velocities and accelerations alone are limited.
int SafeIntervals::min_steps(Vertex a, Vertex b) const {
  const Eigen::ArrayXd distance = task_.checker.robot().difference(vertices_[a], vertices_[b]).array().abs();
  const double cruise = (distance / task_.limits.velocity.array()).maxCoeff();
  const double ramp = std::sqrt((distance / task_.limits.acceleration.array()).maxCoeff());
  const double time = ramp > cruise || cruise == 0.0 ? 2.0 * ramp : cruise + ramp * ramp / cruise;
  return std::max(1, static_cast<int>(std::ceil(time / time_step - 0.05)));
}

/// Checked among all that is static at the first call.
const SafeIntervals::Edge& SafeIntervals::edge(Vertex from, Vertex to) {
  const std::pair ends(from, to);
  if (const auto known = checked_edges_.find(ends); known != checked_edges_.end()) return known->second;
  return checked_edges_.emplace(ends, checked_edge(from, to)).first->second;  // unless the deadline cuts the check off
}

bool SafeIntervals::is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (!constraints_ || constraints_->keeps(a, b, constraint_fractions.motions)) &&
         task_.checker.is_motion_free(a, b, *workspace_, {.start_is_free = true});
}

SafeIntervals::Edge SafeIntervals::checked_edge(Vertex from, Vertex to) {
  ++edge_checks_;
  Edge edge;
  edge.free = is_motion_free(vertices_[from], vertices_[to]);
  if (!edge.free) return edge;
  RowMatrix ends(2, vertices_[from].size());
  ends.row(0) = vertices_[from].transpose();
  ends.row(1) = ends.row(0) + task_.checker.robot().difference(vertices_[from], vertices_[to]).transpose();
  if (ends.row(0) == ends.row(1)) {  // a target at the start
    edge.rows = ends;
    return edge;
  }
  const Trajectory motion = task_.parameterize(ends);
  const int steps = std::max(1, static_cast<int>(std::ceil(end_of(motion) / time_step - 1e-9)));
  edge.rows.resize(steps + 1, ends.cols());
  for (int k = 0; k <= steps; ++k)
    edge.rows.row(k) = motion.sample(std::min(k * time_step, end_of(motion))).transpose();
  return edge;
}

// --- time

/// Configurations of the pair: the robot at `rows`, one a step from `step` on, and the other robot at these steps.
RowMatrix SafeIntervals::with_other(std::size_t other, const RowMatrix& rows, int step) const {
  RowMatrix other_rows(rows.rows(), motions_[other].cols());
  for (Eigen::Index k = 0; k < rows.rows(); ++k)
    other_rows.row(k) = motions_[other].row(std::min(static_cast<int>(k) + step, last_step_));
  return side_by_side(rows, other_rows, task_.other_robots[other].joints_first);
}

/// First at all steps, since that finds most collisions, then between them.
bool SafeIntervals::is_free(const RowMatrix& rows, int step) {
  const auto count = static_cast<std::size_t>(rows.rows());
  ++edge_checks_;
  const auto free = std::make_unique<bool[]>(count);
  for (std::size_t i = 0; i < task_.other_robots.size(); ++i) {
    checks_ += count;
    const RowMatrix both = with_other(i, rows, step);
    task_.other_robots[i].checker->are_free(both, {free.get(), count}, *pair_workspaces_[i]);
    if (!std::all_of(free.get(), free.get() + count, [](bool is_free) { return is_free; })) return false;
  }
  for (std::size_t i = 0; i < task_.other_robots.size(); ++i) {
    const RowMatrix both = with_other(i, rows, step);
    for (Eigen::Index k = 0; k + 1 < both.rows(); ++k)
      if (!task_.other_robots[i].checker->is_motion_free(both.row(k).transpose(), both.row(k + 1).transpose(),
                                                         *pair_workspaces_[i], {.start_is_free = true}))
        return false;
  }
  return true;
}

/// For each step: is the vertex free then (even entries), and until the next step (odd entries)?
std::vector<char> SafeIntervals::free_waits(Vertex p) {
  std::vector<char> free(2 * static_cast<std::size_t>(last_step_ + 1), true);
  for (std::size_t i = 0; i < task_.other_robots.size(); ++i)
    for (int first = 0; first <= last_step_; first += options_.block) {
      if (deadline_.stop_requested()) return free;
      check_waits(i, p, first, std::min(options_.block, last_step_ + 1 - first), free);
    }
  for (auto at = forbidden_waits_.lower_bound({p, 0}); at != forbidden_waits_.end() && at->first == p; ++at)
    free[2 * static_cast<std::size_t>(std::min(at->second, last_step_)) + (at->second < last_step_ ? 1 : 0)] = false;
  return free;
}

/// `count` steps from `first` on.
void SafeIntervals::check_waits(std::size_t other, Vertex p, int first, int count, std::vector<char>& free) {
  const Checker& checker = *task_.other_robots[other].checker;
  const int rows = count + (first + count <= last_step_ ? 1 : 0);  // the next block's first, for the motion to it
  const RowMatrix both = with_other(other, vertices_[p].transpose().replicate(rows, 1), first);
  const auto now = std::make_unique<bool[]>(static_cast<std::size_t>(rows));
  checker.are_free(both, {now.get(), static_cast<std::size_t>(rows)}, *pair_workspaces_[other]);
  checks_ += static_cast<std::uint64_t>(count);
  for (int k = 0; k < count; ++k) {
    char* const at = &free[2 * static_cast<std::size_t>(first + k)];
    at[0] = at[0] && now[static_cast<std::size_t>(k)];
    if (k + 1 == rows || !at[1]) continue;
    at[1] = now[static_cast<std::size_t>(k)] && now[static_cast<std::size_t>(k) + 1] &&
            checker.is_motion_free(both.row(k).transpose(), both.row(k + 1).transpose(), *pair_workspaces_[other],
                                   {.start_is_free = true});
  }
}

const std::vector<SafeIntervals::Interval>& SafeIntervals::intervals(Vertex p) {
  if (intervals_[p]) return *intervals_[p];
  const std::vector<char> free = free_waits(p);
  std::vector<Interval>& found = intervals_[p].emplace();
  for (int k = 0; k <= last_step_; ++k) {
    const auto at = 2 * static_cast<std::size_t>(k);
    if (!free[at]) continue;
    if (k > 0 && free[at - 2] && free[at - 1])
      found.back().to = k;
    else
      found.push_back({k, k});
  }
  if (!found.empty() && found.back().to == last_step_) found.back().to = forever;
  return found;
}

void SafeIntervals::forbid(const std::vector<TimedStop>& stops, double from, double to) {
  int arrival = 0;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const TimedStop& stop = stops[i];
    const bool last = i + 1 == stops.size();
    if (last || from < stop.leaves()) {
      const int first = std::max(arrival, static_cast<int>(from / time_step));
      for (int k = first; k == first || (k < std::min(stop.step, last_step_) && k * time_step < to); ++k)
        forbidden_waits_.emplace(stop.vertex, k);
      intervals_[stop.vertex].reset();
      return;
    }
    arrival = stop.step + edge(stop.vertex, stops[i + 1].vertex).steps();
    if (from > arrival * time_step) continue;
    for (int later = 0; later == 0 || later * time_step < to - from; ++later)
      forbidden_departures_.insert({{stop.vertex, stops[i + 1].vertex}, stop.step + later});
    return;
  }
}

std::size_t SafeIntervals::memory() const {
  const std::size_t row = static_cast<std::size_t>(task_.start.size()) * sizeof(double);
  std::size_t sum = memory_of(vertices_) + vertices_.size() * row + memory_of(edges_) + memory_of(neighbours_) +
                    memory_of(steps_to_go_) + memory_of(checked_edges_) + memory_of(intervals_) +
                    max_nodes_ * sizeof(std::pair<Node, search::NodeId>);
  for (const RowMatrix& motion : motions_) sum += static_cast<std::size_t>(motion.size()) * sizeof(double);
  for (const std::vector<Vertex>& edges : edges_) sum += memory_of(edges);
  for (const Neighbours& nearest : neighbours_) sum += memory_of(nearest);
  for (const auto& [ends, edge] : checked_edges_) sum += static_cast<std::size_t>(edge.rows.size()) * sizeof(double);
  for (const auto& found : intervals_) sum += found ? memory_of(*found) : 0;
  return sum;
}

// --- the search

/// One search of the roadmap in time; a search::BestFirstProblem.
///
/// Lazy in three stages, each when the node comes out of OPEN: a new node is an arrival at the earliest step that the
/// heuristic allows. In its place come nodes for the intervals of its vertex, with the earliest departures that reach
/// them; and in place of a departure that collides, a later one.
class SafeIntervals::Query {
 public:
  Query(SafeIntervals& map, double max_arrival, std::uint64_t max_checks)
      : map_(map), max_arrival_(max_arrival), max_checks_(max_checks), closed_(map.vertices_.size()) {}

  Result run() {
    checks_before_ = map_.checks_;
    if (!map_.deadline_.stop_requested() && can_be_solved())
      add({.vertex = 0, .interval = 0, .checked = true}, search::no_node);
    const search::BestFirstResult found = search_.run(*this, map_.deadline_);
    map_.max_nodes_ = std::max(map_.max_nodes_, search_.size());
    Result result{found.status, {}, found.expansions};
    if (found.status == Status::solved) result.stops = stops(found.goal);
    return result;
  }

  bool is_dominated(const Node& node) { return node.interval >= 0 && closed(node.vertex, node.interval); }
  bool is_valid(search::NodeId id) {
    if (search_[id].interval < 0)
      add_departures(id);
    else if (!search_[id].checked)
      check_departure(id);
    else
      return true;
    return false;  // others took its place
  }
  void close(const Node& node) { closed(node.vertex, node.interval) = true; }
  bool is_goal(const Node& node) { return map_.is_goal(node.vertex) && interval(node).to == forever; }
  bool may_continue() const { return map_.checks_ - checks_before_ <= max_checks_; }

  void expand(search::NodeId id) {
    const Node node = search_[id];
    for (const Vertex next : map_.edges_[node.vertex])
      add({.vertex = next, .arrival = node.arrival + map_.min_steps(node.vertex, next)}, id);
  }

 private:
  /// The robot can be where it starts, and stay at a target.
  bool can_be_solved() const {
    const std::vector<Interval>& at_start = map_.intervals(0);
    if (at_start.empty() || at_start.front().from > 0) return false;
    const std::size_t targets = map_.task_.targets.size();
    bool can_stay = targets == 0;
    for (Vertex target = 1; target <= targets && !can_stay; ++target) {
      const std::vector<Interval>& there = map_.intervals(target);
      can_stay = !there.empty() && there.back().to == forever;
    }
    return can_stay;
  }

  Interval interval(const Node& node) { return map_.intervals(node.vertex)[static_cast<std::size_t>(node.interval)]; }

  char& closed(Vertex p, int interval) {
    std::vector<char>& row = closed_[p];
    row.resize(std::max(row.size(), map_.intervals(p).size()), false);
    return row[static_cast<std::size_t>(interval)];
  }

  /// Ordered by arrival; of those that arrive at the same time the one with the shorter path.
  void add(Node node, search::NodeId parent) {
    const int steps_to_go = map_.steps_to_go_[node.vertex];
    if (steps_to_go == forever || (node.arrival + steps_to_go) * time_step >= max_arrival_) return;
    if (parent != search::no_node) {
      const Eigen::VectorXd &from = map_.vertices_[search_[parent].vertex], &to = map_.vertices_[node.vertex];
      node.length = search_[parent].length + map_.task_.checker.robot().difference(from, to).norm();
    }
    search_.add(node, {node.arrival + steps_to_go, node.length}, parent);
  }

  /// For each interval of the vertex, the first departure that may reach it.
  void add_departures(search::NodeId id) {
    const Node node = search_[id];
    const search::NodeId parent = search_.parent(id);
    const Node from = search_[parent];
    const int count = static_cast<int>(map_.intervals(node.vertex).size());
    bool open = false;
    for (int i = 0; i < count; ++i) open = open || !closed(node.vertex, i);
    if (!open || !map_.edge(from.vertex, node.vertex).free) return;
    const int steps = map_.edge(from.vertex, node.vertex).steps();
    for (int i = 0; i < count; ++i) {
      Node next = node;
      next.interval = i;
      next.departure = std::max(from.arrival, interval(next).from - steps);
      if (!closed(node.vertex, i)) add_departure(next, steps, parent);
    }
  }

  /// If the robot can wait so long at the parent's vertex and arrives within the interval.
  void add_departure(Node node, int steps, search::NodeId parent) {
    const Node& from = search_[parent];
    const Interval to = interval(node);
    if (node.departure > interval(from).to || (to.to != forever && node.departure + steps > to.to)) return;
    if (node.departure > std::max(from.arrival, map_.last_step_)) return;  // from then on nothing changes
    node.arrival = node.departure + steps;
    add(node, parent);
  }

  /// Puts the checked departure back, or a later one: by a step, or by a fraction of the wait so far, so that long
  /// waits are not tried step by step.
  void check_departure(search::NodeId id) {
    Node node = search_[id];
    const search::NodeId parent = search_.parent(id);
    const Vertex from = search_[parent].vertex;
    const Edge& edge = map_.edge(from, node.vertex);
    node.checked = !map_.forbidden_departures_.contains({{from, node.vertex}, node.departure}) &&
                   map_.is_free(edge.rows, node.departure);
    if (!node.checked) {
      const int first = std::max(search_[parent].arrival, interval(node).from - edge.steps());
      node.departure += std::max(1, (node.departure - first) / map_.options_.wait_divisor);
    }
    add_departure(node, edge.steps(), parent);
  }

  std::vector<TimedStop> stops(search::NodeId goal) const {
    std::vector<TimedStop> found;
    for (const search::NodeId id : search_.path_to(goal)) {
      const Node& node = search_[id];
      if (!found.empty()) found.back().step = node.departure;
      found.push_back({map_.vertices_[node.vertex], node.vertex, TimedStop::never});
    }
    return found;
  }

  SafeIntervals& map_;
  double max_arrival_;
  std::uint64_t max_checks_;
  std::uint64_t checks_before_{};
  std::vector<std::vector<char>> closed_;                         // by vertex and interval
  search::BestFirstSearch<Node, std::pair<int, double>> search_;  // by arrival at a target at the earliest, length
};

SafeIntervals::Result SafeIntervals::run(double max_arrival, std::uint64_t max_checks) {
  return Query(*this, max_arrival, max_checks).run();
}

}  // namespace srmp
