#include "srmp/planning/strategies/composite_roadmap.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <string>
#include <unordered_map>

#include "srmp/core/memory_of.hpp"
#include "srmp/search/lazy_tree.hpp"

namespace srmp {

namespace {

constexpr double spacing = 0.25;   // of points on a way [rad, prismatic joints m]
constexpr std::size_t tries = 32;  // for an aside
constexpr std::size_t max_points = 10'000;
constexpr std::uint32_t max_stations = 2;  // of a way
constexpr char not_known = 2;              // of points of two arms: do they go together?
constexpr std::size_t block = 16;          // points that are looked at together
constexpr double pause = 0.02;             // cost of a step in itself, so that arms move at the same time

}  // namespace

RoadmapSearch::RoadmapSearch(MultiRobotWorld& world, std::size_t asides)
    : world_(world), asides_(asides), has_asides_(world.size(), false) {
  for (std::size_t a = 0; a < world.size(); ++a) {
    maps_.push_back(way_of(a));
    ways_.push_back(maps_.back().points);
    for (std::size_t b = a + 1; b < world.size(); ++b)
      if (world.may_conflict(a, b)) pairs_.try_emplace({a, b}, a, b);
  }
}

// --- roadmaps

/// Points from one of the map's to q by a straight motion, known to be free; q is the last unless it is there already.
void RoadmapSearch::add_straight(Roadmap& map, std::size_t arm, Point from, const Eigen::VectorXd& q,
                                 std::optional<Point> known) const {
  const Eigen::VectorXd start = map.points[from], way = world_.robot(arm).difference(start, q);
  const int parts = std::max(1, static_cast<int>(std::ceil(way.norm() / spacing)));
  const double length = way.norm() / parts;
  Point last = from;
  for (int k = 1; k <= parts; ++k) {
    Point next = known.value_or(0);
    if (k < parts || !known) {
      next = static_cast<Point>(map.points.size());
      map.points.push_back(k < parts ? Eigen::VectorXd(start + static_cast<double>(k) / parts * way) : q);
      map.next.emplace_back();
    }
    map.next[last].push_back({next, length});
    map.next[next].push_back({last, length});
    last = next;
  }
}

Roadmap RoadmapSearch::way_of(std::size_t arm) const {
  const WorldTask& task = world_.task(arm);
  Roadmap map;
  map.points = {task.start};
  map.next.resize(1);
  for (std::size_t k = 1; k < task.backbone.size() && !task.anywhere; ++k) {
    const Eigen::VectorXd corner = task.backbone[k];
    add_straight(map, arm, map.goal, corner);
    map.goal = static_cast<Point>(map.points.size() - 1);
  }
  return map;
}

/// Where ways aside begin: points all along an arm's way, its ends among them.
std::vector<RoadmapSearch::Point> RoadmapSearch::stations(const Roadmap& map) {
  std::vector<Point> found;
  const Point count = std::min(max_stations, map.goal + 1);
  for (Point k = 0; k < count; ++k) found.push_back(count > 1 ? k * map.goal / (count - 1) : 0);
  return found;
}

/// Points near the way's stations, one or two joints moved: the shortest ways round first.
std::vector<Eigen::VectorXd> RoadmapSearch::asides(std::size_t arm) {
  const RobotModel& robot = world_.robot(arm);
  const Roadmap& map = maps_[arm];
  const Eigen::VectorXd &start = map.points.front(), &goal = map.points[map.goal];
  const auto dof = static_cast<Eigen::Index>(robot.dof());
  std::vector<Eigen::VectorXd> found;
  const auto add = [&](Eigen::VectorXd q) {
    if (!robot.limit_violation(q)) found.push_back(std::move(q));
  };
  for (const Point corner : stations(map))
    for (Eigen::Index j = 0; j < dof; ++j)
      for (const double turn : {-1.2, -0.8, -0.4, 0.4, 0.8, 1.2}) {
        Eigen::VectorXd q = map.points[corner];
        q[j] += turn;
        add(q);
        for (Eigen::Index k = j + 1; k < dof; ++k)
          for (const double other : {-0.8, 0.8}) {
            Eigen::VectorXd both = q;
            both[k] += other;
            add(both);
          }
      }
  const auto detour = [&](const Eigen::VectorXd& q) {
    return robot.difference(start, q).norm() + robot.difference(q, goal).norm();
  };
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < found.size(); ++i) order.emplace_back(detour(found[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<Eigen::VectorXd> sorted;
  for (const auto& [cost, i] : order) sorted.push_back(found[i]);
  return sorted;
}

/// With how many of the points of other arms' ways q goes, as a share.
double RoadmapSearch::out_of_the_way(std::size_t arm, const Eigen::VectorXd& q) {
  std::ptrdiff_t all = 0, apart = 0;
  for (std::size_t other = 0; other < world_.size(); ++other) {
    if (other == arm || !world_.may_conflict(arm, other)) continue;
    const std::vector<char> found = world_.collision_free_with(arm, q, other, ways_[other]);
    all += std::ssize(found);
    apart += std::count(found.begin(), found.end(), 1);
  }
  return all ? static_cast<double>(apart) / static_cast<double>(all) : 1.0;
}

void RoadmapSearch::make_asides(std::size_t arm) {
  if (std::exchange(has_asides_[arm], true)) return;
  Roadmap& map = maps_[arm];
  const std::vector<Eigen::VectorXd> near = asides(arm);
  const std::size_t tried = tries * asides_;
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t n = 0; n < tried; ++n) {
    const std::size_t i = n * near.size() / tried;
    if (world_.is_free_for_one(arm, near[i])) ranked.emplace_back(-out_of_the_way(arm, near[i]), i);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::size_t> kept;  // of `near`, and the points that they became
  std::vector<Point> points;
  for (const Point corner : stations(map)) {  // the best that each has a way to
    std::size_t found = 0;
    for (const auto& [share, i] : ranked) {
      if (found == asides_ || map.points.size() > max_points) break;
      const auto known = std::find(kept.begin(), kept.end(), i);
      if (!world_.is_free_for_one(arm, map.points[corner], near[i])) continue;
      ++found;
      if (known != kept.end()) {
        const Point there = points[static_cast<std::size_t>(known - kept.begin())];
        add_straight(map, arm, corner, near[i], there);
        continue;
      }
      add_straight(map, arm, corner, near[i]);
      const auto any = static_cast<Point>(map.points.size() - 1);
      for (const Point other : points)
        if (world_.is_free_for_one(arm, map.points[other], near[i])) add_straight(map, arm, other, near[i], any);
      kept.push_back(i);
      points.push_back(any);
      map.asides.push_back(any);
    }
  }
  // The way that is left (Dijkstra).
  map.to_goal.assign(map.points.size(), search::infinity);
  std::priority_queue<std::pair<double, Point>, std::vector<std::pair<double, Point>>, std::greater<>> open;
  const auto reach = [&](Point p, double cost) {
    if (cost >= map.to_goal[p]) return;
    map.to_goal[p] = cost;
    open.emplace(cost, p);
  };
  if (world_.task(arm).anywhere)
    for (Point p = 0; p < map.points.size(); ++p) map.to_goal[p] = 0.0;
  else
    reach(map.goal, 0.0);
  while (!open.empty()) {
    const auto [cost, p] = open.top();
    open.pop();
    if (cost > map.to_goal[p]) continue;
    for (const Roadmap::Way& way : map.next[p]) reach(way.to, cost + way.length);
  }
}

std::vector<Eigen::VectorXd> RoadmapSearch::places_aside(std::size_t arm) const {
  std::vector<Eigen::VectorXd> found;
  for (const Point any : maps_[arm].asides) found.push_back(maps_[arm].points[any]);
  return found;
}

// --- pairs

bool RoadmapSearch::together(Pair& pair, Point p, Point q) {
  if (pair.together.size() <= p) pair.together.resize(maps_[pair.a].points.size());
  std::vector<char>& row = pair.together[p];
  if (row.size() <= q || row[q] == not_known) look(pair, row, p, q);
  return row[q];
}

/// Of p, do q and those of b's points that are looked at with it go together?
void RoadmapSearch::look(Pair& pair, std::vector<char>& row, Point p, Point q) {
  const Roadmap &map_a = maps_[pair.a], &map_b = maps_[pair.b];
  const std::vector<Eigen::VectorXd>& others = map_b.points;
  row.resize(others.size(), not_known);
  const Eigen::VectorXd& here = map_a.points[p];
  std::size_t first = q / block * block;
  const std::size_t last = std::min(first + block, others.size());
  while (row[first] != not_known) ++first;  // there were fewer points when others were asked for
  std::ranges::copy(world_.collision_free_with(pair.a, here, pair.b, std::span(others).subspan(first, last - first)),
                    row.begin() + static_cast<std::ptrdiff_t>(first));
  // What spheres cannot tell matters where the arms must be.
  for (const std::size_t end : {std::size_t{0}, std::size_t{map_b.goal}})
    if (first <= end && end < last && !row[end] && (p == 0 || p == map_a.goal)) {
      ++pair.checks;
      row[end] = world_.are_collision_free(pair.a, here, here, pair.b, others[end], others[end]);
    }
}

bool RoadmapSearch::pass(Pair& pair, Point from_a, Point to_a, Point from_b, Point to_b) {
  static_assert(max_points < 1 << 16);
  std::uint64_t key = 0;
  for (const Point point : {from_a, to_a, from_b, to_b}) key = key << 16 | point;
  const auto [known, added] = pair.passes.try_emplace(key, false);
  if (added) {
    ++pair.checks;
    const std::vector<Eigen::VectorXd>&a = maps_[pair.a].points, &b = maps_[pair.b].points;
    known->second =
        world_.are_collision_free(pair.a, a[from_a], a[to_a], pair.b, b[from_b], b[to_b], {.start_is_free = true});
  }
  return known->second;
}

// --- the search

class RoadmapSearch::Query {
 public:
  Query(RoadmapSearch& maps, const std::vector<std::size_t>& arms, const Effort& effort)
      : maps_(maps), arms_(arms), effort_(effort) {
    for (const std::size_t a : arms)
      for (const std::size_t b : arms) {
        const auto found = maps.pairs_.find(std::minmax(a, b));
        pairs_.push_back(a == b || found == maps.pairs_.end() ? nullptr : &found->second);
      }
  }

  Result run(const Deadline& deadline) {
    Result result;
    const std::uint64_t before = checks();
    const State start(arms_.size(), u'\0');
    add(start, 0.0, no_node);
    while (!open_.empty()) {
      const std::uint32_t id = open_.top().second;
      open_.pop();
      if (const auto stop = search::stop_status(deadline)) return {*stop, {}, 0.0, result.expansions};
      const Node node = nodes_[id];
      if (const auto known = best_.find(node.state); known != best_.end() && known->second <= node.cost) continue;
      if (node.parent != no_node && !is_free(nodes_[node.parent].state, node.state)) continue;
      best_[node.state] = node.cost;
      if (node.left == 0.0) return {Status::solved, path_to(id), node.cost, result.expansions};
      if (result.expansions++ >= effort_.max_expansions || checks() - before > effort_.max_checks)
        return {Status::timed_out, {}, 0.0, result.expansions};
      expand(id);
    }
    return result;
  }

  /// OPEN never has more entries than there are nodes; strings of many arms' states lie outside of their objects.
  std::size_t memory() const {
    const std::size_t outside = arms_.size() > State().capacity() ? (arms_.size() + 1) * sizeof(char16_t) : 0;
    return memory_of(nodes_) + memory_of(best_) + nodes_.size() * sizeof(std::pair<double, std::uint32_t>) +
           (nodes_.size() + best_.size()) * outside;
  }

 private:
  using State = std::u16string;  // a point an arm
  static constexpr std::uint32_t no_node = std::numeric_limits<std::uint32_t>::max();
  struct Node {
    State state;
    double cost, left;
    std::uint32_t parent;
  };
  struct Hash {
    std::size_t operator()(const State& state) const {
      std::uint64_t hash = 0;
      for (const char16_t p : state) hash = (hash ^ p) * 0x9e3779b97f4a7c15u ^ hash >> 29;
      return hash;
    }
  };

  /// Of motions of two of the arms, ever.
  std::uint64_t checks() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < arms_.size(); ++i)
      for (std::size_t k = i + 1; k < arms_.size(); ++k)
        if (const Pair* both = pair(i, k)) sum += both->checks;
    return sum;
  }
  /// Null: the two never meet.
  Pair* pair(std::size_t i, std::size_t k) const { return pairs_[i * arms_.size() + k]; }
  const Roadmap& map(std::size_t i) const { return maps_.maps_[arms_[i]]; }

  void add(const State& state, double cost, std::uint32_t parent) {
    if (const auto known = best_.find(state); known != best_.end() && known->second <= cost) return;
    double left = 0.0;
    for (std::size_t i = 0; i < arms_.size(); ++i) left += map(i).to_goal[state[i]];
    if (left == search::infinity || cost + left >= effort_.below) return;
    nodes_.push_back({state, cost, left, parent});
    open_.emplace(cost + effort_.greed * left, static_cast<std::uint32_t>(nodes_.size() - 1));
  }

  bool fits(const State& state, std::size_t i) {
    for (std::size_t k = 0; k < arms_.size(); ++k)
      if (Pair* both = pair(i, k);
          both && !(i < k ? maps_.together(*both, state[i], state[k]) : maps_.together(*both, state[k], state[i])))
        return false;
    return true;
  }

  bool is_free(const State& from, const State& to) {
    for (std::size_t i = 0; i < arms_.size(); ++i)
      for (std::size_t k = i + 1; k < arms_.size(); ++k)
        if (Pair* both = pair(i, k);
            both && (from[i] != to[i] || from[k] != to[k]) && !maps_.pass(*both, from[i], to[i], from[k], to[k]))
          return false;
    return true;
  }

  /// Each arm by itself; and as many as can go on towards their goals, in order and in reverse order.
  void expand(std::uint32_t id) {
    const State from = nodes_[id].state;
    const double cost = nodes_[id].cost + pause;
    for (const bool backward : {false, true}) {
      State all = from;
      double way = 0.0;
      int moved = 0;
      for (std::size_t n = 0; n < arms_.size(); ++n) {
        const std::size_t i = backward ? arms_.size() - 1 - n : n;
        const Roadmap::Way* next = onwards(i, from[i]);
        if (!next) continue;
        all[i] = static_cast<char16_t>(next->to);
        if (fits(all, i)) {
          way += next->length;
          ++moved;
        } else {
          all[i] = from[i];
        }
      }
      if (moved > 1) add(all, cost + way, id);
    }
    for (std::size_t i = 0; i < arms_.size(); ++i)
      for (const Roadmap::Way& next : map(i).next[from[i]]) {
        State one = from;
        one[i] = static_cast<char16_t>(next.to);
        if (fits(one, i)) add(one, cost + next.length, id);
      }
  }

  /// Null: the arm is at its goal.
  const Roadmap::Way* onwards(std::size_t i, Point from) const {
    const Roadmap& map = this->map(i);
    const Roadmap::Way* best = nullptr;
    double least = map.to_goal[from];
    for (const Roadmap::Way& next : map.next[from])
      if (map.to_goal[next.to] < least) {
        least = map.to_goal[next.to];
        best = &next;
      }
    return best;
  }

  JointPath path_to(std::uint32_t id) const {
    std::vector<State> states;
    for (; id != no_node; id = nodes_[id].parent) states.push_back(nodes_[id].state);
    std::reverse(states.begin(), states.end());
    std::vector<std::vector<Eigen::VectorXd>> ways(arms_.size());
    for (std::size_t i = 0; i < arms_.size(); ++i)
      for (const State& state : states) ways[i].push_back(map(i).points[state[i]]);
    return joint_path(maps_.world_, arms_, ways);
  }

  RoadmapSearch& maps_;
  const std::vector<std::size_t>& arms_;
  const Effort& effort_;
  std::vector<Pair*> pairs_;  // of arms_, row by row
  std::vector<Node> nodes_;
  std::unordered_map<State, double, Hash> best_;
  std::priority_queue<std::pair<double, std::uint32_t>, std::vector<std::pair<double, std::uint32_t>>, std::greater<>>
      open_;
};

RoadmapSearch::Result RoadmapSearch::run(const std::vector<std::size_t>& arms, const Effort& effort,
                                         const Deadline& deadline) {
  for (const std::size_t arm : arms) {
    if (deadline.stop_requested()) return {Status::timed_out, {}, 0.0, 0};
    make_asides(arm);
  }
  Query query(*this, arms, effort);
  Result result = query.run(deadline);
  result.memory = query.memory();
  return result;
}

std::size_t RoadmapSearch::memory() const {
  std::size_t sum = memory_of(ways_);
  for (const auto& way : ways_) {
    sum += memory_of(way);
    for (const Eigen::VectorXd& point : way) sum += static_cast<std::size_t>(point.size()) * sizeof(double);
  }
  for (const auto& [numbers, pair] : pairs_) {
    sum += memory_of(pair.passes) + memory_of(pair.together);
    for (const std::vector<char>& row : pair.together) sum += memory_of(row);
  }
  for (const Roadmap& map : maps_) {
    sum += memory_of(map.points) + memory_of(map.next) + memory_of(map.to_goal);
    for (const Eigen::VectorXd& point : map.points) sum += static_cast<std::size_t>(point.size()) * sizeof(double);
    for (const std::vector<Roadmap::Way>& ways : map.next) sum += memory_of(ways);
  }
  return sum;
}

}  // namespace srmp
