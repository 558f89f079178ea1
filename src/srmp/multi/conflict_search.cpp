#include "srmp/multi/conflict_search.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "srmp/core/memory_of.hpp"
#include "srmp/multi/safe_interval_search.hpp"
#include "srmp/search/lazy_tree.hpp"

namespace srmp::multi {

double ConflictSearchOptions::bound() const {
  return priorities_only || known_paths_only ? search::infinity : low_level_weight * low_focal * high_focal;
}

namespace {

/// The conflict with each wait reduced to the one step at which the agents first collide.
Conflict first_step(World& world, Conflict conflict) {
  const auto [first, last] = overlap(conflict.moves[0], conflict.moves[1]);
  conflict.step = first;
  const Move whole[2]{conflict.moves[0], conflict.moves[1]};
  if (!whole[0].waits() && !whole[1].waits()) return conflict;
  for (int step = first; step < last; ++step) {
    for (const int side : {0, 1})
      if (whole[side].waits()) conflict.moves[side] = {whole[side].from, whole[side].from, step, step + 1};
    conflict.step = step;
    if (world.in_conflict(conflict.agents[0], conflict.moves[0], conflict.agents[1], conflict.moves[1])) break;
  }
  return conflict;
}

}  // namespace

PathConflicts conflicts_of(World& world, const OtherPath& a, const OtherPath& b) {
  PathConflicts found;
  const std::vector<Move> in_a = merged_waits(a.path->moves), in_b = merged_waits(b.path->moves);
  for (std::size_t i = 0, k = 0; i < in_a.size() && k < in_b.size();) {
    if (world.in_conflict(a.agent, in_a[i], b.agent, in_b[k]) && found.count++ == 0)
      found.first = first_step(world, {{a.agent, b.agent}, {in_a[i], in_b[k]}});
    const int end_a = in_a[i].end, end_b = in_b[k].end;
    i += end_a <= end_b;
    k += end_b <= end_a;
  }
  return found;
}

namespace {

using PathPtr = std::shared_ptr<const TimedPath>;
using Pair = std::pair<std::size_t, std::size_t>;  // first < second

/// The constraints of a node: its own, then its parent's.
struct Link {
  Constraint constraint;
  std::shared_ptr<const Link> before;
};

struct TreeNode {
  std::vector<PathPtr> paths;
  std::vector<double> lower;  // by agent
  std::shared_ptr<const Link> constraints;
  std::set<Pair> ahead;  // (a, b): b gives way to a, it has the lower priority
  std::map<Pair, PathConflicts> conflicts;
  bool complete{true};  // no branching on the way here has lost a solution
  std::uint64_t number{};

  // Of the above, for the orders of OPEN:
  double cost{}, lower_sum{};
  int move_conflicts{};

  void sum_up() {
    cost = lower_sum = 0.0;
    move_conflicts = 0;
    for (const PathPtr& path : paths) cost += path->cost;
    for (const double l : lower) lower_sum += l;
    for (const auto& [pair, found] : conflicts) move_conflicts += found.count;
  }
};

using NodePtr = std::shared_ptr<TreeNode>;

/// Bytes of a node in OPEN, without its paths.
std::uint64_t memory_of_node(const TreeNode& node) {
  constexpr std::size_t in_two_sets = 2 * (tree_node_overhead + sizeof(NodePtr));
  return sizeof(TreeNode) + in_two_sets + srmp::memory_of(node.paths) + srmp::memory_of(node.lower) +
         node.ahead.size() * (tree_node_overhead + sizeof(Pair)) + srmp::memory_of(node.conflicts);
}

/// Bytes that a node's descendants keep: its own new path, about as long as any, and its constraint.
std::uint64_t memory_left_by(const TreeNode& node) {
  std::size_t longest = 0;
  for (const PathPtr& path : node.paths) longest = std::max(longest, srmp::memory_of(path->moves));
  return sizeof(TimedPath) + longest + sizeof(Link);
}

struct ByLower {  // complete ones first
  bool operator()(const NodePtr& a, const NodePtr& b) const {
    return std::tuple(!a->complete, a->lower_sum, a->number) < std::tuple(!b->complete, b->lower_sum, b->number);
  }
};

struct ByCost {
  bool operator()(const NodePtr& a, const NodePtr& b) const {
    return std::tuple(a->cost, a->number) < std::tuple(b->cost, b->number);
  }
};

struct ByConflicts {  // ties: the newer first
  bool operator()(const NodePtr& a, const NodePtr& b) const {
    return std::tuple(a->conflicts.size(), a->move_conflicts, a->cost, b->number) <
           std::tuple(b->conflicts.size(), b->move_conflicts, b->cost, a->number);
  }
};

class ConflictSearch {
 public:
  ConflictSearch(World& world, const ConflictSearchOptions& options, const Deadline& deadline)
      : world_(world), options_(options), deadline_(deadline) {}

  ConflictSearchResult run() {
    if (!add_root()) return result_;
    while (true) {
      if (const auto stop = search::stop_status(deadline_)) return ended(*stop);
      if (budget_used_up()) return ended(Status::timed_out);
      if (open_.empty() && focal_.empty() && beyond_.empty()) return ended(Status::exhausted);
      const NodePtr node = take();
      if (node->conflicts.empty()) return solved(*node);
      branch(*node);
    }
  }

 private:
  bool by_priorities() const { return options_.priorities || priorities_only(); }
  bool priorities_only() const { return options_.priorities_only || options_.known_paths_only; }
  std::uint64_t evaluations() const { return result_.statistics.low.evaluations; }
  bool budget_used_up() const { return evaluations() >= options_.max_evaluations; }

  /// Puts a node into OPEN; null: does nothing.
  void push(NodePtr node) {
    if (!node) return;
    const std::uint64_t parent = std::exchange(node->number, result_.statistics.tree_nodes++);
    if (options_.on_opened) tell(*node, parent);
    held_ += memory_of_node(*node) + memory_left_by(*node);
    open_.insert(node);
    beyond_.insert(std::move(node));
  }

  /// Takes out of OPEN the node within the bound that has the fewest conflicts. When there is none, and every
  /// `lower_bound_period`-th time, it takes the one with the least lower bound, the oldest first: so the bound rises,
  /// and no node waits for ever behind others that seem nearly solved.
  NodePtr take() {
    NodePtr node = open_.empty() ? nullptr : *open_.begin();
    if (node && node->complete) lower_ = std::max(lower_, node->lower_sum);  // no solution costs less
    const double limit = priorities_only() ? search::infinity : options_.bound() * lower_ * (1.0 + 1e-12);
    for (; !beyond_.empty() && (*beyond_.begin())->cost <= limit; beyond_.erase(beyond_.begin()))
      focal_.insert(*beyond_.begin());
    const bool optimal = options_.bound() == 1.0 && !by_priorities();  // all of focal_ has the least lower bound
    const bool proves = !optimal && !priorities_only() && ++taken_ % options_.lower_bound_period == 0;
    proves_ = node && (focal_.empty() || proves);
    if (!proves_) node = focal_.empty() ? *beyond_.begin() : *focal_.begin();
    remove(node);
    return node;
  }

  /// With priorities, a complete node is in OPEN twice: for its children by priorities, and for those that prove.
  void remove(const NodePtr& node) {
    const bool twice = by_priorities() && !priorities_only() && node->complete && !node->conflicts.empty();
    if (!twice || proves_) open_.erase(node);
    if (!twice || !proves_) {
      beyond_.erase(node);
      focal_.erase(node);
    }
    if (!open_.contains(node) && !focal_.contains(node) && !beyond_.contains(node)) held_ -= memory_of_node(*node);
  }

  void tell(const TreeNode& node, std::uint64_t parent) const {
    OpenedNode opened{node.number, parent, node.cost, node.conflicts.size(), {}};
    if (!node.conflicts.empty()) opened.first = earliest(node);
    options_.on_opened(opened);
  }

  bool add_root() {
    auto root = std::make_shared<TreeNode>();
    root->paths.resize(world_.size());
    root->lower.assign(world_.size(), 0.0);
    for (std::size_t i = 0; i < world_.size(); ++i) {
      const Status status = replan(*root, i, nullptr, {});
      if (status == Status::solved) continue;
      if (status == Status::exhausted) result_.stuck_agent = i;
      result_ = ended(status);
      return false;
    }
    root->sum_up();
    push(std::move(root));
    return true;
  }

  /// Opens the children of a node with a conflict.
  void branch(const TreeNode& node) {
    const Conflict conflict = earliest(node);
    for (const int side : {0, 1})
      if (gives_way(node, conflict.agents[side], conflict.agents[1 - side]))
        return push(replanned(std::make_shared<TreeNode>(node), conflict.agents[side]));
    if (!by_priorities() || (proves_ && node.complete && !priorities_only()))
      add_constrained(node);
    else
      add_prioritised(node, conflict);
  }

  /// Opens a child for each of the two in which the other one gives way to it; only one where that solves the problem.
  void add_prioritised(const TreeNode& node, const Conflict& conflict) {
    for (const int side : {0, 1}) {
      const std::size_t before = conflict.agents[side], after = conflict.agents[1 - side];
      NodePtr child = prioritised(node, before, after, 0);
      if (!child) child = around_the_start(node, before, after);
      if (!child) child = prioritised(node, before, after, options_.delay);
      const bool solution = child && child->conflicts.empty();
      push(std::move(child));
      if (solution) return;
    }
  }

  /// A child in which `after` gives way to `before`, which waits for so many steps before it does as it did.
  NodePtr prioritised(const TreeNode& node, std::size_t before, std::size_t after, int delay) {
    auto child = std::make_shared<TreeNode>(node);
    child->complete = false;
    child->ahead.insert({before, after});
    if (delay > 0) {
      child->paths[before] = delayed(before, *child->paths[before], delay);
      find_conflicts(*child, before);
      for (const std::size_t other : all_ahead_of(*child, before))
        if (child->conflicts.contains(std::minmax(before, other))) return nullptr;
    }
    return replanned(std::move(child), after);
  }

  /// A child in which `after` gives way to `before`, whose path leads around the start of `after`.
  NodePtr around_the_start(const TreeNode& node, std::size_t before, std::size_t after) {
    auto child = std::make_shared<TreeNode>(node);
    child->complete = false;
    child->ahead.insert({before, after});
    const StateId start = world_.agent(after).start();
    const TimedPath stays{{{start, start, 0, forever}}, 0.0};
    const PathPtr last = child->paths[before];
    const std::vector<std::size_t> ahead = all_ahead_of(*child, before);
    if (replan(*child, before, last.get(), ahead, {after, &stays}) != Status::solved) return nullptr;
    for (const std::size_t other : ahead)
      if (child->conflicts.contains(std::minmax(before, other))) return nullptr;
    return replanned(std::move(child), after);
  }

  PathPtr delayed(std::size_t agent, const TimedPath& path, int delay) {
    TimedPath later;
    const StateId start = path.moves.front().from;
    for (int step = 0; step < delay; ++step) later.moves.push_back({start, start, step, step + 1});
    for (Move move : path.moves) {
      move.start += delay;
      if (move.end != forever) move.end += delay;
      later.moves.push_back(move);
    }
    later.cost = cost_of(world_.agent(agent), later.moves);
    return std::make_shared<const TimedPath>(std::move(later));
  }

  /// The two children of a conflict that together lose no solution; null: there is none.
  struct Split {
    NodePtr children[2];
    int raised{};  // children with a larger lower bound than the node has
  };

  /// Opens the two children that lose no solution; or in place of them the node itself, with paths found for one of
  /// them that have fewer conflicts and are within the node's bounds (bypass: Boyarski, Felner, Sharon, Stern 2015),
  /// but never for a node that was taken to raise the bound.
  void add_constrained(const TreeNode& node) {
    Split split = raises_bound() ? cardinal_split(node) : first_split(node);
    for (const NodePtr& child : split.children)
      if (!proves_ && bypasses(node, child)) {
        child->constraints = node.constraints;
        child->lower = node.lower;
        child->sum_up();
        return push(child);
      }
    for (NodePtr& child : split.children) push(std::move(child));
  }

  /// Is the node branched for the sake of the lower bound, in place of a path?
  bool raises_bound() const { return proves_ || options_.bound() == 1.0; }

  /// By the earliest conflict; one child where that is a bypass.
  Split first_split(const TreeNode& node) {
    Split split;
    for (const bool required : {false, true}) {
      split.children[required] = child_of(node, earliest(node), required);
      if (bypasses(node, split.children[required])) break;
    }
    return split;
  }

  /// By the earliest conflict of those most of whose children have a larger lower bound (cardinal conflicts first:
  /// Boyarski et al. 2015, "ICBS").
  Split cardinal_split(const TreeNode& node) {
    std::vector<const Conflict*> by_step;
    for (const auto& [pair, found] : node.conflicts) by_step.push_back(&found.first);
    std::ranges::stable_sort(by_step, {}, &Conflict::step);
    Split best;
    best.raised = -1;
    for (const Conflict* conflict : by_step) {
      Split split;
      for (const bool required : {false, true}) {
        const NodePtr child = split.children[required] = child_of(node, *conflict, required);
        split.raised += !child || child->lower_sum > node.lower_sum * (1.0 + 1e-12);
      }
      if (split.raised > best.raised) best = std::move(split);
      if (best.raised == 2) break;
    }
    return best;
  }

  /// The child in which one agent of the conflict has to make its move, and all others avoid it, or may not make it.
  NodePtr child_of(const TreeNode& node, const Conflict& conflict, bool required) {
    const int side = side_of_split(conflict);
    const Constraint constraint{conflict.agents[side], conflict.moves[side], required};
    auto child = std::make_shared<TreeNode>(node);
    child->constraints = std::make_shared<const Link>(Link{constraint, node.constraints});
    if (!required) return replanned(std::move(child), constraint.agent);
    for (std::size_t i = 0; i < world_.size() && child; ++i)
      if (i != constraint.agent && breaks(i, *child->paths[i], constraint)) child = replanned(std::move(child), i);
    return child;
  }

  /// The agent that is on the move, if the other one waits: to give way to it says more. Else now the one, now the
  /// other.
  static int side_of_split(const Conflict& conflict) {
    if (conflict.moves[0].waits() != conflict.moves[1].waits()) return conflict.moves[0].waits();
    return static_cast<int>((conflict.agents[0] + conflict.agents[1] + static_cast<std::size_t>(conflict.step) + 1) %
                            2);
  }

  bool breaks(std::size_t agent, const TimedPath& path, const Constraint& constraint) {
    return std::ranges::any_of(merged_waits(path.moves),
                               [&](const Move& move) { return forbids(world_, constraint, agent, move); });
  }

  /// Has the child fewer conflicts than the node, and all its paths within the node's bounds?
  bool bypasses(const TreeNode& node, const NodePtr& child) const {
    if (!child || child->move_conflicts >= node.move_conflicts) return false;
    for (std::size_t i = 0; i < node.paths.size(); ++i)
      if (child->paths[i] != node.paths[i] && child->paths[i]->cost > low_bound() * node.lower[i]) return false;
    return true;
  }

  /// Of several, that of the first agents.
  static const Conflict& earliest(const TreeNode& node) {
    const auto earlier = [](const auto& a, const auto& b) { return a.second.first.step < b.second.first.step; };
    return std::min_element(node.conflicts.begin(), node.conflicts.end(), earlier)->second.first;
  }

  /// Does `after` give way to `before`, directly or through others?
  static bool gives_way(const TreeNode& node, std::size_t after, std::size_t before) {
    const std::vector<std::size_t> all = all_ahead_of(node, after);
    return std::find(all.begin(), all.end(), before) != all.end();
  }

  static std::vector<std::size_t> all_ahead_of(const TreeNode& node, std::size_t agent) {
    std::vector<std::size_t> all{agent};
    for (std::size_t i = 0; i < all.size(); ++i)
      for (const auto& [before, after] : node.ahead)
        if (after == all[i] && std::find(all.begin(), all.end(), before) == all.end()) all.push_back(before);
    all.erase(all.begin());
    std::sort(all.begin(), all.end());
    return all;
  }

  /// The child with a new path for one agent; null: there is none, or the deadline has passed.
  NodePtr replanned(NodePtr child, std::size_t agent) {
    const PathPtr last = child->paths[agent];
    const std::vector<std::size_t> before = all_ahead_of(*child, agent);
    if (replan(*child, agent, last.get(), before) != Status::solved) return nullptr;
    for (const std::size_t other : before)
      if (child->conflicts.contains(std::minmax(agent, other))) return nullptr;
    child->sum_up();
    return child;
  }

  Status replan(TreeNode& node, std::size_t agent, const TimedPath* last, const std::vector<std::size_t>& before,
                const OtherPath& also = {}) {
    std::vector<Constraint> constraints;  // that may forbid the agent a move
    for (const Link* link = node.constraints.get(); link; link = link->before.get()) {
      const Constraint& c = link->constraint;
      if (c.agent == agent || (c.required && world_.may_conflict(agent, c.agent))) constraints.push_back(c);
    }
    std::vector<OtherPath> avoid, others;
    std::vector<std::pair<std::size_t, PathPtr>> way_given{{agent, nullptr}};
    for (std::size_t i = 0; i < world_.size(); ++i) {
      if (i == agent || !node.paths[i] || !world_.may_conflict(agent, i)) continue;
      const bool ahead = std::binary_search(before.begin(), before.end(), i);
      (ahead ? avoid : others).push_back({i, node.paths[i].get()});
      if (ahead) way_given.emplace_back(i, node.paths[i]);
    }
    if (also.path) {
      avoid.push_back(also);
      way_given.emplace_back(also.agent, nullptr);
    }
    if (!avoid.empty() && failed_.contains(way_given)) return Status::exhausted;
    TimedSearchOptions options{
        .bound = low_bound(), .low_level_weight = options_.low_level_weight, .focal = options_.low_focal};
    options.max_evaluations = options_.max_evaluations - std::min(options_.max_evaluations, evaluations());
    if (!avoid.empty()) options.max_evaluations = std::min(options.max_evaluations, options_.max_priority_evaluations);
    const TimedPath* experience = options_.experience ? last : nullptr;
    TimedSearchResult found =
        options_.known_paths_only || (by_priorities() && !avoid.empty())
            ? safe_interval_search(world_, agent, constraints, avoid, experience,
                                   {.weight = options_.low_level_weight,
                                    .known_paths_only = options_.known_paths_only,
                                    .max_evaluations = options.max_evaluations},
                                   deadline_)
            : timed_search(world_, agent, constraints, avoid, others, experience, options, deadline_);
    search::Statistics& low = result_.statistics.low;
    low.expansions += found.statistics.expansions;
    low.generated += found.statistics.generated;
    low.evaluations += found.statistics.evaluations;
    low.memory = std::max(low.memory, found.statistics.memory);
    result_.statistics.memory = std::max(result_.statistics.memory, held_ + found.statistics.memory);
    if (found.status != Status::solved && !avoid.empty()) failed_.insert(std::move(way_given));
    if (found.status != Status::solved) return found.status;
    node.lower[agent] = std::max(node.lower[agent], found.lower);
    node.paths[agent] = std::make_shared<const TimedPath>(std::move(found.path));
    find_conflicts(node, agent);
    return Status::solved;
  }

  /// An agent's path costs at most this times the lower bound that its search found.
  double low_bound() const { return options_.low_level_weight * options_.low_focal; }

  void find_conflicts(TreeNode& node, std::size_t agent) {
    for (std::size_t i = 0; i < world_.size(); ++i) {
      if (i == agent || !node.paths[i] || !world_.may_conflict(agent, i)) continue;
      const Pair pair = std::minmax(agent, i);
      const PathConflicts found = conflicts_of(world_, {pair.first, node.paths[pair.first].get()},
                                               {pair.second, node.paths[pair.second].get()});
      if (found.count > 0)
        node.conflicts[pair] = found;
      else
        node.conflicts.erase(pair);
    }
  }

  ConflictSearchResult solved(const TreeNode& node) {
    ConflictSearchResult result = ended(Status::solved);
    for (const PathPtr& path : node.paths) result.paths.push_back(*path);
    result.cost = node.cost;
    result.lower = std::min(lower_, result.cost);
    return result;
  }

  ConflictSearchResult ended(Status status) {
    ConflictSearchResult result = result_;
    result.status = status;
    result.lower = lower_;
    return result;
  }

  World& world_;
  const ConflictSearchOptions& options_;
  const Deadline& deadline_;
  std::set<NodePtr, ByLower> open_;       // all that are open
  std::set<NodePtr, ByCost> beyond_;      // those whose cost is not known to be within the bound
  std::set<NodePtr, ByConflicts> focal_;  // the others
  /// Agents that found no path on which they give way to these paths (null: to an agent at its start): more constraints
  /// do not help.
  std::set<std::vector<std::pair<std::size_t, PathPtr>>> failed_;
  double lower_{0.0};
  bool proves_{};  // the node was taken for its lower bound
  std::uint64_t taken_{0};
  std::uint64_t held_{0};  // bytes of the tree
  ConflictSearchResult result_;
};

}  // namespace

ConflictSearchResult conflict_search(World& world, const ConflictSearchOptions& options, const Deadline& deadline) {
  search::require_weight(options.low_level_weight, "conflict_search: low_level_weight");
  search::require_weight(options.low_focal, "conflict_search: low_focal");
  search::require_weight(options.high_focal, "conflict_search: high_focal");
  if (options.lower_bound_period == 0)
    throw InvalidArgument("conflict_search: lower_bound_period is 0, it must be at least 1");
  return ConflictSearch(world, options, deadline).run();
}

}  // namespace srmp::multi
