#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/timed_search.hpp"
#include "srmp/multi/world.hpp"

namespace srmp::multi {

/// A node of the constraint tree that was put into OPEN.
struct OpenedNode {
  std::uint64_t number{};  ///< 0: the root
  std::uint64_t parent{};
  double cost{};
  std::size_t conflicts{};        ///< pairs of agents whose paths conflict
  std::optional<Conflict> first;  ///< the one that is resolved next; none without conflicts
};
using OnOpenedNode = std::function<void(const OpenedNode& node)>;

/// The defaults make it CBS (optimal); low_focal and high_focal make it ECBS, and experience with it xECBS.
struct ConflictSearchOptions {
  double low_level_weight{1.0};  ///< of every agent's inadmissible heuristic, >= 1
  double low_focal{1.0};         ///< focal bound of the agents' searches, >= 1
  double high_focal{1.0};        ///< focal bound of the constraint tree, >= 1
  bool experience{false};        ///< an agent's search reuses what is still valid of its last path
  /// Nodes that are taken for their few conflicts have children in which one agent gives way to all of the other's
  /// path (priorities: Ma, Harabor, Stuckey, Li, Koenig 2019), by safe_interval_search. Where it cannot, the other one
  /// first leads around its start (Čáp, Novák, Kleiner, Selecký 2015), or waits for a while. They find paths earlier
  /// and have no effect on the bound: the two children that lose no solution are opened when a node is taken for its
  /// lower bound (constraints of any kind beside complete ones: Shaoul, Veerapaneni, Likhachev, Li 2024).
  bool priorities{false};
  bool priorities_only{false};   ///< no complete children, so nothing is proved
  bool known_paths_only{false};  ///< the same, and all agents move along paths that are known already
  int delay{8};                  ///< with priorities: steps of that wait
  /// Moves evaluated by the search of an agent that gives way, after which the child is dropped.
  std::uint64_t max_priority_evaluations{20'000};
  /// Moves evaluated by all searches together, after which the result is timed_out.
  std::uint64_t max_evaluations{std::numeric_limits<std::uint64_t>::max()};

  /// > 0: every so many nodes one is expanded for its lower bound rather than for few conflicts. Smaller raises the
  /// bound earlier, larger resolves conflicts earlier.
  std::uint64_t lower_bound_period{4};

  OnOpenedNode on_opened{};  ///< told of every node; has no effect on the search

  /// cost <= bound() * optimum of the agents' graphs.
  double bound() const;
};

struct ConflictSearchStatistics {
  std::uint64_t tree_nodes{};  ///< of the constraint tree
  search::Statistics low;      ///< of all agents' searches
  std::uint64_t memory{};      ///< peak bytes of the tree and an agent's search together
};

inline constexpr std::size_t no_agent = std::numeric_limits<std::size_t>::max();

struct ConflictSearchResult {
  Status status{Status::exhausted};
  std::vector<TimedPath> paths;       ///< one per agent; empty unless solved
  double cost{search::infinity};      ///< sum over the agents
  double lower{};                     ///< no solution costs less
  std::size_t stuck_agent{no_agent};  ///< exhausted: whose graph alone holds no path; no_agent: each holds one
  ConflictSearchStatistics statistics;
};

/// Conflict-based search (Sharon, Stern, Felner, Sturtevant 2015, "Conflict-based search for optimal multi-agent
/// pathfinding") with focal lists on both levels (Barer, Sharon, Stern, Felner 2014, "Suboptimal variants of the
/// conflict-based search algorithm for the multi-agent pathfinding problem"). Guarantee: the sum of costs is at most
/// options.bound() times the optimum. Deterministic: ties are broken by node number. Throws InvalidArgument for options
/// out of range and for agents that break their contract.
///
/// Exhausted: an agent has no path to its goal at all, or none under the constraints of any node. A world that holds a
/// path for each agent but none for all together may be searched without end.
ConflictSearchResult conflict_search(World& world, const ConflictSearchOptions& options, const Deadline& deadline);

/// The first conflict of two paths, by step, and how many pairs of their moves conflict.
struct PathConflicts {
  int count{};
  Conflict first;
};
PathConflicts conflicts_of(World& world, const OtherPath& a, const OtherPath& b);

}  // namespace srmp::multi
