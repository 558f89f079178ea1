#include "srmp/lattice/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr std::int32_t full_turn = 3'600'000;  // grid units in 360 degrees
// Goals lie on no grid. Their first key entry is `target_root` for targets, and less than that for the first, second, …
// goal connection of a state, or `tree_root`; the second entry is the number of the target, or of the state.
constexpr std::int32_t target_root = -1;
constexpr std::int32_t tree_root = std::numeric_limits<std::int32_t>::min();  // of goals in the other tree
constexpr std::size_t nodes_to_compare = 4096;                                // in an expansion, on average
constexpr double limit_tolerance = 1e-9;
constexpr double min_cost = 1e-12;  // of edges, whose costs must be more than 0

double shortest(double difference) { return std::remainder(difference, 2.0 * std::numbers::pi); }

}  // namespace

RowMatrix distance_weights(std::size_t dof) {
  RowMatrix weights = RowMatrix::Ones(3, static_cast<Eigen::Index>(dof));
  for (Eigen::Index j = 0; j < weights.cols(); ++j) {
    const double along = dof > 1 ? static_cast<double>(j) / static_cast<double>(dof - 1) : 0.0;
    weights(1, j) = 2.0 - 1.9 * along;
    weights(2, j) = 0.5 + 0.7 * along;
  }
  return weights;
}

Lattice::Lattice(const std::vector<Joint>& joints, std::vector<Eigen::VectorXd> roots,
                 std::vector<Eigen::VectorXd> targets, Options options, MotionValidator validator, std::size_t workers)
    : joints_(joints),
      roots_(std::move(roots)),
      root_count_(roots_.size()),
      targets_(std::move(targets)),
      near_distance_(options.primitives.near_distance),
      connection_distance_(options.connection_distance),
      goal_connection_(std::move(options.goal_connection)),
      projection_(std::move(options.projection)),
      validator_(std::move(validator)),
      observer_(std::move(options.observer)),
      table_(joints.size() + 1),
      scratch_key_(joints.size() + 1, 0),
      q_(static_cast<Eigen::Index>(joints.size())),
      ends_(workers, {q_, q_}),
      workers_(workers) {
  for (const Joint& joint : joints_) unit_.push_back(grid_unit(joint));
  add_level(options.primitives, {});
  for (const CoarseLevel& level : options.coarser) add_level(level.primitives, level.step);
  for (std::size_t i = 0; i < roots_.size(); ++i) {
    scratch_key_[0] = static_cast<std::int32_t>(i);
    const search::StateId root = table_.insert(scratch_key_);
    if (projection_.project) cells_.emplace(cell(), root);
  }
  scratch_key_[0] = target_root;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    scratch_key_[1] = static_cast<std::int32_t>(i);
    table_.insert(scratch_key_);
  }
  scratch_key_[1] = 0;
  for (Eigen::VectorXd& waypoint : options.waypoints) {
    scratch_key_[0] = static_cast<std::int32_t>(roots_.size());
    roots_.push_back(std::move(waypoint));
    table_.insert(scratch_key_);
  }
}

void Lattice::add_level(const PrimitiveSet& primitives, const Eigen::VectorXd& step) {
  Level& level = levels_.emplace_back();
  for (const PrimitiveFamily& family : primitives.families) level.families.push_back(make_family(family));
  for (Eigen::Index j = 0; j < step.size(); ++j)
    level.steps.push_back(static_cast<std::int32_t>(std::lround(step[j] / unit_[static_cast<std::size_t>(j)])));
}

Lattice::Family Lattice::make_family(const PrimitiveFamily& family) const {
  Family added{family.use, {}};
  for (const Eigen::VectorXd& delta : family.moves) {
    Move move{{}, 0.0};
    for (std::size_t j = 0; j < joints_.size(); ++j)
      move.steps.push_back(static_cast<std::int32_t>(std::lround(delta[static_cast<Eigen::Index>(j)] / unit_[j])));
    move.cost = move_cost(move);
    if (move.cost == 0.0)
      throw InvalidArgument("motion primitive family '" + family.name + "' has a move of zero length");
    added.moves.push_back(std::move(move));
  }
  return added;
}

bool Lattice::is_on(search::StateId state, std::size_t level) const {
  const auto key = table_.key(state);
  const std::vector<std::int32_t>& steps = levels_[level].steps;
  for (std::size_t j = 0; j < steps.size(); ++j)
    if (key[j + 1] % steps[j] != 0) return false;
  return true;
}

std::vector<search::StateId> Lattice::starts() const {
  std::vector<search::StateId> ids;
  for (std::size_t i = 0; i < root_count_; ++i) ids.push_back(static_cast<search::StateId>(i));
  return ids;
}

void Lattice::read_configuration(search::StateId state, Eigen::VectorXd& q) const {
  if (is_goal(state)) {
    const ConnectedGoal* connected = connected_goal(state);
    const auto connection = tree_connections_.find(state);
    if (connected)
      q = connected->q;
    else
      q = connection == tree_connections_.end() ? targets_[state - root_count()] : (*other_tree_)[connection->second];
    return;
  }
  const auto key = table_.key(state);
  const Eigen::VectorXd& root = roots_[static_cast<std::size_t>(key[0])];
  for (std::size_t j = 0; j < joints_.size(); ++j)
    q[static_cast<Eigen::Index>(j)] = root[static_cast<Eigen::Index>(j)] + key[j + 1] * unit_[j];
}

const ConnectedGoal* Lattice::connected_goal(search::StateId state) const {
  const auto found = connected_goals_.find(state);
  return found == connected_goals_.end() ? nullptr : &found->second;
}

std::size_t Lattice::target_of(search::StateId goal) const {
  const auto connection = tree_connections_.find(goal);
  if (connection == tree_connections_.end()) return goal - root_count();
  const Eigen::VectorXd end = other_tree_->to_root(connection->second).back();
  return static_cast<std::size_t>(std::find(targets_.begin(), targets_.end(), end) - targets_.begin());
}

std::size_t Lattice::memory() const {
  const std::size_t connected = sizeof(decltype(connected_goals_)::value_type) + joints_.size() * sizeof(double);
  const std::size_t connection = sizeof(decltype(tree_connections_)::value_type);
  return table_.memory() + nodes_.memory() + connected_goals_.size() * connected +
         tree_connections_.size() * connection;
}

Eigen::VectorXd Lattice::configuration(search::StateId state) const {
  Eigen::VectorXd q(static_cast<Eigen::Index>(joints_.size()));
  read_configuration(state, q);
  return q;
}

double Lattice::distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  double squared = 0.0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    const double d = difference(j, a[i], b[i]);
    squared += d * d;
  }
  return std::sqrt(squared);
}

std::vector<char> Lattice::wraps() const {
  std::vector<char> result;
  for (const Joint& joint : joints_) result.push_back(joint.kind == JointKind::continuous);
  return result;
}

double Lattice::difference(std::size_t joint, double from, double to) const {
  return joints_[joint].kind == JointKind::continuous ? shortest(to - from) : to - from;
}

double Lattice::move_cost(const Move& move) const {
  double squared = 0.0;
  for (std::size_t j = 0; j < joints_.size(); ++j) squared += std::pow(move.steps[j] * unit_[j], 2);
  return std::sqrt(squared);
}

double Lattice::distance_to_targets(search::StateId state) const {
  if (is_goal(state)) return 0.0;
  read_configuration(state, q_);
  double least = search::infinity;
  for (const Eigen::VectorXd& target : targets_) least = std::min(least, distance(q_, target));
  return least;
}

double Lattice::distance_from_roots(search::StateId state) const {
  read_configuration(state, q_);
  double least = search::infinity;
  for (std::size_t i = 0; i < root_count_; ++i) least = std::min(least, distance(roots_[i], q_));
  return least;
}

void Lattice::distances_to_targets(search::StateId state, const RowMatrix& weights, std::span<double> out) const {
  std::fill(out.begin(), out.end(), is_goal(state) ? 0.0 : search::infinity);
  if (is_goal(state)) return;
  read_configuration(state, q_);
  for (const Eigen::VectorXd& target : targets_) {
    for (Eigen::Index row = 0; row < weights.rows(); ++row) {
      double squared = 0.0;
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        const auto i = static_cast<Eigen::Index>(j);
        squared += std::pow(weights(row, i) * difference(j, q_[i], target[i]), 2);
      }
      double& least = out[static_cast<std::size_t>(row)];
      least = std::min(least, std::sqrt(squared));
    }
    double sum = 0.0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const auto i = static_cast<Eigen::Index>(j);
      sum += std::abs(difference(j, q_[i], target[i]));
    }
    out.back() = std::min(out.back(), sum);
  }
}

bool Lattice::apply(search::StateId state, const Move& move) {
  const auto key = table_.key(state);
  const Eigen::VectorXd& root = roots_[static_cast<std::size_t>(key[0])];
  scratch_key_[0] = key[0];
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    std::int32_t coordinate = key[j + 1] + move.steps[j];
    if (joints_[j].kind == JointKind::continuous) {
      coordinate = (coordinate % full_turn + full_turn + full_turn / 2) % full_turn - full_turn / 2;
    } else if (move.steps[j] != 0) {
      const double value = root[static_cast<Eigen::Index>(j)] + coordinate * unit_[j];
      if (value < joints_[j].lower - limit_tolerance || value > joints_[j].upper + limit_tolerance) return false;
    }
    scratch_key_[j + 1] = coordinate;
  }
  return true;
}

void Lattice::add_moves(search::StateId state, const Family& family, std::vector<search::Successor>& out) {
  for (const Move& move : family.moves)
    if (family.use == PrimitiveUse::to_targets)
      add_moves_to_targets(state, move, out);
    else
      add_move(state, move, out);
}

void Lattice::add_move(search::StateId state, const Move& move, std::vector<search::Successor>& out) {
  if (!apply(state, move)) return;
  if (projection_.project) {
    const search::StateId next = insert_projected(state);
    if (next != state) out.push_back({next, std::max(min_cost, distance(q_, configuration(next)))});
    return;
  }
  const search::StateId next = table_.insert(scratch_key_);
  if (next != state) out.push_back({next, move.cost});
}

/// From `state`, whose configuration is q_. Moves to different targets may be the same; parallel edges are left out.
void Lattice::add_moves_to_targets(search::StateId state, const Move& steps, std::vector<search::Successor>& out) {
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  for (const Eigen::VectorXd& target : targets_) {
    scratch_move_ = steps;
    std::size_t moving = 0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const auto i = static_cast<Eigen::Index>(j);
      const double to_go = difference(j, q_[i], target[i]);
      std::int32_t& step = scratch_move_.steps[j];
      if (std::abs(to_go) < 0.5 * std::abs(step) * unit_[j]) step = 0;
      if ((to_go < 0.0) != (step < 0)) step = -step;
      moving += step != 0;
    }
    if (moving < 3 || !apply(state, scratch_move_)) continue;
    const search::StateId next = projection_.project ? insert_projected(state) : table_.insert(scratch_key_);
    if (next == state) continue;
    if (std::none_of(out.begin() + first, out.end(), [&](const search::Successor& s) { return s.state == next; }))
      out.push_back({next, projection_.project ? std::max(min_cost, distance(q_, configuration(next)))
                                               : move_cost(scratch_move_)});
  }
}

search::StateId Lattice::insert_projected(search::StateId state) {
  const Eigen::VectorXd& root = roots_[static_cast<std::size_t>(scratch_key_[0])];
  Eigen::VectorXd q = root;
  for (std::size_t j = 0; j < joints_.size(); ++j) q[static_cast<Eigen::Index>(j)] += scratch_key_[j + 1] * unit_[j];
  if (!projection_.project(q)) return state;
  for (std::size_t j = 0; j < joints_.size(); ++j) {  // towards the root, which is within the limits
    const auto i = static_cast<Eigen::Index>(j);
    scratch_key_[j + 1] = static_cast<std::int32_t>(std::trunc(difference(j, root[i], q[i]) / unit_[j]));
  }
  const auto [entry, is_new] = cells_.try_emplace(cell(), state);
  if (is_new) entry->second = table_.insert(scratch_key_);
  return entry->second;
}

std::vector<std::int32_t> Lattice::cell() const {
  std::vector<std::int32_t> key{scratch_key_[0]};
  for (std::size_t j = 0; j < joints_.size(); ++j)
    key.push_back(static_cast<std::int32_t>(
        std::lround(scratch_key_[j + 1] * unit_[j] / projection_.cell[static_cast<Eigen::Index>(j)])));
  return key;
}

void Lattice::successors(search::StateId state, std::vector<search::Successor>& out) {
  connections(state, out);
  successors(state, 0, out);
}

void Lattice::connections(search::StateId state, std::vector<search::Successor>& out) {
  if (is_goal(state)) return;
  read_configuration(state, q_);
  if (observer_.expanded) observer_.expanded(q_, distance_to_targets(state));
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    const double cost = distance(q_, targets_[t]);
    if (cost <= connection_distance_)
      out.push_back({static_cast<search::StateId>(root_count() + t), std::max(cost, min_cost)});
  }
  for (std::size_t i = root_count_; i < roots_.size(); ++i) {
    const auto waypoint = static_cast<search::StateId>(i + targets_.size());
    if (waypoint != state) out.push_back({waypoint, std::max(distance(q_, roots_[i]), min_cost)});
  }
  add_goal_connections(state, out);
  add_tree_connection(state, out);
}

void Lattice::successors(search::StateId state, std::size_t level, std::vector<search::Successor>& out) {
  if (is_goal(state)) return;
  read_configuration(state, q_);
  const bool near = near_an_end(q_);
  for (const Family& family : levels_[level].families)
    if (family.use == PrimitiveUse::always || family.use == PrimitiveUse::to_targets ||
        (family.use == PrimitiveUse::near) == near)
      add_moves(state, family, out);
}

/// From `state`, whose configuration is q_. Generated again, the same goals have the same numbers.
void Lattice::add_goal_connections(search::StateId state, std::vector<search::Successor>& out) {
  if (!goal_connection_) return;
  std::fill(scratch_key_.begin(), scratch_key_.end(), 0);
  scratch_key_[0] = target_root;
  scratch_key_[1] = static_cast<std::int32_t>(state);
  for (ConnectedGoal& goal : goal_connection_(q_)) {
    --scratch_key_[0];
    const search::StateId next = table_.insert(scratch_key_);
    out.push_back({next, std::max(distance(q_, goal.q), min_cost)});
    connected_goals_.emplace(next, std::move(goal));
  }
}

void Lattice::connect_trees(search::ConfigurationTree& own, const search::ConfigurationTree& other) {
  own_tree_ = &own;
  other_tree_ = &other;
}

void Lattice::expanding(search::StateId state, search::StateId parent) {
  if (!own_tree_) return;
  read_configuration(state, q_);
  nodes_.grow_to(table_.size(), 0);
  nodes_[state] = parent == search::no_state ? own_tree_->add_root(q_) : own_tree_->add(q_, nodes_[parent]);
}

/// From `state`, whose configuration is q_. The larger the other tree, the fewer states are compared with it, so that
/// the comparisons take no more time than the rest of the search.
void Lattice::add_tree_connection(search::StateId state, std::vector<search::Successor>& out) {
  if (!other_tree_ || other_tree_->empty()) return;
  if (expansions_++ % (1 + other_tree_->size() / nodes_to_compare) != 0) return;
  std::fill(scratch_key_.begin(), scratch_key_.end(), 0);
  scratch_key_[0] = tree_root;
  scratch_key_[1] = static_cast<std::int32_t>(state);
  const search::StateId next = table_.insert(scratch_key_);
  const std::size_t node = tree_connections_.try_emplace(next, other_tree_->nearest(q_)).first->second;
  const double cost = distance(q_, (*other_tree_)[node]) + other_tree_->cost(node);
  out.push_back({next, std::max(cost, min_cost)});
}

bool Lattice::near_an_end(const Eigen::VectorXd& q) const {
  const auto close = [&](const Eigen::VectorXd& end) { return distance(q, end) <= near_distance_; };
  return std::any_of(targets_.begin(), targets_.end(), close) || std::any_of(roots_.begin(), roots_.end(), close);
}

void Lattice::evaluate(std::span<const search::Edge> edges, std::span<double> costs) {
  workers_.run(edges.size(), [&](std::size_t worker, std::size_t i) {
    auto& [from, to] = ends_[worker];
    read_configuration(edges[i].from, from);
    read_configuration(edges[i].to, to);
    costs[i] = validator_(worker, from, to) ? edges[i].cost : search::infinity;
  });
  if (observer_.evaluated) tell(edges, costs);
}

void Lattice::tell(std::span<const search::Edge> edges, std::span<const double> costs) const {
  for (std::size_t i = 0; i < edges.size(); ++i)
    observer_.evaluated(configuration(edges[i].from), configuration(edges[i].to), costs[i] != search::infinity);
}

std::vector<Eigen::VectorXd> Lattice::configurations(std::span<const search::StateId> path) const {
  std::vector<Eigen::VectorXd> result;
  for (const search::StateId state : path) {
    Eigen::VectorXd q = configuration(state);
    if (!result.empty()) {
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        const auto i = static_cast<Eigen::Index>(j);
        if (joints_[j].kind == JointKind::continuous) q[i] = result.back()[i] + shortest(q[i] - result.back()[i]);
      }
    }
    result.push_back(std::move(q));
  }
  const auto connection = path.empty() ? tree_connections_.end() : tree_connections_.find(path.back());
  if (connection == tree_connections_.end()) return result;
  const std::vector<Eigen::VectorXd> onwards = other_tree_->to_root(connection->second);
  for (std::size_t i = 1; i < onwards.size(); ++i)
    result.push_back(result.back() + other_tree_->difference(result.back(), onwards[i]));
  return result;
}

}  // namespace srmp
