#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "srmp/core/block_vector.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/core/status.hpp"
#include "srmp/search/lazy_tree.hpp"

/// Best-first search over nodes that the problem makes itself: for problems whose states are not numbered, such as
/// tuples of roadmap vertices, or a vertex and a time. Where states are numbered (graph.hpp), use astar.hpp.
///
/// Papers: Pearl 1984, "Heuristics" (best-first search); lazy checks as in Cohen, Phillips, Likhachev 2014, "Planning
/// Single-Arm Manipulations with N-Arm Robots": a node is checked only when it comes out of OPEN.
/// Guarantee: nodes come out of OPEN in the order of (key, number of the node), so equal keys are first in, first out
/// and the search is deterministic. With the key g + h for a consistent h and costs that the check does not raise, the
/// first goal is optimal; with g + w * h, w >= 1, it costs at most w times the optimum as long as dominance compares
/// costs and states may be closed again at a lower cost (ClosedCosts). `exhausted` means that no node leads to a goal.
namespace srmp::search {

using NodeId = std::uint32_t;
inline constexpr NodeId no_node = std::numeric_limits<NodeId>::max();

struct BestFirstResult {
  Status status{Status::exhausted};  ///< solved, exhausted, timed_out (also when a budget is used up) or cancelled
  NodeId goal{no_node};              ///< of the node that solved it; no_node otherwise
  std::uint64_t expansions{};        ///< nodes expanded
};

/// What a problem tells BestFirstSearch<Node, Key>; it may add nodes to the search in is_valid() and expand().
/// - is_dominated(node): is a state closed that is at least as good, so that the node can be dropped? Cheap.
/// - is_valid(id): the lazy check, called once for each node. False drops it; the problem may add others in its place.
/// - close(node): the node is valid and not dominated.
/// - is_goal(node): may be expensive; called after close().
/// - expand(id): adds the successors.
/// Optional: may_continue(), called before a node is taken from OPEN, and may_expand(expansions), called before a node
/// is expanded with the number of nodes that have come so far, this one included: false ends the search as timed_out.
template <class P, class Node>
concept BestFirstProblem = requires(P& problem, const Node& node, NodeId id) {
  { problem.is_dominated(node) } -> std::convertible_to<bool>;
  { problem.is_valid(id) } -> std::convertible_to<bool>;
  { problem.close(node) } -> std::same_as<void>;
  { problem.is_goal(node) } -> std::convertible_to<bool>;
  { problem.expand(id) } -> std::same_as<void>;
};

/// The nodes of one search, each with its parent, and OPEN. Keys are totally ordered (no NaN), the smallest first.
template <class Node, class Key>
class BestFirstSearch {
 public:
  /// Puts a node into OPEN; its parent is in the search already, or no_node.
  NodeId add(Node node, const Key& key, NodeId parent) {
    nodes_.push_back({std::move(node), parent});
    const auto id = static_cast<NodeId>(nodes_.size() - 1);
    open_.emplace(key, id);
    return id;
  }

  /// References are valid until the next add().
  const Node& operator[](NodeId id) const { return nodes_[id].node; }
  NodeId parent(NodeId id) const { return nodes_[id].parent; }
  std::size_t size() const { return nodes_.size(); }

  /// From the root to `id`.
  std::vector<NodeId> path_to(NodeId id) const {
    std::vector<NodeId> path;
    for (; id != no_node; id = nodes_[id].parent) path.push_back(id);
    std::reverse(path.begin(), path.end());
    return path;
  }

  /// Bytes, without what the nodes hold outside of themselves. OPEN never has more entries than there are nodes.
  std::size_t memory() const { return nodes_.memory() + nodes_.size() * sizeof(Queued); }

  /// Takes nodes from OPEN until there is a goal. `exhausted` is never said once the deadline has passed.
  template <BestFirstProblem<Node> P>
  BestFirstResult run(P& problem, const Deadline& deadline) {
    BestFirstResult result;
    const auto ended = [&](Status status) {
      result.status = status;
      return result;
    };
    while (true) {
      if (const auto stop = stop_status(deadline)) return ended(*stop);
      if (open_.empty()) return ended(Status::exhausted);
      if constexpr (requires { problem.may_continue(); })
        if (!problem.may_continue()) return ended(Status::timed_out);
      const NodeId id = open_.top().second;
      open_.pop();
      if (problem.is_dominated(nodes_[id].node) || !problem.is_valid(id)) continue;
      problem.close(nodes_[id].node);
      if (problem.is_goal(nodes_[id].node)) {
        result.goal = id;
        return ended(Status::solved);
      }
      if constexpr (requires { problem.may_expand(result.expansions); })
        if (!problem.may_expand(result.expansions + 1)) return ended(Status::timed_out);
      ++result.expansions;
      problem.expand(id);
    }
  }

 private:
  struct Entry {
    Node node;
    NodeId parent;
  };
  using Queued = std::pair<Key, NodeId>;

  BlockVector<Entry> nodes_;
  std::priority_queue<Queued, std::vector<Queued>, std::greater<>> open_;
};

/// The lowest cost-to-come at which each state was closed, for dominance by cost. `Map`: a map from states to double.
template <class Map>
class ClosedCosts {
 public:
  using State = typename Map::key_type;

  /// Was the state closed at this cost or less?
  bool dominates(const State& state, double cost) const {
    const auto known = costs_.find(state);
    return known != costs_.end() && known->second <= cost;
  }
  void close(const State& state, double cost) { costs_[state] = cost; }
  const Map& costs() const { return costs_; }

 private:
  Map costs_;
};

}  // namespace srmp::search
