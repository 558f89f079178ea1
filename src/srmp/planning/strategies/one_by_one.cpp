#include "srmp/planning/strategies/one_by_one.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "srmp/core/memory_of.hpp"
#include "srmp/planning/strategies/composite_sampling.hpp"
#include "srmp/planning/strategies/retreats.hpp"
#include "srmp/planning/strategies/robot_sampling.hpp"
#include "srmp/search/best_first.hpp"
#include "srmp/search/rrt_connect.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

namespace {

using Path = std::vector<Eigen::VectorXd>;

constexpr int points_of_path = 16;  // where retreats are to leave it free

/// Of the path of one robot.
Path points_along(const JointPath& path) {
  Path points;
  for (int n = 0; n <= points_of_path; ++n)
    points.push_back(position_at(path, 0, path.steps.back() * n / points_of_path));
  return points;
}

/// Do two robots move at the same time?
bool move_together(const JointPath& path) {
  for (Eigen::Index row = 1; row < std::ssize(path.steps); ++row)
    if (std::ranges::count_if(path.positions, [&](const RowMatrix& q) { return q.row(row) != q.row(row - 1); }) > 1)
      return true;
  return false;
}

/// The search over the robots' places; a search::BestFirstProblem. Backwards, the robots start at their goals, and
/// their starts are the goals.
class PlacesSearch {
 public:
  /// By robot: the number of its place: its start, its goal, then its retreats.
  using State = std::vector<signed char>;
  static constexpr signed char at_start = 0, at_goal = 1, no_place = -1;
  struct Node {
    State places;
    double detour;       // of all motions so far, beyond the robots' own paths
    std::size_t motion;  // that led here, in motions_; not_found: not searched for yet
  };

  PlacesSearch(MultiRobotWorld& world, const std::vector<std::size_t>& robots, const std::vector<Path>& own_paths,
               const std::vector<const JointPath*>& known, bool backwards, const OneByOneOptions& options,
               const Deadline& deadline)
      : world_(world), robots_(robots), backwards_(backwards), options_(options), deadline_(deadline) {
    for (std::size_t i = 0; i < robots.size(); ++i) {
      Path own = own_paths[i];
      if (own.empty()) continue;
      const bool of_task = own == world.task(robots[i]).single_robot_path;
      if (backwards) std::ranges::reverse(own);
      motions_.push_back(joint_path(world, robots[i], own));
      own_lengths_.push_back(of_task ? world.alone(robots[i]) : motions_.back().length());
      places_.push_back({own.front(), own.back()});
    }
    for (const JointPath* path : known)
      if (places_.size() == robots.size() && move_together(*path)) add_known(backwards ? reversed(*path) : *path);
  }

  /// The phases of a search, the cheapest first. find() is to be called in this order: retreats stay for later phases.
  enum class Phase { directly, with_retreats, known_by_trees, in_pairs };

  std::optional<JointPath> find(Phase phase) {
    if (!has_places()) return std::nullopt;
    switch (phase) {
      case Phase::directly: return search_as_known_first();
      case Phase::with_retreats:
        for (std::size_t i = 0; i < robots_.size(); ++i) add_retreats(i);
        goal_weight_ = options_.goal_weight_with_retreats;
        return search_as_known_first();
      case Phase::known_by_trees: return search_as_known({.by_trees = true});
      case Phase::in_pairs: stage_ = {.in_pairs = true}; return robots_.size() > 2 ? search() : std::nullopt;
    }
    return std::nullopt;
  }
  /// Of all phases.
  const OneByOneWork& work() const { return work_; }

  bool is_dominated(const Node& node) const { return closed_.dominates(node.places, node.detour); }
  bool is_valid(search::NodeId id) {
    const search::NodeId parent = search_->parent(id);
    if (parent == search::no_node || (*search_)[id].motion != not_found) return true;
    Node node = (*search_)[id];
    const Node& from = (*search_)[parent];
    node.motion = motion_between(from.places, node.places);
    if (node.motion == not_found) return false;
    const double detour = motions_[node.motion].length() - shorter_left(from.places, node.places);
    node.detour = from.detour + std::max(0.0, detour);
    add(std::move(node), parent);
    return false;
  }
  void close(const Node& node) { closed_.close(node.places, node.detour); }
  bool is_goal(const Node& node) const { return left(node.places) == 0; }
  bool may_expand(std::uint64_t expansions) const {
    return expansions <= options_.max_expansions && work_.attempts - attempts_before_ < attempts_of_all();
  }

  void expand(search::NodeId id) {
    const Node from = (*search_)[id];
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (is_there(i, from.places)) continue;
      if (const Known* known = as_known(i)) {
        if (i == known->robots.front()) add_known_move(id, from, *known);
        continue;
      }
      const auto end = static_cast<signed char>(from.places[i] == at_start ? places_[i].size() : at_goal + 1);
      for (signed char to = at_goal; to < end; ++to) add_move(id, from, {{i, to}});
      for (std::size_t k = i + 1; stage_.in_pairs && k < robots_.size(); ++k)
        if (!is_there(k, from.places) && may_conflict(i, k)) add_move(id, from, {{i, at_goal}, {k, at_goal}});
    }
  }

 private:
  static constexpr std::size_t not_found = static_cast<std::size_t>(-1);

  /// A path on which robots move at the same time.
  struct Known {
    std::vector<std::size_t> robots;
    std::size_t motion{};  // in motions_
  };
  /// Which motions there are.
  struct Stage {
    bool as_known{};  // robots that have a known path move together
    bool by_trees{};  // also where their path is in conflict with robots that stand
    bool in_pairs{};  // of two robots
  };

  /// Of the robots that have to move, if the path leads from the starts to the goals of their own paths.
  void add_known(const JointPath& path) {
    Known known{{}, motions_.size()};
    for (std::size_t n = 0; n < path.robots.size(); ++n) {
      const auto i = static_cast<std::size_t>(std::ranges::find(robots_, path.robots[n]) - robots_.begin());
      const RowMatrix& q = path.positions[n];
      if (model(i).difference(q.row(0).transpose(), place(i, at_start)).norm() > 1e-12) return;
      if (model(i).difference(q.row(q.rows() - 1).transpose(), place(i, at_goal)).norm() > 1e-12) return;
      if (motions_[i].size() > 1) known.robots.push_back(i);
    }
    known_.push_back(std::move(known));
    motions_.push_back(path);
  }

  /// Has every robot a path of its own, and do these end apart?
  bool has_places() {
    if (places_.size() < robots_.size()) return false;
    const State root(robots_.size(), at_start);
    for (std::size_t i = 0; i < robots_.size(); ++i)
      if (backwards_ && !is_place_free(i, root)) return false;
    return true;
  }

  std::optional<JointPath> search_as_known_first() {
    if (auto path = search_as_known({})) return path;
    return search();
  }
  std::optional<JointPath> search_as_known(Stage stage) {
    if (known_.empty()) return std::nullopt;
    stage.as_known = true;
    stage_ = stage;
    auto path = search();
    stage_ = {};
    return path;
  }

  std::optional<JointPath> search() {
    search_.emplace();
    closed_ = {};
    attempts_before_ = work_.attempts;
    add({State(robots_.size(), at_start), 0.0, not_found}, search::no_node);
    const search::BestFirstResult found = search_->run(*this, deadline_);
    work_.expansions += found.expansions;
    work_.memory = std::max(work_.memory, search_->memory() + memory_of(closed_.costs()) + memory_of(motions_));
    if (found.status != Status::solved) return std::nullopt;
    return path_to(found.goal);
  }

  std::uint64_t attempts_of_all() const {
    if (stage_.by_trees) return options_.known_attempts_of_all;
    return stage_.in_pairs ? options_.pair_attempts_of_all : options_.attempts_of_all;
  }

  void add(Node node, search::NodeId parent) {
    const std::size_t count = left(node.places);
    search_->add(std::move(node), {node.detour + goal_weight_ * static_cast<double>(count), count}, parent);
  }

  void add_move(search::NodeId id, const Node& from, const std::vector<std::pair<std::size_t, signed char>>& moves) {
    Node to = from;
    for (const auto& [i, place] : moves) to.places[i] = place;
    for (const auto& [i, place] : moves)
      if (!is_place_free(i, to.places)) return;
    double least = -shorter_left(from.places, to.places);
    for (const auto& [i, place] : moves) least += distance(i, from.places[i], place);
    to.motion = not_found;
    const std::size_t i = moves.front().first;
    if (moves.size() == 1 && from.places[i] == at_start && moves.front().second == at_goal &&
        std::ranges::count(blockers(from.places, to.places), no_place) == std::ssize(robots_))
      to.motion = i;
    else
      to.detour += std::max(least, options_.expected_detour);
    add(std::move(to), id);
  }

  /// All robots of a known path from their starts to their goals.
  void add_known_move(search::NodeId id, const Node& from, const Known& known) {
    Node to = from;
    for (const std::size_t i : known.robots) to.places[i] = at_goal;
    to.motion = not_found;
    to.detour += motions_[known.motion].length() - shorter_left(from.places, to.places);
    add(std::move(to), id);
  }
  /// The known path that the robot is to move along with others.
  const Known* as_known(std::size_t i) const {
    const auto found = std::ranges::find_if(
        known_, [i](const Known& known) { return std::ranges::find(known.robots, i) != known.robots.end(); });
    return stage_.as_known && found != known_.end() ? &*found : nullptr;
  }

  // --- costs

  bool is_there(std::size_t i, const State& places) const { return places[i] == at_goal || motions_[i].size() == 1; }
  std::size_t left(const State& places) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < robots_.size(); ++i) count += !is_there(i, places);
    return count;
  }
  const RobotModel& model(std::size_t i) const { return world_.model(robots_[i]); }
  double distance(std::size_t i, signed char from, signed char to) const {
    return model(i).difference(place(i, from), place(i, to)).norm();
  }
  /// Of a robot from where it stands, at least, as if the others were not there.
  double own_left(std::size_t i, const State& places) const {
    if (is_there(i, places)) return 0.0;
    return places[i] == at_start ? own_lengths_[i] : distance(i, places[i], at_goal);
  }
  double shorter_left(const State& from, const State& to) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < robots_.size(); ++i) sum += own_left(i, from) - own_left(i, to);
    return sum;
  }

  // --- places

  const Eigen::VectorXd& place(std::size_t i, signed char number) const {
    return places_[i][static_cast<std::size_t>(number)];
  }
  bool may_conflict(std::size_t i, std::size_t k) const {
    return i != k && world_.may_conflict(robots_[i], robots_[k]);
  }

  void add_retreats(std::size_t i) {
    const std::vector<Eigen::VectorXd> candidates =
        retreat_candidates(model(i), place(i, at_start), place(i, at_goal), {place(i, at_start), place(i, at_goal)});
    const std::size_t tried = std::min(options_.retreat_candidates, candidates.size());
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t n = 0; n < tried && !deadline_.stop_requested(); ++n) {
      const std::size_t number = n * candidates.size() / tried;
      const Eigen::VectorXd& q = candidates[number];
      if (world_.is_free_for_one(robots_[i], q) && is_clear_of_ends(i, q))
        order.emplace_back(-collision_free_fraction(world_, robots_[i], q, own_points()), number);
    }
    std::ranges::sort(order);
    for (std::size_t n = 0; n < std::min(options_.retreats, order.size()); ++n)
      places_[i].push_back(candidates[order[n].second]);
  }
  /// Of the robots' own paths, by number in the world.
  const std::vector<Path>& own_points() {
    if (own_points_.empty()) {
      own_points_.resize(world_.size());
      for (std::size_t i = 0; i < robots_.size(); ++i) own_points_[robots_[i]] = points_along(motions_[i]);
    }
    return own_points_;
  }
  /// Of the others' starts and goals.
  bool is_clear_of_ends(std::size_t i, const Eigen::VectorXd& q) {
    for (std::size_t k = 0; k < robots_.size(); ++k)
      if (may_conflict(i, k))
        for (const char free : world_.collision_free_with(robots_[i], q, robots_[k], std::span(places_[k]).first(2)))
          if (!free) return false;
    return true;
  }
  /// Where robot i is to be, of the others.
  bool is_place_free(std::size_t i, const State& places) {
    for (std::size_t k = 0; k < robots_.size(); ++k) {
      if (!may_conflict(i, k)) continue;
      const auto [entry, added] = places_free_.try_emplace({i, k, places[i], places[k]}, false);
      const Eigen::VectorXd &q = place(i, places[i]), &other = place(k, places[k]);
      if (added) entry->second = world_.are_collision_free(robots_[i], q, q, robots_[k], other, other);
      if (!entry->second) return false;
    }
    return true;
  }

  // --- motions

  /// By robot: the place where it stands, if a robot that moves would collide with it there on its own path, or
  /// straight where it has none.
  State blockers(const State& from, const State& to) {
    State found(robots_.size(), no_place);
    for (std::size_t i = 0; i < robots_.size(); ++i)
      for (std::size_t k = 0; k < robots_.size() && from[i] != to[i]; ++k)
        if (from[k] == to[k] && may_conflict(i, k) && !is_direct_free(i, from[i], to[i], k, to[k])) found[k] = to[k];
    return found;
  }
  bool is_direct_free(std::size_t i, signed char from, signed char to, std::size_t k, signed char other) {
    const auto [entry, added] = direct_free_.try_emplace({i, k, from, to, other}, true);
    if (!added) return entry->second;
    const Path direct = from == at_start && to == at_goal ? unstack_waypoints(motions_[i].positions.front())
                                                          : Path{place(i, from), place(i, to)};
    const Eigen::VectorXd& q = place(k, other);
    for (std::size_t row = 1; row < direct.size() && entry->second; ++row)
      entry->second = world_.are_collision_free(robots_[i], direct[row - 1], direct[row], robots_[k], q, q,
                                                {.start_is_free = true});
    return entry->second;
  }

  /// Of the robots whose places differ. One that was not found past some robots is not searched for past these again,
  /// wherever the others stand.
  std::size_t motion_between(const State& from, const State& to) {
    const Known* moves = nullptr;
    for (std::size_t i = 0; i < robots_.size(); ++i)
      if (from[i] != to[i] && as_known(i)) moves = as_known(i);
    if (moves && is_free_of_others(*moves, to)) return moves->motion;
    if (moves && !stage_.by_trees) return not_found;
    const auto [entry, added] = found_.try_emplace({from, to}, not_found);
    if (!added) return entry->second;
    State failure = blockers(from, to);
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      failure.push_back(from[i] == to[i] ? no_place : from[i]);
      failure.push_back(from[i] == to[i] ? no_place : to[i]);
    }
    if (failed_.contains(failure)) return not_found;
    if (std::optional<JointPath> motion = search_motion(from, to, moves ? &motions_[moves->motion] : nullptr)) {
      entry->second = motions_.size();
      motions_.push_back(std::move(*motion));
    } else {
      failed_.insert(std::move(failure));
    }
    return entry->second;
  }

  bool is_free_of_others(const Known& known, const State& places) {
    const JointPath& motion = motions_[known.motion];
    for (std::size_t k = 0; k < robots_.size(); ++k) {
      if (std::ranges::find(motion.robots, robots_[k]) != motion.robots.end()) continue;
      const auto [is_free, added] = known_free_.try_emplace({known.motion, k, places[k]}, false);
      if (added) is_free->second = !in_conflict(world_, motion, joint_path(world_, robots_[k], {place(k, places[k])}));
      if (!is_free->second) return false;
    }
    return true;
  }

  /// `known`: a path that is in conflict with robots that stand; null: none.
  std::optional<JointPath> search_motion(const State& from, const State& to, const JointPath* known) {
    CompositeSpace::Others others;
    std::vector<std::size_t> moved;
    Path starts, goals;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (from[i] == to[i]) {
        others.push_back({robots_[i], place(i, from[i])});
        continue;
      }
      moved.push_back(robots_[i]);
      starts.push_back(place(i, from[i]));
      goals.push_back(place(i, to[i]));
    }
    const CompositeSpace space(world_, std::move(moved), starts, goals, std::move(others));
    const auto is_free = [&space](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return space.is_motion_free(a, b);
    };
    const bool alone = space.size() == 1;
    search::RrtSpace to_grow = alone ? rrt_space(space.model(0), space.start(), space.targets()) : rrt_space(space);
    to_grow.is_motion_free = is_free;
    const ShortcutOptions waypoints_only{.max_rounds = 0, .continuous = {to_grow.wraps.begin(), to_grow.wraps.end()}};
    search::RrtConnect trees(std::move(to_grow), options_.seed);
    std::uint64_t attempts = alone ? options_.attempts : options_.pair_attempts;
    if (known) {
      attempts = options_.known_attempts;
      trees.follow(space.configurations(*known), deadline_);
    }
    const auto rows = trees.grow(attempts, deadline_);
    work_.attempts += trees.attempts();
    work_.memory = std::max(work_.memory, trees.memory());
    if (!rows) return std::nullopt;
    const RowMatrix unwrapped = unwrap_waypoints(stack_waypoints(*rows), waypoints_only.continuous);
    return space.path(unstack_waypoints(shortcut(unwrapped, is_free, deadline_, waypoints_only).waypoints));
  }

  JointPath path_to(search::NodeId goal) const {
    std::vector<Path> rows(robots_.size());
    for (std::size_t i = 0; i < robots_.size(); ++i) rows[i].push_back(place(i, at_start));
    for (const search::NodeId id : search_->path_to(goal)) {
      if (search_->parent(id) == search::no_node) continue;
      const JointPath& motion = motions_[(*search_)[id].motion];
      for (Eigen::Index row = 1; row < std::ssize(motion.steps); ++row)
        for (std::size_t i = 0; i < robots_.size(); ++i) {
          const auto moved = std::ranges::find(motion.robots, robots_[i]) - motion.robots.begin();
          const bool stands = moved == std::ssize(motion.robots);
          Eigen::VectorXd q = rows[i].back();
          if (!stands) q = motion.positions[static_cast<std::size_t>(moved)].row(row).transpose();
          rows[i].push_back(std::move(q));
        }
    }
    for (std::size_t i = 0; i < robots_.size() && backwards_; ++i) {
      std::ranges::reverse(rows[i]);
      const Eigen::VectorXd first = rows[i].front();
      for (Eigen::VectorXd& q : rows[i]) {
        if (q != first) break;
        q = place(i, at_goal);  // the start itself, without whole turns
      }
    }
    return joint_path(world_, robots_, rows);
  }

  MultiRobotWorld& world_;
  const std::vector<std::size_t>& robots_;
  const bool backwards_;
  const OneByOneOptions& options_;
  const Deadline& deadline_;
  std::vector<Path> places_;  // by robot
  std::vector<double> own_lengths_;
  std::vector<Path> own_points_;    // along their own paths, by number in the world; empty until needed
  std::vector<JointPath> motions_;  // the robots' own, then others: of those that move
  double goal_weight_{options_.goal_weight};
  std::vector<Known> known_;
  Stage stage_{};
  std::map<std::tuple<std::size_t, std::size_t, signed char, signed char>, bool> places_free_;
  std::map<std::tuple<std::size_t, std::size_t, signed char, signed char, signed char>, bool> direct_free_;
  std::map<std::tuple<std::size_t, std::size_t, signed char>, bool> known_free_;
  std::map<std::pair<State, State>, std::size_t> found_;
  std::set<State> failed_;
  std::optional<search::BestFirstSearch<Node, std::pair<double, std::size_t>>> search_;
  search::ClosedCosts<std::map<State, double>> closed_;
  std::uint64_t attempts_before_{};
  OneByOneWork work_;
};

}  // namespace

OneByOneResult one_by_one(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                          const std::vector<std::vector<Eigen::VectorXd>>& own_paths,
                          const std::vector<const JointPath*>& known, const OneByOneOptions& options,
                          const Deadline& deadline) {
  std::vector<PlacesSearch> searches;
  searches.reserve(2);
  for (const bool backwards : {false, true})
    if (backwards ? options.backwards : options.forwards)
      searches.emplace_back(world, robots, own_paths, known, backwards, options, deadline);
  OneByOneResult result;
  const auto find = [&](PlacesSearch& search, PlacesSearch::Phase phase) {
    if (result.path) return;
    result.path = search.find(phase);
    if (result.path && result.path->length() > options.max_cost) result.path.reset();
  };
  using Phase = PlacesSearch::Phase;
  for (PlacesSearch& search : searches)
    for (const Phase phase : {Phase::directly, Phase::with_retreats}) find(search, phase);
  for (const Phase phase : {Phase::known_by_trees, Phase::in_pairs})
    for (PlacesSearch& search : searches) find(search, phase);
  for (const PlacesSearch& search : searches) {
    result.work.expansions += search.work().expansions;
    result.work.attempts += search.work().attempts;
    result.work.memory += search.work().memory;
  }
  return result;
}

}  // namespace srmp
