#include "srmp/planning/strategies/composite_roadmap.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "srmp/core/error.hpp"
#include "srmp/core/memory_of.hpp"
#include "srmp/core/number_hash.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/search/best_first.hpp"
#include "srmp/search/dijkstra.hpp"

namespace srmp {

namespace {

constexpr std::size_t max_vertex_numbers = 1 << 16;  // that fit into the keys of Pair::edges_collision_free

}  // namespace

CompositeRoadmap::CompositeRoadmap(MultiRobotWorld& world, CompositeRoadmapOptions options)
    : world_(world), options_(std::move(options)), has_retreats_(world.size(), false) {
  require_options();
  for (std::size_t a = 0; a < world.size(); ++a) {
    maps_.push_back(single_robot_roadmap(a));
    paths_.push_back(maps_.back().vertices);
    for (std::size_t b = a + 1; b < world.size(); ++b)
      if (world.may_conflict(a, b)) pairs_.try_emplace({a, b}, a, b);
  }
}

void CompositeRoadmap::require_options() const {
  const auto require = [](bool holds, const std::string& name, const std::string& value, const std::string& law) {
    if (!holds) throw InvalidArgument(name + " is " + value + "; it must be " + law);
  };
  const auto at_least_1 = [&](std::size_t value, const std::string& name) {
    require(value > 0, name, std::to_string(value), "at least 1");
  };
  at_least_1(options_.retreats, "retreats");
  at_least_1(options_.retreat_candidates, "retreat_candidates");
  at_least_1(options_.branch_points, "branch_points");
  at_least_1(options_.block, "block");
  require_positive(options_.spacing, "spacing");
  require(options_.max_vertices < max_vertex_numbers, "max_vertices", std::to_string(options_.max_vertices),
          "less than 65536");
  require(options_.step_cost >= 0.0 && std::isfinite(options_.step_cost), "step_cost", to_text(options_.step_cost),
          "0 or above");
  require_finite(options_.offsets.joint, "offsets.joint");
  require_finite(options_.offsets.second_joint, "offsets.second_joint");
}

// --- roadmaps

/// Adds vertices along the straight motion from one of the map's vertices to q, which is known to be free. The last
/// one is q, unless it is a vertex already (`known`).
void CompositeRoadmap::add_edge(Roadmap& map, std::size_t robot, Vertex from, const Eigen::VectorXd& q,
                                std::optional<Vertex> known) const {
  const Eigen::VectorXd start = map.vertices[from], motion = world_.model(robot).difference(start, q);
  const int parts = std::max(1, static_cast<int>(std::ceil(motion.norm() / options_.spacing)));
  const double length = motion.norm() / parts;
  Vertex last = from;
  for (int k = 1; k <= parts; ++k) {
    Vertex next = known.value_or(0);
    if (k < parts || !known) {
      next = static_cast<Vertex>(map.vertices.size());
      map.vertices.push_back(k < parts ? Eigen::VectorXd(start + static_cast<double>(k) / parts * motion) : q);
      map.edges.emplace_back();
    }
    map.edges[last].push_back({next, length});
    map.edges[next].push_back({last, length});
    last = next;
  }
}

Roadmap CompositeRoadmap::single_robot_roadmap(std::size_t robot) const {
  const WorldTask& task = world_.task(robot);
  Roadmap map;
  map.vertices = {task.start};
  map.edges.resize(1);
  for (std::size_t k = 1; k < task.single_robot_path.size() && !task.anywhere; ++k) {
    const Eigen::VectorXd waypoint = task.single_robot_path[k];
    add_edge(map, robot, map.goal, waypoint);
    map.goal = static_cast<Vertex>(map.vertices.size() - 1);
  }
  return map;
}

/// Vertices of the robot's path from which edges to retreats lead, its ends among them.
std::vector<CompositeRoadmap::Vertex> CompositeRoadmap::branch_points(const Roadmap& map) const {
  std::vector<Vertex> vertices;
  const Vertex count = std::min(options_.branch_points, map.goal + 1);
  for (Vertex k = 0; k < count; ++k) vertices.push_back(count > 1 ? k * map.goal / (count - 1) : 0);
  return vertices;
}

std::vector<Eigen::VectorXd> CompositeRoadmap::candidates_of(std::size_t robot) const {
  const Roadmap& map = maps_[robot];
  std::vector<Eigen::VectorXd> around;
  for (const Vertex branch_point : branch_points(map)) around.push_back(map.vertices[branch_point]);
  return retreat_candidates(world_.model(robot), map.vertices.front(), map.vertices[map.goal], around,
                            options_.offsets);
}

/// Numbers of those candidates that are free, the ones that leave most room to the other robots first. Only some are
/// checked, evenly spread.
std::vector<std::size_t> CompositeRoadmap::ranked(std::size_t robot, const std::vector<Eigen::VectorXd>& candidates,
                                                  const Deadline& deadline) {
  const std::size_t checked = std::min(options_.retreat_candidates * options_.retreats, candidates.size());
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t n = 0; n < checked && !deadline.stop_requested(); ++n) {
    const std::size_t i = n * candidates.size() / checked;
    if (world_.is_free_for_one(robot, candidates[i]))
      order.emplace_back(-collision_free_fraction(world_, robot, candidates[i], paths_), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> numbers;
  for (const auto& [fraction, i] : order) numbers.push_back(i);
  return numbers;
}

/// Connects each branch point with the best candidates to which a straight motion is free, and these with each other.
void CompositeRoadmap::add_retreats(std::size_t robot, const Deadline& deadline) {
  if (std::exchange(has_retreats_[robot], true)) return;
  Roadmap& map = maps_[robot];
  const std::vector<Eigen::VectorXd> candidates = candidates_of(robot);
  const std::vector<std::size_t> best_first = ranked(robot, candidates, deadline);
  std::vector<std::size_t> kept;  // of the candidates: those that became map.retreats
  for (const Vertex branch_point : branch_points(map)) {
    std::size_t found = 0;
    for (const std::size_t i : best_first) {
      if (found == options_.retreats || map.vertices.size() > options_.max_vertices || deadline.stop_requested()) break;
      const auto known = std::find(kept.begin(), kept.end(), i);
      if (!world_.is_free_for_one(robot, map.vertices[branch_point], candidates[i])) continue;
      ++found;
      if (known != kept.end()) {
        add_edge(map, robot, branch_point, candidates[i], map.retreats[static_cast<std::size_t>(known - kept.begin())]);
        continue;
      }
      add_edge(map, robot, branch_point, candidates[i]);
      const auto retreat = static_cast<Vertex>(map.vertices.size() - 1);
      for (const Vertex other : map.retreats)
        if (world_.is_free_for_one(robot, map.vertices[other], candidates[i]))
          add_edge(map, robot, other, candidates[i], retreat);
      kept.push_back(i);
      map.retreats.push_back(retreat);
    }
  }
  compute_cost_to_go(robot);
}

void CompositeRoadmap::compute_cost_to_go(std::size_t robot) {
  Roadmap& map = maps_[robot];
  map.to_goal.assign(map.vertices.size(), std::nullopt);
  if (world_.task(robot).anywhere) {
    map.cost_to_go.assign(map.vertices.size(), 0.0);
    return;
  }
  const Vertex goals[]{map.goal};
  map.cost_to_go = search::costs_to_go<double>(map.vertices.size(), goals, [&](Vertex to, auto&& relax) {
    for (const Roadmap::Edge& edge : map.edges[to]) relax(edge.to, edge.length);  // edges go both ways
  });
  for (std::size_t from = 0; from < map.vertices.size(); ++from)
    for (double least = map.cost_to_go[from]; const Roadmap::Edge& edge : map.edges[from])
      if (map.cost_to_go[edge.to] < least) {
        least = map.cost_to_go[edge.to];
        map.to_goal[from] = edge;
      }
}

std::vector<Eigen::VectorXd> CompositeRoadmap::retreats(std::size_t robot) const {
  std::vector<Eigen::VectorXd> configurations;
  for (const Vertex retreat : maps_[robot].retreats) configurations.push_back(maps_[robot].vertices[retreat]);
  return configurations;
}

// --- pairs

bool CompositeRoadmap::check_collision_free(Pair& pair, Vertex p, Vertex q) {
  if (pair.collision_free.size() <= p) pair.collision_free.resize(maps_[pair.a].vertices.size());
  std::vector<char>& row = pair.collision_free[p];
  check_block(pair, row, p, q);
  const bool free = row[q];
  if (world_.is_stopped()) row.clear();
  return free;
}

/// Checks vertex p of a against q and the other vertices of b in q's block.
void CompositeRoadmap::check_block(Pair& pair, std::vector<char>& row, Vertex p, Vertex q) {
  const Roadmap &map_a = maps_[pair.a], &map_b = maps_[pair.b];
  const std::vector<Eigen::VectorXd>& others = map_b.vertices;
  row.resize(others.size(), not_checked);
  const Eigen::VectorXd& q_a = map_a.vertices[p];
  std::size_t first = q / options_.block * options_.block;
  const std::size_t last = std::min(first + options_.block, others.size());
  while (row[first] != not_checked) ++first;  // the block had fewer vertices when it was checked
  std::ranges::copy(world_.collision_free_with(pair.a, q_a, pair.b, std::span(others).subspan(first, last - first)),
                    row.begin() + static_cast<std::ptrdiff_t>(first));
  // Spheres may leave it open; at starts and goals, where the robots must be, the exact geometry decides.
  for (const std::size_t end : {std::size_t{0}, std::size_t{map_b.goal}})
    if (first <= end && end < last && !row[end] && (p == 0 || p == map_a.goal)) {
      ++pair.checks;
      row[end] = world_.are_collision_free(pair.a, q_a, q_a, pair.b, others[end], others[end]);
    }
}

bool CompositeRoadmap::edges_collision_free(Pair& pair, Vertex from_a, Vertex to_a, Vertex from_b, Vertex to_b) {
  std::uint64_t key = 0;
  for (const Vertex vertex : {from_a, to_a, from_b, to_b}) key = key << 16 | vertex;
  if (const auto known = pair.edges_collision_free.find(key); known != pair.edges_collision_free.end())
    return known->second;
  ++pair.checks;
  const std::vector<Eigen::VectorXd>&a = maps_[pair.a].vertices, &b = maps_[pair.b].vertices;
  const bool free =
      world_.are_collision_free(pair.a, a[from_a], a[to_a], pair.b, b[from_b], b[to_b], {.start_is_free = true});
  if (!world_.is_stopped()) pair.edges_collision_free.emplace(key, free);
  return free;
}

// --- the search

/// One search of the product of some robots' roadmaps; a search::BestFirstProblem.
class CompositeRoadmap::Query {
 public:
  using State = std::u16string;  // a vertex of each robot
  struct Node {
    State state;
    double cost, cost_to_go;
  };

  Query(CompositeRoadmap& maps, const std::vector<std::size_t>& robots, const SearchBudget& budget)
      : maps_(maps), robots_(robots), budget_(budget) {
    for (const std::size_t a : robots)
      for (const std::size_t b : robots) {
        const auto found = maps.pairs_.find(std::minmax(a, b));
        pairs_.push_back(a == b || found == maps.pairs_.end() ? nullptr : &found->second);
      }
  }

  Result run(const Deadline& deadline) {
    checks_before_ = checks();
    add(State(robots_.size(), u'\0'), 0.0, search::no_node);
    const search::BestFirstResult found = search_.run(*this, deadline);
    Result result{found.status, {}, 0.0, found.expansions, memory()};
    if (found.status != Status::solved) return result;
    result.path = path_to(found.goal);
    result.cost = search_[found.goal].cost;
    return result;
  }

  bool is_dominated(const Node& node) const { return closed_.dominates(node.state, node.cost); }
  bool is_valid(search::NodeId id) {
    const search::NodeId parent = search_.parent(id);
    return parent == search::no_node || is_edge_free(search_[parent].state, search_[id].state);
  }
  void close(const Node& node) { closed_.close(node.state, node.cost); }
  bool is_goal(const Node& node) const { return node.cost_to_go == 0.0; }
  bool may_expand(std::uint64_t expansions) const {
    return expansions <= budget_.max_expansions && checks() - checks_before_ <= budget_.max_checks;
  }

  /// As many robots as can move on towards their goals, in order and in reverse order; and each robot alone along each
  /// of its edges.
  void expand(search::NodeId id) {
    const State from = search_[id].state;
    const double cost = search_[id].cost + maps_.options_.step_cost;
    for (const bool backward : {false, true}) {
      State all = from;
      double length = 0.0;
      int moved = 0;
      for (std::size_t n = 0; n < robots_.size(); ++n) {
        const std::size_t i = backward ? robots_.size() - 1 - n : n;
        const std::optional<Roadmap::Edge>& edge = map(i).to_goal[from[i]];
        if (!edge || !is_collision_free(all, i, edge->to)) continue;
        all[i] = static_cast<char16_t>(edge->to);
        length += edge->length;
        ++moved;
      }
      if (moved > 1) add(all, cost + length, id);
    }
    for (std::size_t i = 0; i < robots_.size(); ++i)
      for (const Roadmap::Edge& edge : map(i).edges[from[i]]) {
        if (!is_collision_free(from, i, edge.to)) continue;
        State one = from;
        one[i] = static_cast<char16_t>(edge.to);
        add(one, cost + edge.length, id);
      }
  }

 private:
  /// Of simultaneous motions of two of the robots, in all searches so far.
  std::uint64_t checks() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < robots_.size(); ++i)
      for (std::size_t k = i + 1; k < robots_.size(); ++k)
        if (const Pair* both = pair(i, k)) sum += both->checks;
    return sum;
  }
  /// Null: the two never conflict.
  Pair* pair(std::size_t i, std::size_t k) const { return pairs_[i * robots_.size() + k]; }
  const Roadmap& map(std::size_t i) const { return maps_.maps_[robots_[i]]; }

  void add(const State& state, double cost, search::NodeId parent) {
    if (closed_.dominates(state, cost)) return;
    double cost_to_go = 0.0;
    for (std::size_t i = 0; i < robots_.size(); ++i) cost_to_go += map(i).cost_to_go[state[i]];
    if (cost_to_go == search::infinity || cost + cost_to_go >= budget_.max_cost) return;
    search_.add({state, cost, cost_to_go}, cost + budget_.weight * cost_to_go, parent);
  }

  /// Robot i at a vertex, and each of the others where the state has them.
  bool is_collision_free(const State& state, std::size_t i, Vertex at) {
    for (std::size_t k = 0; k < robots_.size(); ++k)
      if (Pair* both = pair(i, k);
          both && !(i < k ? maps_.collision_free(*both, at, state[k]) : maps_.collision_free(*both, state[k], at)))
        return false;
    return true;
  }

  bool is_edge_free(const State& from, const State& to) {
    for (std::size_t i = 0; i < robots_.size(); ++i)
      for (std::size_t k = i + 1; k < robots_.size(); ++k)
        if (Pair* both = pair(i, k); both && (from[i] != to[i] || from[k] != to[k]) &&
                                     !maps_.edges_collision_free(*both, from[i], to[i], from[k], to[k]))
          return false;
    return true;
  }

  JointPath path_to(search::NodeId goal) const {
    std::vector<std::vector<Eigen::VectorXd>> paths(robots_.size());
    for (const search::NodeId id : search_.path_to(goal))
      for (std::size_t i = 0; i < robots_.size(); ++i) paths[i].push_back(map(i).vertices[search_[id].state[i]]);
    return joint_path(maps_.world_, robots_, paths);
  }

  std::size_t memory() const {
    // Strings hold the states of many robots outside of themselves.
    const std::size_t outside = robots_.size() > State().capacity() ? (robots_.size() + 1) * sizeof(char16_t) : 0;
    return search_.memory() + memory_of(closed_.costs()) + (search_.size() + closed_.costs().size()) * outside;
  }

  CompositeRoadmap& maps_;
  const std::vector<std::size_t>& robots_;
  const SearchBudget& budget_;
  std::vector<Pair*> pairs_;  // of robots_, row by row
  std::uint64_t checks_before_{};
  search::BestFirstSearch<Node, double> search_;
  search::ClosedCosts<std::unordered_map<State, double, NumberHash>> closed_;
};

CompositeRoadmap::Result CompositeRoadmap::run(const std::vector<std::size_t>& robots, const SearchBudget& budget,
                                               const Deadline& deadline) {
  Result tried;
  const auto has_none = [&](std::size_t robot) { return !has_retreats_[robot]; };
  if (budget.path_expansions > 0 && std::ranges::any_of(robots, has_none)) {
    for (const std::size_t robot : robots)
      if (has_none(robot)) compute_cost_to_go(robot);
    SearchBudget few = budget;
    few.max_expansions = std::min(budget.path_expansions, budget.max_expansions);
    tried = Query(*this, robots, few).run(deadline);
    if (tried.status == Status::solved) return tried;
  }
  for (const std::size_t robot : robots) {
    if (const auto stop = stop_status(deadline)) return {*stop, {}, 0.0, tried.expansions, tried.memory};
    add_retreats(robot, deadline);
  }
  Result found = Query(*this, robots, budget).run(deadline);
  found.expansions += tried.expansions;
  found.memory = std::max(found.memory, tried.memory);
  return found;
}

std::size_t CompositeRoadmap::memory() const {
  const auto memory_of_all = [](const std::vector<Eigen::VectorXd>& configurations) {
    std::size_t sum = memory_of(configurations);
    for (const Eigen::VectorXd& q : configurations) sum += static_cast<std::size_t>(q.size()) * sizeof(double);
    return sum;
  };
  std::size_t sum = memory_of(paths_);
  for (const auto& path : paths_) sum += memory_of_all(path);
  for (const auto& [numbers, pair] : pairs_) {
    sum += memory_of(pair.edges_collision_free) + memory_of(pair.collision_free);
    for (const std::vector<char>& row : pair.collision_free) sum += memory_of(row);
  }
  for (const Roadmap& map : maps_) {
    sum += memory_of_all(map.vertices) + memory_of(map.edges) + memory_of(map.cost_to_go) + memory_of(map.to_goal);
    for (const std::vector<Roadmap::Edge>& edges : map.edges) sum += memory_of(edges);
  }
  return sum;
}

}  // namespace srmp
