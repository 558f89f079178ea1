#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "srmp/search/graph.hpp"

/// Many agents at once, in discrete time. Nothing here knows what a robot is; everything here is tested on grids.
namespace srmp::multi {

using search::StateId;

inline constexpr int forever = std::numeric_limits<int>::max();

/// What an agent does from one step to a later one: it goes along an edge of its graph, or stays where it is.
struct Move {
  StateId from{search::no_state};
  StateId to{search::no_state};  ///< == from: it waits
  int start{};                   ///< step at which it leaves `from`
  int end{};                     ///< > start: step at which it is at `to`; `forever`: at rest for good
  bool waits() const { return from == to; }
  bool operator==(const Move&) const = default;
};

/// An agent's moves one after the other from step 0 on, the last of them its rest at the goal; waits take a step each.
struct TimedPath {
  std::vector<Move> moves;
  double cost{};
  int arrival() const { return moves.back().start; }
};

/// The same way with consecutive waits as one.
std::vector<Move> without_steps(const std::vector<Move>& moves);

/// One agent by itself: a graph whose edges take time.
class Agent {
 public:
  virtual ~Agent() = default;
  virtual StateId start() = 0;
  /// Appends the outgoing edges, costs being lower bounds > 0; always the same, in the same order.
  virtual void successors(StateId state, std::vector<search::Successor>& out) = 0;
  /// The edge's true cost, no less than its lower bound but for rounding; infinity when there is no such edge. May be
  /// asked again.
  virtual double evaluate(StateId from, StateId to) = 0;
  virtual bool is_goal(StateId state) = 0;
  /// A consistent heuristic: never more than the cost of a way to a goal. Infinity: no goal from here.
  virtual double heuristic(StateId state) = 0;
  /// What leads the search; it may overestimate.
  virtual double guide(StateId state) { return heuristic(state); }
  /// Steps that the edge takes, > 0.
  virtual int duration(StateId from, StateId to) = 0;
  /// Of waiting for a step anywhere but at rest in the end; > 0.
  virtual double wait_cost() = 0;
};

/// Two moves that may not both be made: they meet while both last.
struct Conflict {
  std::size_t agents[2]{};
  Move moves[2];
  int step{};  ///< when it begins
};

/// What a conflict forbids one of its two agents.
struct Constraint {
  Conflict conflict;
  int side{};
  std::size_t agent() const { return conflict.agents[side]; }
};

/// The agents together.
class World {
 public:
  virtual ~World() = default;
  virtual std::size_t size() const = 0;
  virtual Agent& agent(std::size_t i) = 0;
  /// False: these two never meet, whatever they do.
  virtual bool may_conflict(std::size_t a, std::size_t b) const = 0;
  /// Do the two meet at any time at which both moves last? Moves of two agents that may meet.
  virtual bool meet(std::size_t a, const Move& move_a, std::size_t b, const Move& move_b) = 0;
  /// Does the constraint forbid its agent's `move`? At least the conflict's own move must be forbidden, and in any
  /// solution what one side's constraint forbids, or what the other's does, must not happen: then no solution is lost.
  /// Nothing is forbidden that begins when both moves of the conflict have ended.
  virtual bool forbids(const Constraint& constraint, const Move& move) const {
    return constraint.conflict.moves[constraint.side] == move;
  }
};

/// Steps at which both moves last: from, to. They may be empty (from >= to).
inline std::pair<int, int> overlap(const Move& a, const Move& b) {
  return {std::max(a.start, b.start), std::min(a.end, b.end)};
}

}  // namespace srmp::multi
