#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/timed_search.hpp"
#include "srmp/multi/world.hpp"

namespace srmp::multi {

/// One algorithm, whose settings make it CBS (all as they are: optimal), ECBS (low_focal, high_focal), xECBS (all of
/// it).
struct ConflictSearchOptions {
  double low_level_weight{1.0};  ///< of every agent's guide, >= 1
  double low_focal{1.0};         ///< of the agents' searches, >= 1
  double high_focal{1.0};        ///< of the constraint tree, >= 1
  bool experience{false};        ///< an agent's search begins with what still holds of its last way
  /// Beside the two children that lose no solution, each conflict has two in which one agent gives way to all of the
  /// other's path (constraints of any kind beside complete ones: Shaoul, Veerapaneni, Likhachev, Li 2024; priorities:
  /// Ma, Harabor, Stuckey, Li, Koenig 2019). They find paths sooner and have no say in the bound.
  bool priorities{false};
  bool priorities_only{false};  ///< no complete children: fast, and nothing is proved
  /// Moves looked at by a search that gives way: more, and the child is dropped.
  std::uint64_t max_priority_evaluations{20'000};
  /// Moves looked at by all searches together: more, and the answer is timed_out.
  std::uint64_t max_evaluations{std::numeric_limits<std::uint64_t>::max()};

  /// cost <= bound() * optimum of the agents' graphs.
  double bound() const;
};

struct ConflictSearchStatistics {
  std::uint64_t tree_nodes{};  ///< of the constraint tree
  search::Statistics low;      ///< of all agents' searches
  std::uint64_t memory{};      ///< bytes: the most that the tree and an agent's search took together
};

inline constexpr std::size_t no_agent = std::numeric_limits<std::size_t>::max();

struct ConflictSearchResult {
  Status status{Status::exhausted};
  std::vector<TimedPath> paths;       ///< one an agent; empty unless solved
  double cost{search::infinity};      ///< sum over the agents
  double lower{};                     ///< no solution costs less
  std::size_t stuck_agent{no_agent};  ///< exhausted: whose graph by itself holds no way; no_agent: each holds one
  ConflictSearchStatistics statistics;
};

/// Conflict-based search (Sharon, Stern, Felner, Sturtevant 2015) with focal lists on both levels (Barer, Sharon,
/// Stern, Felner 2014). Sum of costs at most options.bound() times the optimum. Deterministic: ties by number.
///
/// Exhausted: an agent has no way to its goal at all, or no way under the constraints of any node; a world that holds a
/// way for each agent but none for all together may be searched without end.
ConflictSearchResult conflict_search(World& world, const ConflictSearchOptions& options, const Deadline& deadline);

/// The first conflict of two ways, by step; and how many pairs of moves meet.
struct PathConflicts {
  int count{};
  Conflict first;
};
PathConflicts conflicts_of(World& world, const OtherPath& a, const OtherPath& b);

}  // namespace srmp::multi
