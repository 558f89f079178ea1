#include "srmp/multi/conflict_search.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "srmp/search/lazy_tree.hpp"

namespace srmp::multi {

double ConflictSearchOptions::bound() const {
  return priorities_only ? search::infinity : guide_weight * low_focal * high_focal;
}

namespace {

/// The conflict with the one step of every wait at which the two first meet.
Conflict first_step(World& world, Conflict conflict) {
  const auto [first, last] = overlap(conflict.moves[0], conflict.moves[1]);
  conflict.step = first;
  const Move whole[2]{conflict.moves[0], conflict.moves[1]};
  if (!whole[0].waits() && !whole[1].waits()) return conflict;
  for (int step = first; step < last; ++step) {
    for (const int side : {0, 1})
      if (whole[side].waits()) conflict.moves[side] = {whole[side].from, whole[side].from, step, step + 1};
    conflict.step = step;
    if (world.meet(conflict.agents[0], conflict.moves[0], conflict.agents[1], conflict.moves[1])) break;
  }
  return conflict;
}

}  // namespace

PathConflicts conflicts_of(World& world, const OtherPath& a, const OtherPath& b) {
  PathConflicts found;
  const std::vector<Move> in_a = without_steps(a.path->moves), in_b = without_steps(b.path->moves);
  for (std::size_t i = 0, k = 0; i < in_a.size() && k < in_b.size();) {
    if (world.meet(a.agent, in_a[i], b.agent, in_b[k]) && found.count++ == 0)
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

struct TreeNode {
  std::vector<PathPtr> paths;
  std::vector<double> lower;  // by agent
  std::vector<Constraint> constraints;
  std::set<Pair> ahead;  // (a, b): b gives way to a
  std::map<Pair, PathConflicts> conflicts;
  bool complete{true};  // only children that lose no solution led here
  std::uint64_t number{};

  // Of the above, for the orders of OPEN:
  double cost{}, lower_sum{};
  int meetings{};

  void sum_up() {
    cost = lower_sum = 0.0;
    meetings = 0;
    for (const PathPtr& path : paths) cost += path->cost;
    for (const double l : lower) lower_sum += l;
    for (const auto& [pair, found] : conflicts) meetings += found.count;
  }
};

using NodePtr = std::shared_ptr<TreeNode>;

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

struct ByConflicts {  // the younger first
  bool operator()(const NodePtr& a, const NodePtr& b) const {
    return std::tuple(a->conflicts.size(), a->meetings, a->cost, b->number) <
           std::tuple(b->conflicts.size(), b->meetings, b->cost, a->number);
  }
};

class ConflictSearch {
 public:
  ConflictSearch(World& world, const ConflictSearchOptions& options, const Deadline& deadline)
      : world_(world), options_(options), deadline_(deadline) {}

  ConflictSearchResult run() {
    if (!add_root()) return result_;
    while (!open_.empty()) {
      if (const auto stop = search::stop_status(deadline_)) return ended(*stop);
      if (spent()) return ended(Status::timed_out);
      const NodePtr node = take();
      if (node->conflicts.empty()) return solved(*node);
      if (!branch(*node)) return result_;
    }
    return ended(Status::exhausted);
  }

 private:
  std::uint64_t effort() const { return result_.statistics.low.evaluations; }
  bool spent() const { return effort() >= options_.max_evaluations; }

  void push(NodePtr node) {
    node->number = result_.statistics.tree_nodes++;
    node->sum_up();
    open_.insert(node);
    beyond_.insert(std::move(node));
  }

  /// Takes out of OPEN the node within the bound that has the fewest conflicts; when there is none, and every fourth
  /// time beside priorities, the one of the least lower bound, so that the bound rises.
  NodePtr take() {
    NodePtr node = *open_.begin();
    if (node->complete) lower_ = std::max(lower_, node->lower_sum);  // what no solution costs less than
    const double limit = options_.priorities_only ? search::infinity : options_.bound() * lower_ * (1.0 + 1e-12);
    for (; !beyond_.empty() && (*beyond_.begin())->cost <= limit; beyond_.erase(beyond_.begin()))
      focal_.insert(*beyond_.begin());
    const bool prove = options_.priorities && ++turn_ % 4 == 0;
    if (!focal_.empty() && !prove) node = *focal_.begin();
    open_.erase(node);
    beyond_.erase(node);
    focal_.erase(node);
    return node;
  }

  bool add_root() {
    auto root = std::make_shared<TreeNode>();
    root->paths.resize(world_.size());
    root->lower.assign(world_.size(), 0.0);
    for (std::size_t i = 0; i < world_.size(); ++i) {
      const Status status = replan(*root, i, nullptr, {});
      if (status == Status::solved) continue;
      result_.stuck_agent = i;
      result_ = ended(status);
      return false;
    }
    push(std::move(root));
    return true;
  }

  /// Children of a node with a conflict; false: time is up.
  bool branch(TreeNode& node) {
    const Conflict conflict = choose(node);
    const Pair pair{conflict.agents[0], conflict.agents[1]};
    const bool first_ahead = gives_way(node, pair.second, pair.first);
    const bool second_ahead = gives_way(node, pair.first, pair.second);
    if (first_ahead || second_ahead) return give_way(node, first_ahead ? pair.second : pair.first);
    if (node.complete && !options_.priorities_only)
      for (const int side : {0, 1})
        if (!add_child(node, {conflict, side})) return false;
    if (options_.priorities || options_.priorities_only)
      for (const int side : {0, 1}) {
        auto child = std::make_shared<TreeNode>(node);
        child->complete = false;
        const std::size_t after = conflict.agents[side], before = conflict.agents[1 - side];
        child->ahead.insert({before, after});
        if (!finish(std::move(child), after)) return false;
      }
    return true;
  }

  /// The earliest; of those the one of the first agents.
  static Conflict choose(const TreeNode& node) {
    const auto earlier = [](const auto& a, const auto& b) { return a.second.first.step < b.second.first.step; };
    return std::min_element(node.conflicts.begin(), node.conflicts.end(), earlier)->second.first;
  }

  /// Does `after` give way to `before`, itself or over others?
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

  bool give_way(const TreeNode& node, std::size_t agent) { return finish(std::make_shared<TreeNode>(node), agent); }

  bool add_child(const TreeNode& node, Constraint constraint) {
    auto child = std::make_shared<TreeNode>(node);
    const std::size_t agent = constraint.agent();
    child->constraints.push_back(std::move(constraint));
    return finish(std::move(child), agent);
  }

  /// Replans one agent of a child and opens it, if there is a way; false: time is up.
  bool finish(NodePtr child, std::size_t agent) {
    const std::vector<std::size_t> before = all_ahead_of(*child, agent);
    const PathPtr last = child->paths[agent];
    const Status status = replan(*child, agent, last.get(), before);
    if (const auto stop = search::stop_status(deadline_)) {
      result_ = ended(*stop);
      return false;
    }
    if (spent() && status != Status::solved) {
      result_ = ended(Status::timed_out);
      return false;
    }
    if (status == Status::solved) push(std::move(child));
    return true;
  }

  Status replan(TreeNode& node, std::size_t agent, const TimedPath* last, const std::vector<std::size_t>& before) {
    std::vector<Constraint> mine;
    for (const Constraint& constraint : node.constraints)
      if (constraint.agent() == agent) mine.push_back(constraint);
    std::vector<OtherPath> avoid, others;
    for (std::size_t i = 0; i < world_.size(); ++i) {
      if (i == agent || !node.paths[i] || !world_.may_meet(agent, i)) continue;
      const bool ahead = std::binary_search(before.begin(), before.end(), i);
      (ahead ? avoid : others).push_back({i, node.paths[i].get()});
    }
    TimedSearchOptions options{.bound = options_.guide_weight * options_.low_focal,
                               .guide_weight = options_.guide_weight,
                               .focal = options_.low_focal};
    options.max_evaluations = options_.max_evaluations - std::min(options_.max_evaluations, effort());
    if (!before.empty()) options.max_evaluations = std::min(options.max_evaluations, options_.max_priority_evaluations);
    TimedSearchResult found =
        timed_search(world_, agent, mine, avoid, others, options_.experience ? last : nullptr, options, deadline_);
    search::Statistics& low = result_.statistics.low;
    low.expansions += found.statistics.expansions;
    low.generated += found.statistics.generated;
    low.evaluations += found.statistics.evaluations;
    low.memory = std::max(low.memory, found.statistics.memory);
    if (found.status != Status::solved) return found.status;
    node.lower[agent] = std::max(node.lower[agent], found.lower);
    node.paths[agent] = std::make_shared<const TimedPath>(std::move(found.path));
    find_conflicts(node, agent);
    return Status::solved;
  }

  void find_conflicts(TreeNode& node, std::size_t agent) {
    for (std::size_t i = 0; i < world_.size(); ++i) {
      if (i == agent || !node.paths[i] || !world_.may_meet(agent, i)) continue;
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
  double lower_{0.0};
  std::uint64_t turn_{0};
  ConflictSearchResult result_;
};

}  // namespace

ConflictSearchResult conflict_search(World& world, const ConflictSearchOptions& options, const Deadline& deadline) {
  search::require_weight(options.guide_weight, "conflict_search: guide_weight");
  search::require_weight(options.low_focal, "conflict_search: low_focal");
  search::require_weight(options.high_focal, "conflict_search: high_focal");
  return ConflictSearch(world, options, deadline).run();
}

}  // namespace srmp::multi
