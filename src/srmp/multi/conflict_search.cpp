#include "srmp/multi/conflict_search.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <tuple>

#include "srmp/search/lazy_tree.hpp"

namespace srmp::multi {

double ConflictSearchOptions::bound() const {
  return priorities_only ? search::infinity : guide_weight * low_focal * high_focal;
}

namespace {

/// The conflict with the part of a rest that is a wait of one step: the first in which the two meet.
Conflict first_step(World& world, Conflict conflict) {
  const auto [first, last] = overlap(conflict.moves[0], conflict.moves[1]);
  conflict.step = first;
  if (conflict.moves[0].end != forever && conflict.moves[1].end != forever) return conflict;
  const Move whole[2]{conflict.moves[0], conflict.moves[1]};
  for (int step = first; step < last; ++step) {
    for (const int side : {0, 1})
      if (whole[side].end == forever) conflict.moves[side] = {whole[side].from, whole[side].from, step, step + 1};
    conflict.step = step;
    if (world.meet(conflict.agents[0], conflict.moves[0], conflict.agents[1], conflict.moves[1])) break;
  }
  return conflict;
}

}  // namespace

PathConflicts conflicts_of(World& world, const OtherPath& a, const OtherPath& b) {
  PathConflicts found;
  const auto& in_a = a.path->moves;
  const auto& in_b = b.path->moves;
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
  double cost{};
  bool complete{true};  // only children that lose no solution led here
  std::uint64_t number{};

  int conflict_count() const {
    int count = 0;
    for (const auto& [pair, found] : conflicts) count += found.count;
    return count;
  }
  double lower_sum() const {
    double sum = 0.0;
    for (const double l : lower) sum += l;
    return sum;
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
      const auto at = select();
      std::shared_ptr<TreeNode> node = *at;
      if (node->conflicts.empty()) return solved(*node);
      open_.erase(at);
      if (!branch(*node)) return result_;
    }
    return ended(Status::exhausted);
  }

 private:
  using Open = std::vector<std::shared_ptr<TreeNode>>;

  /// Least sum of the lower bounds of complete nodes that are open: what no solution costs less than.
  double lower_bound() {
    double lower = search::infinity;
    for (const auto& node : open_)
      if (node->complete) lower = std::min(lower, node->lower_sum());
    lower_ = std::max(lower_, lower == search::infinity ? 0.0 : lower);
    return lower_;
  }

  /// From the nodes within the bound the one with the fewest conflicts; every fourth time a complete one, so that the
  /// bound rises.
  Open::iterator select() {
    const double limit = options_.bound() * lower_bound() * (1.0 + 1e-12);
    const bool complete = options_.priorities && ++turn_ % 4 == 0;
    auto best = open_.end();
    const auto rank = [](const TreeNode& node) {
      return std::tuple(node.conflicts.size(), node.conflict_count(), node.cost, -static_cast<double>(node.number));
    };
    for (auto it = open_.begin(); it != open_.end(); ++it) {
      if ((*it)->cost > limit || (complete && !(*it)->complete)) continue;
      if (best == open_.end() || rank(**it) < rank(**best)) best = it;
    }
    if (best != open_.end()) return best;
    const auto by_lower = [](const auto& a, const auto& b) {  // complete ones first
      return std::tuple(!a->complete, a->lower_sum(), a->number) < std::tuple(!b->complete, b->lower_sum(), b->number);
    };
    return std::min_element(open_.begin(), open_.end(), by_lower);
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

  void push(std::shared_ptr<TreeNode> node) {
    node->number = result_.statistics.tree_nodes++;
    open_.push_back(std::move(node));
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
  bool finish(std::shared_ptr<TreeNode> child, std::size_t agent) {
    const std::vector<std::size_t> before = all_ahead_of(*child, agent);
    const PathPtr last = child->paths[agent];
    const Status status = replan(*child, agent, last.get(), before);
    if (const auto stop = search::stop_status(deadline_)) {
      result_ = ended(*stop);
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
    if (!before.empty()) options.max_expansions = options_.max_priority_expansions;
    TimedSearchResult found =
        timed_search(world_, agent, mine, avoid, others, options_.experience ? last : nullptr, options, deadline_);
    search::Statistics& low = result_.statistics.low;
    low.expansions += found.statistics.expansions;
    low.generated += found.statistics.generated;
    low.evaluations += found.statistics.evaluations;
    low.memory = std::max(low.memory, found.statistics.memory);
    if (found.status != Status::solved) return found.status;
    if (node.paths[agent]) node.cost -= node.paths[agent]->cost;
    node.cost += found.path.cost;
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
    result.cost = 0.0;
    for (const PathPtr& path : node.paths) {
      result.paths.push_back(*path);
      result.cost += path->cost;
    }
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
  Open open_;
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
