#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/worker_pool.hpp"
#include "srmp/lattice/primitives.hpp"
#include "srmp/lattice/state_table.hpp"
#include "srmp/search/configuration_tree.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

/// Is the straight motion from a to b collision-free, given that `a` is? `worker` says whose scratch memory to use; the
/// result must not depend on it.
using MotionValidator = std::function<bool(std::size_t worker, const Eigen::VectorXd& a, const Eigen::VectorXd& b)>;

/// A goal configuration, within limits, and which of the caller's goals it satisfies.
struct ConnectedGoal {
  Eigen::VectorXd q;
  int goal{};
};

/// Further goal configurations near q, if any; they need not be free. The result must depend on q alone.
using GoalConnection = std::function<std::vector<ConnectedGoal>(const Eigen::VectorXd& q)>;

/// Told what a search does in a lattice, in the thread of the search. Either function may be empty.
struct LatticeObserver {
  /// The edges from q were generated; `to_targets` is Lattice::distance_to_targets.
  std::function<void(const Eigen::VectorXd& q, double to_targets)> expanded{};
  /// The motion was checked.
  std::function<void(const Eigen::VectorXd& from, const Eigen::VectorXd& to, bool free)> evaluated{};
};

/// Weights of Lattice::distances_to_targets for a chain of `dof` joints, three rows: all joints weighted alike;
/// proximal joints weighted more; distal joints weighted more.
RowMatrix distance_weights(std::size_t dof);

/// The implicit graph of a robot's motions: what can be reached from the roots by motion primitives, plus straight
/// connections to the targets. Models search::Graph; all edges are straight joint-space motions, so the reverse of a
/// path is a path too and the same class serves a backward search (roots = goals, targets = start).
///
/// - States lie on a grid around their root (grid unit 1e-4 degree or 1e-6 m, so that any mix of primitives meets
///   exactly); continuous joints wrap. Roots are states 0, 1, …; targets follow.
/// - An edge costs its joint-space length [rad; prismatic joints in m count as they are].
/// - From every state an edge leads to each target within `connection_distance` (analytic expansion: Dolgov et al.
///   2010), and to each of the `waypoints` of paths that are known already, which are roots of grids of their own.
/// - `goal_connection` may add goals during the search (adaptive motion primitives: Cohen et al. 2011): each has one
///   edge, from the state for which it was found, and none leads on. The heuristics know the targets alone, and of
///   these goals only that they are goals. So no cost-to-come of other states changes, and what a search proves holds
///   of the lattice *without* these goals: cost <= bound * the optimum there. The path found may cost less than that
///   optimum; `exhausted` covers these goals too.
class Lattice {
 public:
  /// A resolution that is coarser than the lattice's own: the grid of states whose joints differ from their root's by
  /// multiples of `step`, and the primitives that are used there. No step is rounded: it is a multiple of
  /// three grid units, as axis_primitives makes them.
  struct CoarseLevel {
    Eigen::VectorXd step;  ///< (dof,) [rad or m], > 0
    PrimitiveSet primitives;
  };
  /// Onto a surface on which all roots and targets are. Where a primitive ends, the configuration is moved there; of
  /// those in one cell the first that is found stands for all. So there is no coarser level.
  struct Projection {
    std::function<bool(Eigen::VectorXd& q)> project{};  ///< false: there is none near; empty: nothing is projected
    Eigen::VectorXd cell{};                             ///< (dof,) edge lengths of a cell [rad or m], > 0
  };
  struct Options {
    PrimitiveSet primitives;
    double connection_distance{search::infinity};  ///< [rad], >= 0
    GoalConnection goal_connection{};              ///< may be empty
    std::vector<Eigen::VectorXd> waypoints{};      ///< free configurations that every state is connected with
    std::vector<CoarseLevel> coarser{};            ///< for searches at several resolutions, finer ones first
    Projection projection{};                       ///< onto constraints
    LatticeObserver observer{};                    ///< has no effect on the graph
  };

  /// All roots and targets must be free configurations within limits. Batches of edges are distributed over `workers`.
  Lattice(const RobotModel& robot, std::vector<Eigen::VectorXd> roots, std::vector<Eigen::VectorXd> targets,
          Options options, MotionValidator validator, std::size_t workers = 1)
      : Lattice(robot.joints(), std::move(roots), std::move(targets), std::move(options), std::move(validator),
                workers) {}
  /// The same for any joints, which outlive it.
  Lattice(const std::vector<Joint>& joints, std::vector<Eigen::VectorXd> roots, std::vector<Eigen::VectorXd> targets,
          Options options, MotionValidator validator, std::size_t workers = 1);

  /// Connects the search in this lattice with one from the other end (A*-Connect: Islam, Salzman, Likhachev 2016,
  /// "A*-Connect: Bounded suboptimal bidirectional heuristic search"). `own` gets each state that is expanded; from
  /// there an edge leads to the nearest configuration of `other`, and on to that tree's root, which is one of the
  /// targets. It is a goal of the same kind as those of `goal_connection`. Several lattices with the same roots may
  /// share a tree. Both outlive this.
  void connect_trees(search::ConfigurationTree& own, const search::ConfigurationTree& other);

  // --- search::Graph
  void expanding(search::StateId state, search::StateId parent);
  void successors(search::StateId state, std::vector<search::Successor>& out);
  void evaluate(std::span<const search::Edge> edges, std::span<double> costs);
  bool is_goal(search::StateId state) const { return table_.key(state)[0] < 0; }

  // --- search::MultiResolutionGraph
  std::size_t levels() const { return levels_.size(); }
  bool is_on(search::StateId state, std::size_t level) const;
  void successors(search::StateId state, std::size_t level, std::vector<search::Successor>& out);
  void connections(search::StateId state, std::vector<search::Successor>& out);

  std::vector<search::StateId> starts() const;
  Eigen::VectorXd configuration(search::StateId state) const;
  std::size_t root_count() const { return root_count_; }
  const std::vector<Eigen::VectorXd>& targets() const { return targets_; }
  /// The result of `goal_connection` that a goal stems from; null for other states, targets too.
  const ConnectedGoal* connected_goal(search::StateId state) const;
  /// The number of the target where the path to a goal ends, which is no connected_goal.
  std::size_t target_of(search::StateId goal) const;
  /// Joint-space distance from a state to its nearest target: a consistent heuristic.
  double distance_to_targets(search::StateId state) const;
  /// Joint-space distance from the nearest root: no path to the state is shorter.
  double distance_from_roots(search::StateId state) const;
  /// Several distances to the nearest target by each: Euclidean, weighted by each row of `weights` (n, dof), then the
  /// sum over the joints; `out` has n + 1 entries.
  void distances_to_targets(search::StateId state, const RowMatrix& weights, std::span<double> out) const;
  double distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  std::vector<char> wraps() const;  ///< by joint: is it an angle that wraps around?
  /// The configurations of a path, to the target if it ends in a goal, continuous joints unwrapped so that neighbours
  /// differ by the shortest motion.
  std::vector<Eigen::VectorXd> configurations(std::span<const search::StateId> path) const;
  std::size_t size() const { return table_.size(); }
  std::size_t memory() const;

 private:
  struct Move {
    std::vector<std::int32_t> steps;  // in grid units, one entry per joint
    double cost;
  };
  struct Family {
    PrimitiveUse use;
    std::vector<Move> moves;
  };

  /// Primitives and, of a coarse level, the steps of its grid in grid units.
  struct Level {
    std::vector<Family> families;
    std::vector<std::int32_t> steps;
  };

  void add_level(const PrimitiveSet& primitives, const Eigen::VectorXd& step);
  Family make_family(const PrimitiveFamily& family) const;
  void tell(std::span<const search::Edge> edges, std::span<const double> costs) const;
  void add_goal_connections(search::StateId state, std::vector<search::Successor>& out);
  void add_tree_connection(search::StateId state, std::vector<search::Successor>& out);
  void add_moves(search::StateId state, const Family& family, std::vector<search::Successor>& out);
  void add_move(search::StateId state, const Move& move, std::vector<search::Successor>& out);
  void add_moves_to_targets(search::StateId state, const Move& steps, std::vector<search::Successor>& out);
  search::StateId insert_projected(search::StateId state);  // of scratch_key_; `state` when there is none
  std::vector<std::int32_t> cell() const;                   // of scratch_key_
  double difference(std::size_t joint, double from, double to) const;
  double move_cost(const Move& move) const;
  bool near_an_end(const Eigen::VectorXd& q) const;
  bool apply(search::StateId state, const Move& move);  // into scratch_key_; false when a limit is broken
  void read_configuration(search::StateId state, Eigen::VectorXd& q) const;

  const std::vector<Joint>& joints_;
  std::vector<Eigen::VectorXd> roots_;  // then the waypoints
  std::size_t root_count_;
  std::vector<Eigen::VectorXd> targets_;
  double near_distance_;
  double connection_distance_;
  GoalConnection goal_connection_;
  Projection projection_;
  std::map<std::vector<std::int32_t>, search::StateId> cells_;  // of a projection: who stands for each
  std::map<search::StateId, ConnectedGoal> connected_goals_;
  MotionValidator validator_;
  LatticeObserver observer_;
  search::ConfigurationTree* own_tree_{};
  const search::ConfigurationTree* other_tree_{};
  BlockVector<std::size_t> nodes_;                           // by state: its number in own_tree_
  std::map<search::StateId, std::size_t> tree_connections_;  // goals in other_tree_: their numbers there
  std::size_t expansions_{};                                 // since other_tree_ has nodes
  std::vector<Level> levels_;
  std::vector<double> unit_;  // of the grid, one entry per joint [rad or m]
  StateTable table_;          // key: root number, then grid coordinates; goals: see lattice.cpp
  std::vector<std::int32_t> scratch_key_;
  Move scratch_move_;
  mutable Eigen::VectorXd q_;
  std::vector<std::pair<Eigen::VectorXd, Eigen::VectorXd>> ends_;  // of the motion that each worker checks
  WorkerPool workers_;
};

}  // namespace srmp
