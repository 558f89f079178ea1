#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "srmp/search/graph.hpp"

/// Multi-agent path finding (MAPF: Stern et al. 2019) in discrete time. Nothing here knows what a robot is; everything
/// here is tested on grids.
namespace srmp::multi {

using search::StateId;

inline constexpr int forever = std::numeric_limits<int>::max();

/// What an agent does from one step to a later one: it traverses an edge of its graph, or waits.
struct Move {
  StateId from{search::no_state};
  StateId to{search::no_state};  ///< equal to `from`: it waits
  int start{};                   ///< step at which it leaves `from`
  int end{};                     ///< > start: step at which it arrives at `to`; `forever`: it stays there for good
  bool waits() const { return from == to; }
  bool operator==(const Move&) const = default;
};

/// An agent's consecutive moves from step 0 on; the last is its stay at the goal. Each wait takes one step.
struct TimedPath {
  std::vector<Move> moves;
  double cost{};
  int arrival() const { return moves.back().start; }
};

/// The same moves with consecutive waits merged.
std::vector<Move> merged_waits(const std::vector<Move>& moves);

/// One agent: a graph whose edges take time.
class Agent {
 public:
  virtual ~Agent() = default;
  virtual StateId start() = 0;
  /// Appends the outgoing edges, costs being lower bounds > 0; always the same, in the same order.
  virtual void successors(StateId state, std::vector<search::Successor>& out) = 0;
  /// The edge's true cost, no less than its lower bound but for rounding; infinity when the edge does not exist. May
  /// be called again for the same edge.
  virtual double evaluate(StateId from, StateId to) = 0;
  /// True only if the edge has been evaluated before, and does not exist.
  virtual bool known_missing(StateId, StateId) const { return false; }
  virtual bool is_goal(StateId state) = 0;
  /// A consistent heuristic: a lower bound of the cost-to-go. Infinity: no goal can be reached.
  virtual double heuristic(StateId state) = 0;
  /// A second estimate of the cost-to-go, which may overestimate it and only guides the search (Aine et al. 2016).
  virtual double inadmissible_heuristic(StateId state) { return heuristic(state); }
  /// Steps that the edge takes, > 0.
  virtual int duration(StateId from, StateId to) = 0;
  /// Lower bounds of what any path from one state to another costs, and of the steps that it takes.
  virtual double lower_cost(StateId, StateId) { return 0.0; }
  virtual int lower_steps(StateId, StateId) { return 0; }
  /// The states of paths from start to goal whose edges exist, both ways, where that is known beforehand.
  virtual std::vector<std::vector<StateId>> known_paths() { return {}; }
  /// Cost of waiting for a step, other than for good at the goal; > 0.
  virtual double wait_cost() = 0;
};

/// Of an agent's moves, waits included.
inline double cost_of(Agent& agent, const std::vector<Move>& moves) {
  double cost = 0.0;
  for (const Move& move : moves)
    if (move.end != forever) cost += move.waits() ? agent.wait_cost() : agent.evaluate(move.from, move.to);
  return cost;
}

/// Two moves that collide while both last, so that only one of them may be made.
struct Conflict {
  std::size_t agents[2]{};
  Move moves[2];
  int step{};  ///< the first at which they collide
};

/// All agents, and which of their moves conflict.
class World {
 public:
  virtual ~World() = default;
  virtual std::size_t size() const = 0;
  virtual Agent& agent(std::size_t i) = 0;
  /// False: these two never conflict, whatever they do.
  virtual bool may_conflict(std::size_t a, std::size_t b) const = 0;
  /// Do the agents collide at any time at which both moves last? Called for agents that may conflict only.
  virtual bool in_conflict(std::size_t a, const Move& move_a, std::size_t b, const Move& move_b) = 0;
};

/// The steps [from, to) during which both moves last; empty if from >= to.
inline std::pair<int, int> overlap(const Move& a, const Move& b) {
  return {std::max(a.start, b.start), std::min(a.end, b.end)};
}

/// Splits the solutions in two: those in which an agent does not make a move, and those in which it does (disjoint
/// splitting: Li, Harabor, Stuckey, Felner, Koenig 2019, "Disjoint Splitting for Multi-Agent Path Finding with
/// Conflict-Based Search"). In the latter no other agent makes a move that conflicts with it (avoidance of a step:
/// Shaoul, Veerapaneni, Likhachev, Li 2024). A wait that lasts longer makes each of its steps.
struct Constraint {
  std::size_t agent{};
  Move move;
  bool required{};  ///< false: the agent may not make it
  /// The step from which on it forbids nothing.
  int end() const { return move.end == forever ? move.start + 1 : move.end; }
};

/// Does the constraint forbid `agent` the move? Waits are to be asked for step by step.
inline bool forbids(World& world, const Constraint& constraint, std::size_t agent, const Move& move) {
  const Move& own = constraint.move;
  const auto [first, last] = overlap(own, move);
  if (first >= last) return false;
  if (agent != constraint.agent)
    return constraint.required && world.may_conflict(agent, constraint.agent) &&
           world.in_conflict(agent, move, constraint.agent, own);
  return (move == own) != constraint.required;
}

}  // namespace srmp::multi
