#include "srmp/planning/smoothing/large_neighbourhood_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <span>

#include "srmp/search/graph.hpp"

namespace srmp {

namespace {

constexpr double worth = 0.95;    // a way that is not shorter by this factor is left alone
constexpr double waiting = 0.01;  // cost of a step of rest [rad], so that arms do not wait without need
constexpr int rest = 3;           // steps of time that an arm rests before it thinks again
constexpr int max_steps = 250;    // of time
constexpr std::size_t max_nodes = 4000;

/// One arm of a path, its places, and the others as they go.
class NeighbourhoodSearch {
 public:
  NeighbourhoodSearch(const JointPath& path, std::size_t arm, MultiRobotWorld& world,
                      std::span<const Eigen::VectorXd> places, const Deadline& deadline)
      : path_(path), arm_(arm), world_(world), deadline_(deadline), task_(world.task(number(arm))) {
    add_places(places);
    int alone = 0;
    for (std::size_t k = 1; k < task_.backbone.size(); ++k)
      alone += world.duration(number(arm), task_.backbone[k - 1], task_.backbone[k]);
    end_ = static_cast<int>(std::ceil(path.steps.back())) + alone;
  }

  /// None: there is no way that is shorter.
  std::optional<JointPath> run() {
    const double limit = worth * path_.length(arm_);
    if (end_ > max_steps || left_[0] >= limit) return std::nullopt;
    push(0, 0, 0.0, no_node);
    while (!open_.empty() && !deadline_.stop_requested() && nodes_.size() < max_nodes) {
      const std::size_t id = open_.top().second;
      open_.pop();
      const Node node = nodes_[id];
      const auto known = best_.find({node.place, node.step});
      if (known != best_.end() && known->second <= node.cost) continue;
      if (node.parent != no_node && !is_free(nodes_[node.parent], node)) continue;
      best_[{node.place, node.step}] = node.cost;
      if (left_[node.place] == 0.0 && can_stay(node)) return answer(id);
      const int waits = std::min(rest, end_ - node.step);
      if (waits > 0) push(node.place, node.step + waits, node.cost + waits * waiting, id);
      for (std::size_t to = 0; to < places_.size(); ++to) {
        if (to == node.place) continue;
        const double cost = node.cost + distance(node.place, to);
        const int step = node.step + duration(node.place, to);
        if (cost + left_[to] < limit && step <= end_) push(to, step, cost, id);
      }
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t no_node = static_cast<std::size_t>(-1);
  struct Node {
    std::size_t place;
    int step;
    double cost;
    std::size_t parent;
  };

  std::size_t number(std::size_t arm) const { return path_.arms[arm]; }
  const RobotModel& robot() const { return world_.robot(number(arm_)); }

  void add_places(std::span<const Eigen::VectorXd> more) {
    const RowMatrix& rows = path_.positions[arm_];
    add(rows.row(0).transpose());
    add(rows.bottomRows(1).transpose());
    for (Eigen::Index row = 1; row + 1 < rows.rows(); ++row)
      if (turns(row)) add(rows.row(row).transpose());
    for (const Eigen::VectorXd& q : task_.backbone) add(q);
    for (const Eigen::VectorXd& q : more)
      if (way_through(q) < worth * path_.length(arm_)) add(q);
    left_.assign(places_.size(), search::infinity);
    for (std::size_t goal = 0; goal < places_.size(); ++goal)
      if (is_goal(places_[goal]))
        for (std::size_t k = 0; k < places_.size(); ++k) left_[k] = std::min(left_[k], distance(k, goal));
  }
  bool is_goal(const Eigen::VectorXd& q) const {
    return task_.anywhere || q == path_.positions[arm_].bottomRows(1).transpose() ||
           std::find(task_.targets.begin(), task_.targets.end(), q) != task_.targets.end();
  }
  void add(const Eigen::VectorXd& q) {
    if (std::find(places_.begin(), places_.end(), q) == places_.end()) places_.push_back(q);
  }
  bool turns(Eigen::Index row) const {
    const RowMatrix& q = path_.positions[arm_];
    const Eigen::VectorXd in = q.row(row) - q.row(row - 1), out = q.row(row + 1) - q.row(row);
    return (in.stableNormalized() - out.stableNormalized()).norm() > 1e-6;
  }

  double way_through(const Eigen::VectorXd& q) const {
    return robot().difference(places_[0], q).norm() + robot().difference(q, places_[1]).norm();
  }
  double distance(std::size_t a, std::size_t b) const { return robot().difference(places_[a], places_[b]).norm(); }
  int duration(std::size_t a, std::size_t b) const { return world_.duration(number(arm_), places_[a], places_[b]); }

  void push(std::size_t place, int step, double cost, std::size_t parent) {
    const auto known = best_.find({place, step});
    if (known != best_.end() && known->second <= cost) return;
    nodes_.push_back({place, step, cost, parent});
    open_.emplace(cost + left_[place], nodes_.size() - 1);
  }

  bool is_free(const Node& from, const Node& to) {
    if (from.place != to.place) {
      const auto [known, added] = alone_.try_emplace({from.place, to.place}, false);
      if (added) known->second = world_.is_free_for_one(number(arm_), places_[from.place], places_[to.place]);
      if (!known->second) return false;
    }
    for (std::size_t other = 0; other < path_.arms.size(); ++other)
      if (other != arm_ && world_.may_conflict(number(arm_), number(other)) && !are_collision_free(from, to, other))
        return false;
    return true;
  }
  /// The other moves straight from row to row. Exact distances matter where an arm must be, spheres are quicker
  /// elsewhere.
  bool are_collision_free(const Node& from, const Node& to, std::size_t other) {
    auto row = std::upper_bound(path_.steps.begin(), path_.steps.end(), from.step);
    for (double step = from.step, next = step; step < to.step; step = next) {
      next = row == path_.steps.end() ? to.step : std::min<double>(to.step, *row++);
      const Eigen::VectorXd a = between(from, to, step), b = between(from, to, next);
      const Eigen::VectorXd c = position_at(path_, other, step), d = position_at(path_, other, next);
      const bool by_spheres = !is_end(arm_, a) && !is_end(arm_, b) && !is_end(other, c) && !is_end(other, d);
      if (!world_.are_collision_free(number(arm_), a, b, number(other), c, d, {true, by_spheres})) return false;
    }
    return true;
  }
  bool is_end(std::size_t arm, const Eigen::VectorXd& q) const {
    const RowMatrix& rows = path_.positions[arm];
    return q == rows.row(0).transpose() || q == rows.bottomRows(1).transpose();
  }
  Eigen::VectorXd between(const Node& from, const Node& to, double step) const {
    if (step >= to.step) return places_[to.place];
    const double share = (step - from.step) / (to.step - from.step);
    return places_[from.place] + share * robot().difference(places_[from.place], places_[to.place]);
  }

  bool can_stay(const Node& node) { return node.step == end_ || is_free(node, {node.place, end_, 0.0, no_node}); }

  JointPath answer(std::size_t id) const {
    JointPath own{{number(arm_)}, {}, {}}, others{{}, path_.steps, {}};
    std::vector<Node> way;
    for (; id != no_node; id = nodes_[id].parent) way.push_back(nodes_[id]);
    std::reverse(way.begin(), way.end());
    RowMatrix q(std::ssize(way), places_[0].size());
    for (Eigen::Index row = 0; row < q.rows(); ++row) {
      const Node& node = way[static_cast<std::size_t>(row)];
      own.steps.push_back(node.step);
      q.row(row) = places_[node.place].transpose();
    }
    own.positions.push_back(world_.unwrapped(number(arm_), q));
    for (std::size_t other = 0; other < path_.arms.size(); ++other)
      if (other != arm_) {
        others.arms.push_back(path_.arms[other]);
        others.positions.push_back(path_.positions[other]);
      }
    return side_by_side(own, others);
  }

  const JointPath& path_;
  std::size_t arm_;
  MultiRobotWorld& world_;
  const Deadline& deadline_;
  const WorldTask& task_;
  std::vector<Eigen::VectorXd> places_;  // 0: the start
  std::vector<double> left_;             // of each place: straight to the nearest goal
  int end_{};
  std::vector<Node> nodes_;
  std::map<std::pair<std::size_t, int>, double> best_;
  std::map<std::pair<std::size_t, std::size_t>, bool> alone_;
  std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>, std::greater<>>
      open_;
};

}  // namespace

JointPath reroute_one_robot(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                            const std::vector<std::vector<Eigen::VectorXd>>& places) {
  if (path.size() < 3 || path.arms.size() < 2) return path;
  for (std::size_t arm = 0; arm < path.arms.size() && !deadline.stop_requested(); ++arm) {
    const std::vector<Eigen::VectorXd> more = places.empty() ? std::vector<Eigen::VectorXd>{} : places[path.arms[arm]];
    if (auto better = NeighbourhoodSearch(path, arm, world, more, deadline).run()) path = std::move(*better);
  }
  return path;
}

}  // namespace srmp
