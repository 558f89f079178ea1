#include "srmp/multi/timed_search.hpp"

#include <algorithm>
#include <optional>
#include <queue>
#include <string>
#include <unordered_map>
#include <vector>

#include "srmp/core/memory_of.hpp"
#include "srmp/search/lazy_tree.hpp"

namespace srmp::multi {

namespace {

using NodeId = std::uint32_t;
constexpr double rounding = 1e-9;  // relative, by which an edge's cost may be below its lower bound
constexpr NodeId no_node = std::numeric_limits<NodeId>::max();

struct Node {
  Move move;          // that led here; of the start: a wait of no length
  double g{};         // cost to come; a lower bound until evaluated
  double f{};         // g + heuristic
  double inflated{};  // g + low_level_weight * inadmissible heuristic
  int conflicts{};    // conflicts on the path so far; a lower bound until evaluated
  NodeId parent{no_node};
  bool evaluated{};
  bool final{};  // stays at move.to for good
  bool done{};   // out of OPEN
};

struct OtherMoves {
  std::size_t agent;
  std::vector<Move> moves;
};

/// Lowest key first; equal keys are first in, first out.
template <class Key>
class Heap {
 public:
  void push(const Key& key, NodeId node) { heap_.push({key, node}); }
  bool empty() const { return heap_.empty(); }
  const Key& key() const { return heap_.top().first; }
  NodeId top() const { return heap_.top().second; }
  void pop() { heap_.pop(); }
  std::size_t memory() const { return heap_.memory(); }

 private:
  using Entry = std::pair<Key, NodeId>;
  struct Queue : std::priority_queue<Entry, std::vector<Entry>, std::greater<>> {
    std::size_t memory() const { return this->c.capacity() * sizeof(Entry); }
  };
  Queue heap_;
};

class TimedSearch {
 public:
  TimedSearch(World& world, std::size_t agent, std::span<const Constraint> constraints,
              std::span<const OtherPath> avoid, std::span<const OtherPath> others, const TimedSearchOptions& options)
      : world_(world),
        me_(agent),
        agent_(world.agent(agent)),
        constraints_(constraints),
        options_(options),
        wait_cost_(agent_.wait_cost()) {
    if (!(wait_cost_ > 0.0)) refuse("wait_cost is " + to_text(wait_cost_) + ", it must be more than 0");
    for (const Constraint& constraint : constraints) horizon_ = std::max(horizon_, constraint.end());
    add_landmarks();
    for (const auto& paths : {avoid, others})
      for (const OtherPath& other : paths) horizon_ = std::max(horizon_, other.path->arrival());
    for (const OtherPath& other : avoid) avoid_.push_back({other.agent, merged_waits(other.path->moves)});
    for (const OtherPath& other : others) others_.push_back({other.agent, merged_waits(other.path->moves)});
  }

  TimedSearchResult run(const TimedPath* experience, const Deadline& deadline) {
    add_start();
    if (experience && !nodes_.empty()) add_experience(*experience);
    while (const std::optional<NodeId> next = select()) {
      if (const auto stop = search::stop_status(deadline)) return ended(*stop);
      Node& node = nodes_[*next];
      if (!node.evaluated) {
        if (statistics_.evaluations == options_.max_evaluations) return ended(Status::timed_out);
        ++statistics_.evaluations;
        evaluate(*next);
        continue;
      }
      node.done = true;
      if (node.final) return solved(*next);
      expand(*next);
    }
    return ended(search::stop_status(deadline).value_or(Status::exhausted));  // then edges may have been cut short
  }

 private:
  using Key = std::pair<double, double>;

  /// By state and step; from the horizon on, nothing changes any more.
  std::uint64_t state_key(StateId state, int step) const {
    return std::uint64_t{state} << 32 | static_cast<std::uint32_t>(std::min(step, horizon_));
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw InvalidArgument("agent " + std::to_string(me_) + ": " + what);
  }

  static double estimate(double value, std::string_view what, StateId state) {
    search::require_estimate(value, what, state);
    return value;
  }

  double heuristic(StateId state) const { return estimate(agent_.heuristic(state), "heuristic", state); }
  double inadmissible_heuristic(StateId state) const {
    return estimate(agent_.inadmissible_heuristic(state), "inadmissible heuristic", state);
  }

  struct ToGo {
    double cost{};  // a lower bound
    double inadmissible{};
  };
  /// A move that the agent has to make.
  struct Landmark {
    Move move;
    ToGo to_go{};  // of the move and all that follows
  };

  void add_landmarks() {
    for (const Constraint& constraint : constraints_)
      if (constraint.required && constraint.agent == me_) landmarks_.push_back({.move = constraint.move});
    std::ranges::sort(landmarks_, {}, [](const Landmark& landmark) { return landmark.move.start; });
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      Landmark& landmark = landmarks_[i];
      const Move& move = landmark.move;
      const double own = move.waits() ? wait_cost_ : agent_.evaluate(move.from, move.to);
      const ToGo rest = to_go(move.to, i + 1);
      landmark.to_go = {own + rest.cost, own + rest.inadmissible};
    }
  }

  /// From a state on, with the landmark of this number and those after it still to come.
  ToGo to_go(StateId state, std::size_t next) const {
    if (next == landmarks_.size()) return {heuristic(state), inadmissible_heuristic(state)};
    const Landmark& landmark = landmarks_[next];
    const double there = agent_.lower_cost(state, landmark.move.from);
    return {std::max(heuristic(state), there + landmark.to_go.cost), there + landmark.to_go.inadmissible};
  }

  NodeId add(Node node) {
    const StateId state = node.move.to;
    const auto next = std::ranges::lower_bound(landmarks_, node.move.end, {},
                                               [](const Landmark& landmark) { return landmark.move.start; });
    if (next != landmarks_.end() && !node.final &&
        node.move.end + agent_.lower_steps(state, next->move.from) > next->move.start)
      return no_node;  // too late
    const ToGo rest = node.final ? ToGo{} : to_go(state, static_cast<std::size_t>(next - landmarks_.begin()));
    node.f = node.g + rest.cost;
    if (node.f == search::infinity) return no_node;
    node.inflated = node.g + options_.low_level_weight * rest.inadmissible;
    nodes_.push_back(node);
    const auto id = static_cast<NodeId>(nodes_.size() - 1);
    enter(id);
    return id;
  }

  void enter(NodeId id) {
    const Node& node = nodes_[id];
    by_f_.push({node.f, -node.g}, id);
    by_inflated_.push({node.inflated, -node.g}, id);
    waiting_.push({node.inflated, -node.g}, id);
  }

  void add_start() {
    const StateId start = agent_.start();
    add({.move = {start, start, 0, 0}, .evaluated = true});
  }

  void add_experience(const TimedPath& path) {
    NodeId parent = 0;
    for (const Move& move : path.moves) {
      if (move.end == forever) return;
      Node node{.move = move,
                .g = nodes_[parent].g,
                .conflicts = nodes_[parent].conflicts,
                .parent = parent,
                .evaluated = true};
      node.g += move.waits() ? wait_cost_ : agent_.evaluate(move.from, move.to);
      if (forbidden(move)) return;
      node.conflicts += count_conflicts(move);
      parent = add(node);
      if (parent == no_node) return;
    }
  }

  bool forbidden(const Move& move) const {
    for (const Constraint& constraint : constraints_)
      if (forbids(world_, constraint, me_, move)) return true;
    for (const OtherMoves& other : avoid_)
      if (conflicts_with(move, other)) return true;
    return false;
  }

  bool conflicts_with(const Move& move, const OtherMoves& other) const {
    const std::vector<Move>& moves = other.moves;
    auto at = std::ranges::upper_bound(moves, move.start, {}, &Move::end);  // the first that ends later
    for (; at != moves.end() && at->start < move.end; ++at)
      if (world_.in_conflict(me_, move, other.agent, *at)) return true;
    return false;
  }

  int count_conflicts(const Move& move) const {
    int count = 0;
    for (const OtherMoves& other : others_) count += conflicts_with(move, other);
    return count;
  }

  void drop_stale(Heap<Key>& heap, double Node::* value) {
    while (!heap.empty() && (nodes_[heap.top()].done || nodes_[heap.top()].*value != heap.key().first)) heap.pop();
  }

  /// The next node to evaluate or expand; none when OPEN is empty.
  std::optional<NodeId> select() {
    drop_stale(by_f_, &Node::f);
    drop_stale(by_inflated_, &Node::inflated);
    if (by_f_.empty()) return std::nullopt;
    lower_ = std::max(lower_, by_f_.key().first);
    const double limit = options_.focal * by_inflated_.key().first;
    while (!waiting_.empty() && waiting_.key().first <= limit) {
      const NodeId id = waiting_.top();
      focal_.push({nodes_[id].conflicts, waiting_.key()}, id);
      waiting_.pop();
    }
    while (!focal_.empty()) {
      const NodeId id = focal_.top();
      const auto [conflicts, key] = focal_.key();
      focal_.pop();
      Node& node = nodes_[id];
      if (node.done || node.inflated != key.first || node.conflicts != conflicts) continue;
      if (node.inflated > limit) {  // the best key has fallen since it entered the focal list
        waiting_.push(key, id);
        continue;
      }
      if (node.f <= options_.bound * by_f_.key().first) return id;
      waiting_.push(key, id);
      break;
    }
    return by_f_.top();
  }

  void evaluate(NodeId id) {
    Node node = nodes_[id];
    const Node& parent = nodes_[node.parent];
    nodes_[id].evaluated = true;
    const auto drop = [&] { nodes_[id].done = true; };
    if (node.final) {
      if (!can_stay(node.move)) return drop();
      node.conflicts += count_conflicts(node.move);
    } else {
      if (const auto known = best_.find(state_key(node.move.to, node.move.end));
          known != best_.end() && known->second <= node.g)
        return drop();
      if (!node.move.waits()) {
        const double cost = agent_.evaluate(node.move.from, node.move.to), lower = node.g - parent.g;
        if (!(cost >= lower - rounding * (1.0 + lower)))
          search::require_evaluation({node.move.from, node.move.to, lower}, cost);
        if (cost == search::infinity) return drop();
        const double g = std::max(node.g, parent.g + cost);
        node.f += g - node.g;
        node.inflated += g - node.g;
        node.g = g;
      }
      if (forbidden(node.move)) return drop();
      node.conflicts += count_conflicts(node.move);
    }
    node.evaluated = true;
    nodes_[id] = node;
    enter(id);
  }

  bool can_stay(const Move& stay) const {
    for (const Constraint& constraint : constraints_) {
      for (int step = stay.start; step < constraint.end(); ++step)
        if (forbids(world_, constraint, me_, {stay.from, stay.from, step, step + 1})) return false;
    }
    return std::none_of(avoid_.begin(), avoid_.end(),
                        [&](const OtherMoves& other) { return conflicts_with(stay, other); });
  }

  void expand(NodeId id) {
    const Node node = nodes_[id];
    const StateId state = node.move.to;
    const int step = node.move.end;
    double& best = best_.try_emplace(state_key(state, step), search::infinity).first->second;
    if (best <= node.g) return;
    best = node.g;
    ++statistics_.expansions;
    if (agent_.is_goal(state))
      add({.move = {state, state, step, forever},
           .g = node.g,
           .conflicts = node.conflicts,
           .parent = id,
           .final = true});
    if (step < horizon_)
      add({.move = {state, state, step, step + 1},
           .g = node.g + wait_cost_,
           .conflicts = node.conflicts,
           .parent = id});
    successors_.clear();
    agent_.successors(state, successors_);
    statistics_.generated += successors_.size();
    for (const search::Successor& next : successors_) {
      search::require_edge({state, next.state, next.cost});
      if (agent_.known_missing(state, next.state)) continue;
      const int duration = agent_.duration(state, next.state);
      if (duration < 1)
        refuse("the edge from state " + std::to_string(state) + " to " + std::to_string(next.state) + " takes " +
               std::to_string(duration) + " steps, it must be at least 1");
      const int end = step + duration;
      if (const auto known = best_.find(state_key(next.state, end));
          known != best_.end() && known->second <= node.g + next.cost)
        continue;
      add({.move = {state, next.state, step, end}, .g = node.g + next.cost, .conflicts = node.conflicts, .parent = id});
    }
  }

  TimedSearchResult solved(NodeId id) {
    TimedSearchResult result = ended(Status::solved);
    result.path.cost = nodes_[id].g;
    for (; nodes_[id].parent != no_node; id = nodes_[id].parent) result.path.moves.push_back(nodes_[id].move);
    std::reverse(result.path.moves.begin(), result.path.moves.end());
    result.lower = std::min(lower_, result.path.cost);
    return result;
  }

  TimedSearchResult ended(Status status) const {
    TimedSearchResult result;
    result.status = status;
    result.lower = lower_;
    result.statistics = statistics_;
    result.statistics.memory = memory_of(nodes_) + by_f_.memory() + by_inflated_.memory() + waiting_.memory() +
                               focal_.memory() + memory_of(best_);
    return result;
  }

  World& world_;
  std::size_t me_;
  Agent& agent_;
  std::span<const Constraint> constraints_;
  std::vector<OtherMoves> avoid_, others_;
  TimedSearchOptions options_;
  double wait_cost_;
  std::vector<Landmark> landmarks_;  // by time
  int horizon_{0};
  std::vector<Node> nodes_;
  Heap<Key> by_f_, by_inflated_, waiting_;
  Heap<std::pair<int, Key>> focal_;
  std::unordered_map<std::uint64_t, double> best_;  // cost to come at the last expansion
  std::vector<search::Successor> successors_;
  double lower_{0.0};
  search::Statistics statistics_;
};

}  // namespace

std::vector<Move> merged_waits(const std::vector<Move>& moves) {
  std::vector<Move> merged;
  for (const Move& move : moves) {
    if (!merged.empty() && merged.back().waits() && move.waits())
      merged.back().end = move.end;
    else
      merged.push_back(move);
  }
  return merged;
}

TimedSearchResult timed_search(World& world, std::size_t agent, std::span<const Constraint> constraints,
                               std::span<const OtherPath> avoid, std::span<const OtherPath> others,
                               const TimedPath* experience, const TimedSearchOptions& options,
                               const Deadline& deadline) {
  search::require_weight(options.low_level_weight, "timed_search: low_level_weight");
  search::require_weight(options.focal, "timed_search: focal");
  if (!(options.bound >= 1.0)) search::require_weight(options.bound, "timed_search: bound");
  return TimedSearch(world, agent, constraints, avoid, others, options).run(experience, deadline);
}

}  // namespace srmp::multi
