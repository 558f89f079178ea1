#include "srmp/multi/safe_interval_search.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/memory_of.hpp"
#include "srmp/search/lazy_tree.hpp"

namespace srmp::multi {

namespace {

using LabelId = std::uint32_t;
constexpr LabelId no_label = std::numeric_limits<LabelId>::max();

/// An arrival at a state, which no arrival before it reaches by waiting there.
struct Label {
  Move move;   // that led here; of the start: a wait of no length
  double g{};  // cost-to-come
  LabelId parent{no_label};
  int until{};  // the last step to which the agent may stay; forever. Known once it is expanded
};

/// A departure from a label, or (edge to the label's own state) the label itself, to be expanded.
struct Departure {
  LabelId label{};
  StateId to{};
  int step{};
  double cost{};  // of the edge
  bool done{};
};

struct PathOfOther {
  std::size_t agent;
  std::vector<Move> moves;
};

/// The graph along paths that are known.
class KnownPaths {
 public:
  void add(std::span<const StateId> states, bool both_ways) {
    for (std::size_t i = 1; i < states.size(); ++i) {
      if (states[i - 1] == states[i]) continue;
      next_[states[i - 1]].insert(states[i]);
      if (both_ways) next_[states[i]].insert(states[i - 1]);
    }
  }
  bool empty() const { return next_.empty(); }
  void successors(Agent& agent, StateId state, std::vector<search::Successor>& out) const {
    const auto found = next_.find(state);
    if (found == next_.end() || agent.is_goal(state)) return;
    for (const StateId next : found->second)
      if (const double cost = agent.evaluate(state, next); cost < search::infinity) out.push_back({next, cost});
  }

 private:
  std::map<StateId, std::set<StateId>> next_;
};

class SafeIntervalSearch {
 public:
  SafeIntervalSearch(World& world, std::size_t agent, std::span<const Constraint> constraints,
                     std::span<const OtherPath> avoid, const SafeIntervalSearchOptions& options)
      : world_(world),
        me_(agent),
        agent_(world.agent(agent)),
        constraints_(constraints),
        options_(options),
        wait_cost_(agent_.wait_cost()) {
    for (const Constraint& constraint : constraints) horizon_ = std::max(horizon_, constraint.end());
    for (const OtherPath& other : avoid) {
      horizon_ = std::max(horizon_, other.path->arrival());
      avoid_.push_back({other.agent, merged_waits(other.path->moves)});
    }
  }

  /// `along`: null: in the whole graph.
  TimedSearchResult run(const KnownPaths* along, const Deadline& deadline) {
    along_ = along;
    const StateId start = agent_.start();
    labels_.push_back({.move = {start, start, 0, 0}});
    by_state_[start].push_back(0);
    add({.label = 0, .to = start, .step = 0, .cost = 0.0});
    while (const std::optional<std::uint32_t> next = select()) {
      if (const auto stop = search::stop_status(deadline)) return ended(*stop);
      const Departure departure = departures_[*next];
      departures_[*next].done = true;
      if (departure.to == labels_[departure.label].move.to) {
        if (expand(departure.label)) return solved(departure.label);
        continue;
      }
      if (statistics_.evaluations == options_.max_evaluations) return ended(Status::timed_out);
      ++statistics_.evaluations;
      leave(departure);
    }
    return ended(search::stop_status(deadline).value_or(Status::exhausted));
  }

  const search::Statistics& statistics() const { return statistics_; }

 private:
  using Entry = std::pair<double, std::uint32_t>;  // key; number: equal keys are first in, first out
  using Queue = std::priority_queue<Entry, std::vector<Entry>, std::greater<>>;

  double to_go(StateId state) {
    const auto [known, added] = to_go_.try_emplace(state, 0.0);
    if (added) {
      known->second = agent_.inadmissible_heuristic(state);
      search::require_estimate(known->second, "inadmissible heuristic", state);
    }
    return known->second;
  }

  void add(const Departure& departure) {
    const Label& label = labels_[departure.label];
    const double waits = wait_cost_ * (departure.step - label.move.end), h = to_go(departure.to);
    if (h == search::infinity) return;
    const auto number = static_cast<std::uint32_t>(departures_.size());
    departures_.push_back(departure);
    const double g = label.g + waits + departure.cost;
    eager_.push({g + options_.weight * h, number});
    patient_.push({g + options_.patient_weight * h, number});
  }

  std::optional<std::uint32_t> select() {
    for (Queue* queue : {&eager_, &patient_})
      while (!queue->empty() && departures_[queue->top().second].done) queue->pop();
    if (eager_.empty()) return std::nullopt;
    eager_turn_ = !eager_turn_;
    return (eager_turn_ ? eager_ : patient_).top().second;
  }

  /// True: the agent may stay here for good, at a goal.
  bool expand(LabelId id) {
    const int until = labels_[id].until = end_of_stay(labels_[id].move.to, labels_[id].move.end);
    const Label label = labels_[id];
    const StateId state = label.move.to;
    if (until == forever && agent_.is_goal(state)) return true;
    ++statistics_.expansions;
    if (until != forever && label.parent != no_label) arrive_after(until, label.parent, label.move);
    successors_.clear();
    along_ ? along_->successors(agent_, state, successors_) : agent_.successors(state, successors_);
    statistics_.generated += successors_.size();
    for (const search::Successor& next : successors_) {
      search::require_edge({state, next.state, next.cost});
      if (next.state != state && !agent_.known_missing(state, next.state))
        add({.label = id, .to = next.state, .step = label.move.end, .cost = next.cost});
    }
    return false;
  }

  /// The same move again, so late that the agent arrives when it could not have waited there since an arrival before.
  void arrive_after(int step, LabelId from, const Move& move) {
    const int duration = move.end - move.start, later = std::max(move.start + 1, step + 1 - duration);
    if (later <= horizon_) try_later({.label = from, .to = move.to, .cost = edge_cost(from, move)}, later);
  }
  double edge_cost(LabelId from, const Move& move) { return agent_.evaluate(labels_[from].move.to, move.to); }

  void try_later(Departure departure, int step) {
    departure.step = step;
    if (step <= labels_[departure.label].until) add(departure);
  }

  void leave(Departure departure) {
    const Label from = labels_[departure.label];
    const StateId state = from.move.to;
    const Move move{state, departure.to, departure.step, departure.step + agent_.duration(state, departure.to)};
    if (const std::optional<int> until = covered(move.to, move.end)) {
      if (*until != forever) arrive_after(*until, departure.label, move);
      return;
    }
    const double cost = agent_.evaluate(state, move.to);
    if (!(cost >= departure.cost - 1e-9 * (1.0 + departure.cost)))
      search::require_evaluation({state, move.to, departure.cost}, cost);
    if (cost == search::infinity) return;
    if (const std::optional<int> later = obstructed_until(move)) {
      if (*later != forever) try_later(departure, *later);
      return;
    }
    const auto id = static_cast<LabelId>(labels_.size());
    labels_.push_back({.move = move,
                       .g = from.g + wait_cost_ * (move.start - from.move.end) + cost,
                       .parent = departure.label,
                       .until = move.end});
    by_state_[move.to].push_back(id);
    add({.label = id, .to = move.to, .step = move.end, .cost = 0.0});
  }

  /// Until when an agent may stay at a state where it arrives at `step`, if an arrival before reaches that by waiting.
  std::optional<int> covered(StateId state, int step) {
    const auto found = by_state_.find(state);
    if (found == by_state_.end()) return std::nullopt;
    for (const LabelId id : found->second) {
      Label& label = labels_[id];
      if (label.move.end > step) continue;
      if (label.move.end >= horizon_) return forever;  // nothing has changed since
      label.until = std::max(label.until, label.move.end);
      if (label.until < step) label.until = end_of_stay(state, label.move.end);
      if (label.until >= step) return label.until;
    }
    return std::nullopt;
  }

  /// The step at which to try again a move that is forbidden: when that which is in its way has ended; none: it is
  /// free.
  std::optional<int> obstructed_until(const Move& move) {
    for (const Constraint& constraint : constraints_)
      if (forbids(world_, constraint, me_, move)) return move.start + 1;
    for (const PathOfOther& other : avoid_)
      for (auto at = first_overlap(other, move.start); at != other.moves.end() && at->start < move.end; ++at)
        if (world_.in_conflict(me_, move, other.agent, *at)) {
          if (at->end != forever) return std::max(move.start + 1, at->end);
          return at->start > move.start ? at->start : forever;
        }
    return std::nullopt;
  }

  static std::vector<Move>::const_iterator first_overlap(const PathOfOther& other, int step) {
    return std::ranges::upper_bound(other.moves, step, {}, &Move::end);
  }

  /// The last step to which the agent may stay at a state from `step` on; forever.
  int end_of_stay(StateId state, int step) {
    const auto known = stays_.find({state, step});
    if (known != stays_.end()) return known->second;
    int end = forever;
    for (const Constraint& constraint : constraints_)
      for (int at = step; at < std::min(end, constraint.end()); ++at)
        if (forbids(world_, constraint, me_, {state, state, at, at + 1})) end = at;
    for (const PathOfOther& other : avoid_)
      for (auto at = first_overlap(other, step); at != other.moves.end() && at->start < end; ++at)
        end = std::min(end, end_of_stay_beside(state, std::max(step, at->start), other.agent, *at));
    return stays_[{state, step}] = end;
  }

  int end_of_stay_beside(StateId state, int from, std::size_t other, const Move& move) {
    if (!world_.in_conflict(me_, {state, state, from, move.end}, other, move)) return forever;
    if (move.waits()) return from;
    for (int step = from; step < move.end; ++step)
      if (world_.in_conflict(me_, {state, state, step, step + 1}, other, move)) return step;
    return from;  // the steps together are not known to be free, so none is taken for free
  }

  TimedSearchResult solved(LabelId id) {
    TimedSearchResult result = ended(Status::solved);
    TimedPath& path = result.path;
    const Label goal = labels_[id];
    path.moves.push_back({goal.move.to, goal.move.to, goal.move.end, forever});
    for (; labels_[id].parent != no_label; id = labels_[id].parent) {
      const Move& move = labels_[id].move;
      path.moves.push_back(move);
      for (int step = move.start; step > labels_[labels_[id].parent].move.end; --step)
        path.moves.push_back({move.from, move.from, step - 1, step});
    }
    std::reverse(path.moves.begin(), path.moves.end());
    path.cost = cost_of(agent_, path.moves);
    return result;
  }

  TimedSearchResult ended(Status status) const {
    TimedSearchResult result;
    result.status = status;
    result.statistics = statistics_;
    result.statistics.memory = memory_of(labels_) + memory_of(departures_) + 2 * departures_.size() * sizeof(Entry) +
                               memory_of(to_go_) + memory_of(by_state_);
    return result;
  }

  World& world_;
  std::size_t me_;
  Agent& agent_;
  std::span<const Constraint> constraints_;
  std::vector<PathOfOther> avoid_;
  SafeIntervalSearchOptions options_;
  double wait_cost_;
  int horizon_{0};  // from which on nothing changes any more
  const KnownPaths* along_{};
  std::vector<Label> labels_;
  std::vector<Departure> departures_;
  Queue eager_, patient_;
  bool eager_turn_{};
  std::unordered_map<StateId, std::vector<LabelId>> by_state_;
  std::unordered_map<StateId, double> to_go_;
  std::map<std::pair<StateId, int>, int> stays_;
  std::vector<search::Successor> successors_;
  search::Statistics statistics_;
};

}  // namespace

TimedSearchResult safe_interval_search(World& world, std::size_t agent, std::span<const Constraint> constraints,
                                       std::span<const OtherPath> avoid, const TimedPath* known,
                                       const SafeIntervalSearchOptions& options, const Deadline& deadline) {
  search::require_weight(options.weight, "safe_interval_search: weight");
  search::require_weight(options.patient_weight, "safe_interval_search: patient_weight");
  KnownPaths paths;
  for (const std::vector<StateId>& states : world.agent(agent).known_paths()) paths.add(states, true);
  if (known) {
    std::vector<StateId> states;
    for (const Move& move : known->moves) states.push_back(move.to);
    if (!known->moves.empty()) states.insert(states.begin(), known->moves.front().from);
    paths.add(states, false);
  }
  TimedSearchResult along;
  if (!paths.empty()) {
    along = SafeIntervalSearch(world, agent, constraints, avoid, options).run(&paths, deadline);
    const bool failed = along.status == Status::exhausted || along.status == Status::timed_out;
    if (!failed || options.known_paths_only) return along;
  }
  SafeIntervalSearchOptions rest = options;
  rest.max_evaluations -= std::min(rest.max_evaluations, along.statistics.evaluations);
  TimedSearchResult result = SafeIntervalSearch(world, agent, constraints, avoid, rest).run(nullptr, deadline);
  result.statistics.evaluations += along.statistics.evaluations;
  result.statistics.expansions += along.statistics.expansions;
  result.statistics.generated += along.statistics.generated;
  return result;
}

}  // namespace srmp::multi
