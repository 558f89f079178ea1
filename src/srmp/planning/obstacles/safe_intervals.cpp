#include "srmp/planning/obstacles/safe_intervals.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <queue>
#include <tuple>

#include "srmp/core/memory_of.hpp"
#include "srmp/planning/group_checkers.hpp"

namespace srmp {

namespace {

constexpr std::size_t neighbours = 12;     // of a point
constexpr double spacing = 0.6;            // of points on the way [rad, prismatic joints m]
constexpr double share_of_joints = 0.4;    // that are moved for a point about the way
constexpr double farthest = 1.6;           // that a joint is moved [rad]
constexpr double farthest_straight = 0.5;  // the same [m]
constexpr std::size_t max_tries = 50;      // for a point
constexpr int patience = 64;               // a departure is tried again after this share of the wait, or a step
constexpr int block = 256;                 // of steps, between two looks at the clock

}  // namespace

SafeIntervals::SafeIntervals(const TimedTask& task, const Deadline& deadline)
    : task_(task), deadline_(deadline), workspace_(task.alone.make_workspace()) {
  for (const MovingRobot& other : task.others)
    last_ = std::max(last_, static_cast<int>(std::ceil(end_of(*other.motion) / time_step)));
  for (const MovingRobot& other : task.others) {
    pairs_.push_back(other.pair->make_workspace());
    RowMatrix& rows = motions_.emplace_back(last_ + 1, other.motion->positions.cols());
    for (int step = 0; step <= last_; ++step)
      rows.row(step) = other.motion->sample(std::min(step * time_step, end_of(*other.motion))).transpose();
  }
  add(task.start);
  for (const Eigen::VectorXd& target : task.targets) add(target);
  const RobotModel& robot = task.alone.robot();
  for (std::size_t k = 1; k < task.way.size(); ++k) {
    const Eigen::VectorXd step = robot.difference(task.way[k - 1], task.way[k]);
    const int parts = std::max(1, static_cast<int>(std::ceil(step.norm() / spacing)));
    for (int i = k == 1 ? 1 : 0; i < parts; ++i) add(task.way[k - 1] + static_cast<double>(i) / parts * step);
  }
  connect();
}

// --- the roadmap

void SafeIntervals::add(Eigen::VectorXd q) {
  points_.push_back(std::move(q));
  intervals_.emplace_back();
}

/// Somewhere on the way, some joints moved.
void SafeIntervals::add_points(std::size_t count) {
  const RobotModel& robot = task_.alone.robot();
  const std::size_t stations = task_.way.size() > 1 ? task_.way.size() - 1 : 0;
  const auto random = [this] { return sequence_.next(); };
  for (std::size_t tries = 0, added = 0; added < count && tries < max_tries * count; ++tries) {
    if (deadline_.stop_requested()) return;
    Eigen::VectorXd q = task_.start;
    if (stations > 0) {
      const double at = random() * static_cast<double>(stations);
      const std::size_t k = std::min(static_cast<std::size_t>(at), stations - 1);
      q = task_.way[k] + (at - static_cast<double>(k)) * robot.difference(task_.way[k], task_.way[k + 1]);
    }
    for (std::size_t j = 0; j < robot.dof(); ++j) {
      const double moved = random(), by = 2.0 * random() - 1.0;
      if (moved > share_of_joints) continue;
      const Joint& joint = robot.joints()[j];
      const auto i = static_cast<Eigen::Index>(j);
      q[i] += by * (joint.kind == JointKind::prismatic ? farthest_straight : farthest);
      if (joint.kind != JointKind::continuous) q[i] = std::clamp(q[i], joint.lower, joint.upper);
    }
    if (robot.limit_violation(q) || !task_.alone.is_free(q, *workspace_)) continue;
    add(std::move(q));
    ++added;
  }
  connect();
}

/// Each with its nearest, and with start and targets, in both directions.
void SafeIntervals::connect() {
  for (auto p = static_cast<Point>(nearest_.size()); p < points_.size(); ++p) {
    if (deadline_.stop_requested()) return;
    find_nearest(p);
  }
  const auto size = static_cast<Point>(points_.size()), ends = static_cast<Point>(1 + task_.targets.size());
  next_.assign(size, {});
  const auto join = [&](Point a, Point b) {
    if (a == b) return;
    next_[a].push_back(b);
    next_[b].push_back(a);
  };
  for (Point p = 0; p < size; ++p) {
    for (Point end = 0; end < ends; ++end) join(p, end);
    for (const auto& [distance, other] : nearest_[p]) join(p, other);
  }
  for (std::vector<Point>& next : next_) {
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
  }
  find_steps_left();
}

/// Of the points before p, whose nearest it may be too.
void SafeIntervals::find_nearest(Point p) {
  nearest_.emplace_back();
  const auto keep = [&](Point of, double distance, Point other) {
    Near& near = nearest_[of];
    const std::pair<double, Point> entry{distance, other};
    if (near.size() == neighbours && near.back() < entry) return;
    near.insert(std::lower_bound(near.begin(), near.end(), entry), entry);
    if (near.size() > neighbours) near.pop_back();
  };
  const RobotModel& robot = task_.alone.robot();
  for (Point other = 0; other < p; ++other) {
    const double distance = robot.difference(points_[p], points_[other]).norm();
    keep(p, distance, other);
    keep(other, distance, p);
  }
}

/// By Dijkstra; no way is shorter.
void SafeIntervals::find_steps_left() {
  left_.assign(points_.size(), task_.targets.empty() ? 0 : forever);
  using Entry = std::pair<int, Point>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (Point p = 1; p <= task_.targets.size(); ++p) {
    left_[p] = 0;
    open.emplace(0, p);
  }
  while (!open.empty() && !deadline_.stop_requested()) {
    const auto [steps, p] = open.top();
    open.pop();
    if (steps > left_[p]) continue;
    for (const Point other : next_[p])
      if (const int all = steps + min_steps(other, p); all < left_[other]) {
        left_[other] = all;
        open.emplace(all, other);
      }
  }
}

/// With no more than velocities and accelerations limited.
int SafeIntervals::min_steps(Point a, Point b) const {
  const Eigen::ArrayXd way = task_.alone.robot().difference(points_[a], points_[b]).array().abs();
  const double cruise = (way / task_.limits.velocity.array()).maxCoeff();
  const double ramp = std::sqrt((way / task_.limits.acceleration.array()).maxCoeff());
  const double time = ramp > cruise || cruise == 0.0 ? 2.0 * ramp : cruise + ramp * ramp / cruise;
  return std::max(1, static_cast<int>(std::ceil(time / time_step - 0.05)));
}

const SafeIntervals::Way& SafeIntervals::way(Point from, Point to) {
  Way& way = ways_[{from, to}];
  if (std::exchange(way.known, true)) return way;
  ++edge_checks_;
  way.free = task_.alone.is_motion_free(points_[from], points_[to], *workspace_, {.start_is_free = true});
  if (!way.free) return way;
  RowMatrix ends(2, points_[from].size());
  ends.row(0) = points_[from].transpose();
  ends.row(1) = ends.row(0) + task_.alone.robot().difference(points_[from], points_[to]).transpose();
  if (ends.row(0) == ends.row(1)) {  // a goal where it starts
    way.rows = ends;
    return way;
  }
  const Trajectory motion = task_.in_time(ends);
  const int steps = std::max(1, static_cast<int>(std::ceil(end_of(motion) / time_step - 1e-9)));
  way.rows.resize(steps + 1, ends.cols());
  for (int k = 0; k <= steps; ++k) way.rows.row(k) = motion.sample(std::min(k * time_step, end_of(motion))).transpose();
  return way;
}

// --- time

/// The arm at rows, a step each from `step` on, and the other where it is then.
RowMatrix SafeIntervals::beside(std::size_t other, const RowMatrix& rows, int step) const {
  RowMatrix its(rows.rows(), motions_[other].cols());
  for (Eigen::Index k = 0; k < rows.rows(); ++k)
    its.row(k) = motions_[other].row(std::min(static_cast<int>(k) + step, last_));
  return side_by_side(rows, its, task_.others[other].stands_before_arm);
}

bool SafeIntervals::is_free(const RowMatrix& rows, int step) {
  const auto count = static_cast<std::size_t>(rows.rows());
  ++edge_checks_;
  const auto free = std::make_unique<bool[]>(count);
  for (std::size_t i = 0; i < task_.others.size(); ++i) {
    looks_ += count;
    const RowMatrix both = beside(i, rows, step);
    task_.others[i].pair->are_free(both, {free.get(), count}, *pairs_[i]);
    if (!std::all_of(free.get(), free.get() + count, [](bool fine) { return fine; })) return false;
  }
  for (std::size_t i = 0; i < task_.others.size(); ++i) {
    const RowMatrix both = beside(i, rows, step);
    for (Eigen::Index k = 0; k + 1 < both.rows(); ++k)
      if (!task_.others[i].pair->is_motion_free(both.row(k).transpose(), both.row(k + 1).transpose(), *pairs_[i],
                                                {.start_is_free = true}))
        return false;
  }
  return true;
}

/// Of each step: is the arm free there (even entries), and until the next (odd ones)?
std::vector<char> SafeIntervals::rests_free(Point p) {
  std::vector<char> free(2 * static_cast<std::size_t>(last_ + 1), true);
  for (std::size_t i = 0; i < task_.others.size(); ++i)
    for (int first = 0; first <= last_; first += block) {
      if (deadline_.stop_requested()) return free;
      look_at_rest(i, p, first, std::min(block, last_ + 1 - first), free);
    }
  for (auto at = no_rest_.lower_bound({p, 0}); at != no_rest_.end() && at->first == p; ++at)
    free[2 * static_cast<std::size_t>(std::min(at->second, last_)) + (at->second < last_ ? 1 : 0)] = false;
  return free;
}

/// From a step on, so many of them.
void SafeIntervals::look_at_rest(std::size_t other, Point p, int first, int count, std::vector<char>& free) {
  const Checker& pair = *task_.others[other].pair;
  const int rows = count + (first + count <= last_ ? 1 : 0);  // the next block's first, for the way to it
  const RowMatrix both = beside(other, points_[p].transpose().replicate(rows, 1), first);
  const auto now = std::make_unique<bool[]>(static_cast<std::size_t>(rows));
  pair.are_free(both, {now.get(), static_cast<std::size_t>(rows)}, *pairs_[other]);
  looks_ += static_cast<std::uint64_t>(count);
  for (int k = 0; k < count; ++k) {
    char* const at = &free[2 * static_cast<std::size_t>(first + k)];
    at[0] = at[0] && now[static_cast<std::size_t>(k)];
    if (k + 1 == rows || !at[1]) continue;
    at[1] = now[static_cast<std::size_t>(k)] && now[static_cast<std::size_t>(k) + 1] &&
            pair.is_motion_free(both.row(k).transpose(), both.row(k + 1).transpose(), *pairs_[other],
                                {.start_is_free = true});
  }
}

const std::vector<SafeIntervals::Interval>& SafeIntervals::intervals(Point p) {
  if (intervals_[p]) return *intervals_[p];
  const std::vector<char> free = rests_free(p);
  std::vector<Interval>& found = intervals_[p].emplace();
  for (int k = 0; k <= last_; ++k) {
    const auto at = 2 * static_cast<std::size_t>(k);
    if (!free[at]) continue;
    if (k > 0 && free[at - 2] && free[at - 1])
      found.back().to = k;
    else
      found.push_back({k, k});
  }
  if (!found.empty() && found.back().to == last_) found.back().to = forever;
  return found;
}

void SafeIntervals::forbid(const std::vector<TimedStop>& stops, double from, double to) {
  int arrival = 0;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const TimedStop& stop = stops[i];
    const bool last = i + 1 == stops.size();
    if (last || from < stop.leaves()) {
      const int first = std::max(arrival, static_cast<int>(from / time_step));
      for (int k = first; k == first || (k < std::min(stop.step, last_) && k * time_step < to); ++k)
        no_rest_.emplace(stop.point, k);
      intervals_[stop.point].reset();
      return;
    }
    arrival = stop.step + way(stop.point, stops[i + 1].point).steps();
    if (from > arrival * time_step) continue;
    for (int later = 0; later == 0 || later * time_step < to - from; ++later)
      no_departure_.insert({{stop.point, stops[i + 1].point}, stop.step + later});
    return;
  }
}

std::size_t SafeIntervals::memory() const {
  const std::size_t row = static_cast<std::size_t>(task_.start.size()) * sizeof(double);
  std::size_t sum = memory_of(points_) + points_.size() * row + memory_of(next_) + memory_of(nearest_) +
                    memory_of(left_) + memory_of(ways_) + memory_of(intervals_) + max_nodes_ * sizeof(Node);
  for (const RowMatrix& motion : motions_) sum += static_cast<std::size_t>(motion.size()) * sizeof(double);
  for (const std::vector<Point>& next : next_) sum += memory_of(next);
  for (const Near& near : nearest_) sum += memory_of(near);
  for (const auto& [ends, way] : ways_) sum += static_cast<std::size_t>(way.rows.size()) * sizeof(double);
  for (const auto& found : intervals_) sum += found ? memory_of(*found) : 0;
  return sum;
}

// --- the search

class SafeIntervals::Query {
 public:
  Query(SafeIntervals& map, double before) : map_(map), before_(before), taken_(map.points_.size()) {}

  ~Query() { map_.max_nodes_ = std::max(map_.max_nodes_, nodes_.size()); }

  Result run(std::uint64_t max_looks) {
    Result result;
    const std::uint64_t looks = map_.looks_;
    if (!map_.deadline_.stop_requested() && can_be_solved())
      push({.point = 0, .interval = 0, .parent = none, .possible = true});
    while (true) {
      if (map_.deadline_.cancelled()) return {Status::cancelled, {}, result.expansions};
      if (map_.deadline_.expired()) return {Status::timed_out, {}, result.expansions};
      if (open_.empty()) return result;
      if (map_.looks_ - looks > max_looks) return {Status::timed_out, {}, result.expansions};
      const std::uint32_t id = std::get<2>(open_.top());
      open_.pop();
      const Node node = nodes_[id];
      if (node.interval < 0) {
        add_departures(node);
        continue;
      }
      if (taken(node.point, node.interval)) continue;
      if (!node.possible) {
        depart(node);
        continue;
      }
      taken(node.point, node.interval) = true;
      if (map_.is_goal(node.point) && interval(node).to == forever) {
        result.status = Status::solved;
        result.stops = stops(id);
        return result;
      }
      ++result.expansions;
      for (const Point next : map_.next_[node.point])
        push({.point = next, .arrival = node.arrival + map_.min_steps(node.point, next), .parent = id});
    }
  }

 private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  /// It can be where it starts, and stay at a target.
  bool can_be_solved() const {
    const std::vector<Interval>& at_start = map_.intervals(0);
    if (at_start.empty() || at_start.front().from > 0) return false;
    const std::size_t targets = map_.task_.targets.size();
    bool can_stay = targets == 0;
    for (Point target = 1; target <= targets && !can_stay; ++target) {
      const std::vector<Interval>& there = map_.intervals(target);
      can_stay = !there.empty() && there.back().to == forever;
    }
    return can_stay;
  }

  Interval interval(const Node& node) { return map_.intervals(node.point)[static_cast<std::size_t>(node.interval)]; }

  char& taken(Point p, int interval) {
    std::vector<char>& row = taken_[p];
    row.resize(std::max(row.size(), map_.intervals(p).size()), false);
    return row[static_cast<std::size_t>(interval)];
  }

  /// First come, first served; of those that come at the same time the one with the shorter way.
  void push(Node node) {
    const int left = map_.left_[node.point];
    if (left == forever || (node.arrival + left) * time_step >= before_) return;
    if (node.parent != none)
      node.length =
          nodes_[node.parent].length +
          map_.task_.alone.robot().difference(map_.points_[nodes_[node.parent].point], map_.points_[node.point]).norm();
    nodes_.push_back(node);
    open_.emplace(node.arrival + left, node.length, static_cast<std::uint32_t>(nodes_.size() - 1));
  }

  /// The first that is worth a look, for each interval at the other end.
  void add_departures(const Node& node) {
    const Node from = nodes_[node.parent];
    const int count = static_cast<int>(map_.intervals(node.point).size());
    bool open = false;
    for (int i = 0; i < count; ++i) open = open || !taken(node.point, i);
    if (!open || !map_.way(from.point, node.point).free) return;
    const int steps = map_.way(from.point, node.point).steps();
    for (int i = 0; i < count; ++i) {
      Node next = node;
      next.interval = i;
      next.left = std::max(from.arrival, interval(next).from - steps);
      if (!taken(node.point, i)) push_departure(next, steps);
    }
  }

  /// If it can wait so long here and comes in time there.
  void push_departure(Node node, int steps) {
    const Node& from = nodes_[node.parent];
    const Interval there = interval(node);
    if (node.left > interval(from).to || (there.to != forever && node.left + steps > there.to)) return;
    if (node.left > std::max(from.arrival, map_.last_)) return;  // from then on nothing changes
    node.arrival = node.left + steps;
    push(node);
  }

  /// It does, or later: by a step, or by a share of the wait so far, so that long waits are not tried step by step.
  void depart(Node node) {
    const Point from = nodes_[node.parent].point;
    const Way& way = map_.way(from, node.point);
    node.possible = !map_.no_departure_.contains({{from, node.point}, node.left}) && map_.is_free(way.rows, node.left);
    if (!node.possible) {
      const int first = std::max(nodes_[node.parent].arrival, interval(node).from - way.steps());
      node.left += std::max(1, (node.left - first) / patience);
    }
    push_departure(node, way.steps());
  }

  std::vector<TimedStop> stops(std::uint32_t id) const {
    std::vector<TimedStop> found;
    int leaves = TimedStop::never;
    for (; id != none; id = nodes_[id].parent) {
      const Node& node = nodes_[id];
      found.push_back({map_.points_[node.point], node.point, leaves});
      leaves = node.left;
    }
    std::reverse(found.begin(), found.end());
    return found;
  }

  SafeIntervals& map_;
  double before_;
  std::vector<std::vector<char>> taken_;  // by point and interval
  std::vector<Node> nodes_;
  using Entry = std::tuple<int, double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

SafeIntervals::Result SafeIntervals::run(double before, std::uint64_t max_looks) {
  return Query(*this, before).run(max_looks);
}

}  // namespace srmp
