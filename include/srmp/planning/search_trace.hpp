#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace srmp {

/// What searches did, for drawing and for teaching: filled while a TraceScope lives. It holds what the lattices of a
/// robot that is planned alone and the constraint trees of several robots did; RRT-Connect, roadmaps and lattices of
/// several robots as one are not recorded. Joint values are in rad, or m of prismatic joints.
struct SearchTrace {
  /// A state whose edges were generated; a search may expand a state again.
  struct Expansion {
    std::size_t number{};  ///< among the expansions of all lattices, in their order
    Eigen::VectorXd q;     ///< (dof,)
    double to_targets{};   ///< straight joint-space distance to the nearest target: a goal, or the start backward
  };
  /// An edge whose motion was checked.
  struct Edge {
    Eigen::VectorXd from, to;  ///< (dof,)
    bool free{};               ///< whether the straight motion touches nothing
  };
  /// A lattice that was searched.
  struct Lattice {
    std::string robot;                    ///< its name
    std::string name;                     ///< such as "the lattice of 15 degrees from the start"
    std::vector<Expansion> expansions{};  ///< in their order
    std::vector<Edge> edges{};            ///< in the order in which they were checked
  };
  /// A node of a constraint tree that was opened, with its earliest conflict.
  struct ConstraintNode {
    std::size_t tree{};      ///< number of the search that it belongs to
    std::uint64_t number{};  ///< within the tree; 0 is the root
    std::uint64_t parent{};  ///< its number; 0 of the root
    double cost{};           ///< sum over the robots, as the search counts it [rad, prismatic joints m, waits]
    int conflicts{};         ///< pairs of robots that collide; 0: a solution
    std::array<std::string, 2> robots{};              ///< of the earliest conflict; "" without any
    std::array<Eigen::VectorXd, 2> configurations{};  ///< of these robots at the step in which they first collide
    double time_s{};                                  ///< when, at full speed [s]
  };

  std::vector<Lattice> lattices;                 ///< in the order in which their searches began
  std::vector<ConstraintNode> constraint_nodes;  ///< of all trees, in the order in which they were opened
  std::size_t constraint_trees{};                ///< number of the trees
  std::size_t expansions{};                      ///< of all lattices, also those that were not kept
  std::size_t max_records{1'000'000};  ///< expansions, edges and nodes together; further ones are counted, not kept
  std::size_t records{};               ///< of these, counted
};

/// While it lives, plans of the thread that made it are recorded. Planning is the same with and without: the same
/// paths, bit for bit. Scopes nest; the innermost records.
class TraceScope {
 public:
  explicit TraceScope(SearchTrace& trace);
  ~TraceScope();
  TraceScope(const TraceScope&) = delete;
  TraceScope& operator=(const TraceScope&) = delete;

  /// Of this thread; null: nothing is recorded.
  static SearchTrace* current();

 private:
  SearchTrace* outer_;
};

}  // namespace srmp
