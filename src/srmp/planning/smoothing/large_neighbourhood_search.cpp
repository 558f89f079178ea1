#include "srmp/planning/smoothing/large_neighbourhood_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "srmp/search/best_first.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

namespace {

constexpr double same_direction = 1e-6;  // of unit vectors: rows between motions of one direction are no waypoints

/// Space-time search of one robot's path among the others of a joint path; a search::BestFirstProblem.
class NeighbourhoodSearch {
 public:
  struct Node {
    std::size_t vertex;
    int step;
    double cost;
  };

  NeighbourhoodSearch(const JointPath& path, std::size_t robot, MultiRobotWorld& world,
                      std::span<const Eigen::VectorXd> configurations, const LargeNeighbourhoodOptions& options)
      : path_(path), robot_(robot), world_(world), options_(options), task_(world.task(number(robot))) {
    add_vertices(configurations);
    int single_robot_steps = 0;
    for (std::size_t k = 1; k < task_.single_robot_path.size(); ++k)
      single_robot_steps += world.duration(number(robot), task_.single_robot_path[k - 1], task_.single_robot_path[k]);
    end_ = static_cast<int>(std::ceil(path.steps.back())) + single_robot_steps;
    max_cost_ = options.max_length_ratio * path.length(robot);
  }

  /// None: no path is short enough.
  std::optional<JointPath> run(const Deadline& deadline) {
    if (end_ > options_.max_steps || cost_to_go_[0] >= max_cost_) return std::nullopt;
    add(0, 0, 0.0, search::no_node);
    const search::BestFirstResult found = search_.run(*this, deadline);
    if (found.status != Status::solved) return std::nullopt;
    return joint_path_to(found.goal);
  }

  bool is_dominated(const Node& node) const { return closed_.dominates({node.vertex, node.step}, node.cost); }
  bool is_valid(search::NodeId id) {
    const search::NodeId parent = search_.parent(id);
    return parent == search::no_node || is_free(search_[parent], search_[id]);
  }
  void close(const Node& node) { closed_.close({node.vertex, node.step}, node.cost); }
  /// At a goal, where the robot can stay for good.
  bool is_goal(const Node& node) {
    if (cost_to_go_[node.vertex] != 0.0) return false;
    return node.step == end_ || is_free(node, {node.vertex, end_, 0.0});
  }
  bool may_continue() const { return search_.size() < options_.max_nodes; }

  void expand(search::NodeId id) {
    const Node node = search_[id];
    const int waits = std::min(options_.wait_steps, end_ - node.step);
    if (waits > 0) add(node.vertex, node.step + waits, node.cost + waits * options_.wait_cost, id);
    for (std::size_t to = 0; to < vertices_.size(); ++to) {
      if (to == node.vertex) continue;
      const double cost = node.cost + distance(node.vertex, to);
      const int step = node.step + duration(node.vertex, to);
      if (cost + cost_to_go_[to] < max_cost_ && step <= end_) add(to, step, cost, id);
    }
  }

 private:
  std::size_t number(std::size_t robot) const { return path_.robots[robot]; }
  const RobotModel& model() const { return world_.model(number(robot_)); }

  // --- vertices

  /// 0 is the start of the robot's path, 1 (if it is another configuration) its end.
  void add_vertices(std::span<const Eigen::VectorXd> configurations) {
    const RowMatrix& rows = path_.positions[robot_];
    add_vertex(rows.row(0).transpose());
    add_vertex(rows.bottomRows(1).transpose());
    for (Eigen::Index row = 1; row + 1 < rows.rows(); ++row)
      if (is_waypoint(row)) add_vertex(rows.row(row).transpose());
    for (const Eigen::VectorXd& q : task_.single_robot_path) add_vertex(q);
    for (const Eigen::VectorXd& q : configurations)
      if (length_through(q) < options_.max_length_ratio * path_.length(robot_)) add_vertex(q);
    distances_.assign(vertices_.size() * vertices_.size(), -1.0);
    durations_.assign(distances_.size(), -1);
    cost_to_go_.assign(vertices_.size(), search::infinity);
    for (std::size_t goal = 0; goal < vertices_.size(); ++goal)
      if (is_goal_configuration(vertices_[goal]))
        for (std::size_t k = 0; k < vertices_.size(); ++k) cost_to_go_[k] = std::min(cost_to_go_[k], distance(k, goal));
  }
  void add_vertex(const Eigen::VectorXd& q) {
    if (std::find(vertices_.begin(), vertices_.end(), q) == vertices_.end()) vertices_.push_back(q);
  }
  bool is_goal_configuration(const Eigen::VectorXd& q) const {
    return task_.anywhere || q == path_.positions[robot_].bottomRows(1).transpose() ||
           std::find(task_.targets.begin(), task_.targets.end(), q) != task_.targets.end();
  }
  /// Does the robot change its direction there?
  bool is_waypoint(Eigen::Index row) const {
    const RowMatrix& q = path_.positions[robot_];
    const Eigen::VectorXd in = q.row(row) - q.row(row - 1), out = q.row(row + 1) - q.row(row);
    return (in.stableNormalized() - out.stableNormalized()).norm() > same_direction;
  }
  double length_through(const Eigen::VectorXd& q) const {
    const Eigen::VectorXd& end = vertices_[std::min<std::size_t>(1, vertices_.size() - 1)];
    return model().difference(vertices_[0], q).norm() + model().difference(q, end).norm();
  }
  double distance(std::size_t a, std::size_t b) {
    double& known = distances_[a * vertices_.size() + b];
    if (known < 0.0) known = model().difference(vertices_[a], vertices_[b]).norm();
    return known;
  }
  int duration(std::size_t a, std::size_t b) {
    int& known = durations_[a * vertices_.size() + b];
    if (known < 0) known = world_.duration(number(robot_), vertices_[a], vertices_[b]);
    return known;
  }

  // --- edges

  void add(std::size_t vertex, int step, double cost, search::NodeId parent) {
    if (!closed_.dominates({vertex, step}, cost)) search_.add({vertex, step, cost}, cost + cost_to_go_[vertex], parent);
  }

  bool is_free(const Node& from, const Node& to) {
    if (from.vertex != to.vertex) {
      const auto [known, added] = free_alone_.try_emplace({from.vertex, to.vertex}, false);
      if (added) known->second = world_.is_free_for_one(number(robot_), vertices_[from.vertex], vertices_[to.vertex]);
      if (!known->second) return false;
    }
    for (std::size_t other = 0; other < path_.robots.size(); ++other)
      if (other != robot_ && world_.may_conflict(number(robot_), number(other)) && !are_collision_free(from, to, other))
        return false;
    return true;
  }
  /// The other robot moves straight from row to row. Where a robot must be, at the ends of its path, the exact geometry
  /// is checked; spheres, which are quicker, elsewhere.
  bool are_collision_free(const Node& from, const Node& to, std::size_t other) {
    auto row = std::upper_bound(path_.steps.begin(), path_.steps.end(), from.step);
    for (double step = from.step, next = step; step < to.step; step = next) {
      next = row == path_.steps.end() ? to.step : std::min<double>(to.step, *row++);
      const Eigen::VectorXd a = interpolated(from, to, step), b = interpolated(from, to, next);
      const Eigen::VectorXd c = position_at(path_, other, step), d = position_at(path_, other, next);
      const bool by_spheres = !is_end(robot_, a) && !is_end(robot_, b) && !is_end(other, c) && !is_end(other, d);
      if (!world_.are_collision_free(number(robot_), a, b, number(other), c, d, {true, by_spheres})) return false;
    }
    return true;
  }
  bool is_end(std::size_t robot, const Eigen::VectorXd& q) const {
    const RowMatrix& rows = path_.positions[robot];
    return q == rows.row(0).transpose() || q == rows.bottomRows(1).transpose();
  }
  Eigen::VectorXd interpolated(const Node& from, const Node& to, double step) const {
    if (step >= to.step) return vertices_[to.vertex];
    const double fraction = (step - from.step) / (to.step - from.step);
    return vertices_[from.vertex] + fraction * model().difference(vertices_[from.vertex], vertices_[to.vertex]);
  }

  JointPath joint_path_to(search::NodeId goal) const {
    JointPath own{{number(robot_)}, {}, {}}, others{{}, path_.steps, {}};
    const std::vector<search::NodeId> nodes = search_.path_to(goal);
    RowMatrix q(std::ssize(nodes), vertices_[0].size());
    for (Eigen::Index row = 0; row < q.rows(); ++row) {
      const Node& node = search_[nodes[static_cast<std::size_t>(row)]];
      own.steps.push_back(node.step);
      q.row(row) = vertices_[node.vertex].transpose();
    }
    own.positions.push_back(world_.unwrapped(number(robot_), q));
    for (std::size_t other = 0; other < path_.robots.size(); ++other)
      if (other != robot_) {
        others.robots.push_back(path_.robots[other]);
        others.positions.push_back(path_.positions[other]);
      }
    return side_by_side({&own, &others});
  }

  const JointPath& path_;
  std::size_t robot_;  // index in path_.robots
  MultiRobotWorld& world_;
  const LargeNeighbourhoodOptions& options_;
  const WorldTask& task_;
  std::vector<Eigen::VectorXd> vertices_;
  std::vector<double> distances_;   // [from * vertices + to]; below 0: not known yet
  std::vector<int> durations_;      // the same, in steps
  std::vector<double> cost_to_go_;  // by vertex: straight to the nearest goal
  int end_{};                       // the last step of the search
  double max_cost_{};
  search::BestFirstSearch<Node, double> search_;
  search::ClosedCosts<std::map<std::pair<std::size_t, int>, double>> closed_;  // by vertex and step
  std::map<std::pair<std::size_t, std::size_t>, bool> free_alone_;             // edges among static obstacles
};

}  // namespace

JointPath reroute_one_robot(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                            const std::vector<std::vector<Eigen::VectorXd>>& configurations,
                            const LargeNeighbourhoodOptions& options) {
  if (path.size() < 3 || path.robots.size() < 2) return path;
  for (std::size_t robot = 0; robot < path.robots.size() && !deadline.stop_requested(); ++robot) {
    const std::vector<Eigen::VectorXd> of_robot =
        configurations.empty() ? std::vector<Eigen::VectorXd>{} : configurations[path.robots[robot]];
    if (auto shorter = NeighbourhoodSearch(path, robot, world, of_robot, options).run(deadline))
      path = std::move(*shorter);
  }
  return path;
}

}  // namespace srmp
