#include "srmp/search/rrt_connect.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "srmp/search/lazy_tree.hpp"

namespace srmp::search {

namespace {

/// Of steps that are projected onto a constraint: with less, trees creep on; with more, they end where surfaces bend.
struct ProjectionOptions {
  double min_progress{0.1};  ///< towards the sample, of the step's length
  double min_step{0.05};     ///< of RrtSpace::max_step
};
const ProjectionOptions projection;

/// Of growth in directions.
struct DirectionOptions {
  std::uint64_t patience{32};  ///< samples that fail before it; twice as many after all directions were tried
  std::size_t at_once{2};      ///< directions, in turn: with more, trees that need none of them are slower
  int steps{8};                ///< in one direction, at most
};
const DirectionOptions direction_options;

constexpr std::size_t max_ahead = 16, min_ahead = 4;  // attempts whose steps are checked together
constexpr std::size_t failures_before = 16;           // in a row: less and it takes longer than it saves
constexpr std::uint64_t attempts_per_look = 8;        // at the clock, which takes as long as some attempts

}  // namespace

double RandomSequence::next() {
  std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
}

RrtConnect::RrtConnect(RrtSpace space, std::uint64_t seed) : space_(std::move(space)), random_(seed << 32) {
  if (!(space_.max_step > 0.0 && space_.max_step < infinity))
    throw InvalidArgument("max_step is " + to_text(space_.max_step) + ", it must be finite and more than 0");
  const auto& some = space_.starts.empty() ? space_.goals : space_.starts;
  const auto size = static_cast<std::size_t>(some.empty() ? 0 : some.front().size());
  for (const auto* ends : {&space_.starts, &space_.goals})
    for (const Eigen::VectorXd& end : *ends)
      if (static_cast<std::size_t>(end.size()) != size)
        throw InvalidArgument("starts and goals have " + std::to_string(size) + " and " + std::to_string(end.size()) +
                              " components, they must have equally many");
  if (!space_.wraps.empty() && space_.wraps.size() != size)
    throw InvalidArgument("wraps has " + std::to_string(space_.wraps.size()) + " entries, it must have " +
                          std::to_string(size) + " or none");
  for (Tree& tree : trees_) tree = {ConfigurationTree(space_.wraps), 0, direction_options.patience, 0};
  for (const Eigen::VectorXd& start : space_.starts) trees_[0].nodes.add_root(start);
  for (const Eigen::VectorXd& goal : space_.goals) trees_[1].nodes.add_root(goal);
}

std::optional<std::vector<Eigen::VectorXd>> RrtConnect::grow(std::uint64_t attempts, const Deadline& deadline) {
  if (space_.starts.empty() || space_.goals.empty()) return std::nullopt;
  const std::uint64_t first = attempts_;
  const auto must_stop = [&] { return (attempts_ - first) % attempts_per_look == 0 && stop_status(deadline); };
  while (attempts_ < attempts && !must_stop()) {
    if (attempts_++ == 0) {
      if (auto path = straight_path()) return path;
      continue;
    }
    const bool backward = trees_[1].nodes.size() < trees_[0].nodes.size();
    Tree &tree = trees_[backward], &other = trees_[!backward];
    const Attempt& attempt = next_attempt(tree);
    ++failures_;
    if (grows_in_directions(tree)) {
      if (grow_in_directions(tree, attempt.nearest, other)) return path();
    } else if (attempt.collides) {
      space_.on_colliding();
      ++tree.failures;
    } else if (extend(tree, attempt.nearest, attempt.sample)) {
      failures_ = 0;
      tree.failures = 0;
      tree.patience = direction_options.patience;
      if (connect(other, tree.nodes.back())) return path();
    } else {
      ++tree.failures;
    }
  }
  return std::nullopt;
}

/// Samples are drawn ahead of their attempts, the more the more attempts have failed: until a tree changes, it is known
/// from where the next ones start, and the ends of their steps are looked at together.
const RrtConnect::Attempt& RrtConnect::next_attempt(const Tree& tree) {
  if (next_ == ahead_.size()) {
    const bool alone = !space_.find_colliding || space_.project || failures_ < failures_before;
    const std::size_t count = alone ? 1 : std::min<std::size_t>(failures_ / 2, max_ahead);
    ahead_.clear();
    next_ = 0;
    while (ahead_.size() < count) ahead_.push_back({.sample = space_.sample(random_)});
    look_ahead(tree);
  } else if (size() != seen_size_) {
    look_ahead(tree);
  }
  return ahead_[next_++];
}

void RrtConnect::look_ahead(const Tree& tree) {
  const std::span attempts = std::span(ahead_).subspan(next_);
  for (Attempt& attempt : attempts) {
    attempt.nearest = tree.nodes.nearest(attempt.sample);
    attempt.collides = false;
  }
  seen_size_ = size();
  if (attempts.size() < min_ahead) return;
  RowMatrix ends(static_cast<Eigen::Index>(attempts.size()), attempts.front().sample.size());
  for (std::size_t i = 0; i < attempts.size(); ++i)
    ends.row(static_cast<Eigen::Index>(i)) = step_end(tree, attempts[i].nearest, attempts[i].sample).transpose();
  std::array<bool, max_ahead> colliding{};
  space_.find_colliding(ends, std::span(colliding).first(attempts.size()));
  for (std::size_t i = 0; i < attempts.size(); ++i) attempts[i].collides = colliding[i];
}

void RrtConnect::follow(const std::vector<Eigen::VectorXd>& path, const Deadline& deadline) {
  if (path.empty()) throw InvalidArgument("the path to follow has no configurations, it must have at least one");
  if (space_.starts.empty() || space_.goals.empty()) return;
  for (const Eigen::VectorXd& q : path)
    if (q.size() != space_.starts.front().size())
      throw InvalidArgument("the path to follow has configurations of " + std::to_string(q.size()) +
                            " components, starts and goals have " + std::to_string(space_.starts.front().size()));
  follow(trees_[0], path, deadline);
  follow(trees_[1], {path.rbegin(), path.rend()}, deadline);
}

void RrtConnect::follow(Tree& tree, const std::vector<Eigen::VectorXd>& path, const Deadline& deadline) {
  std::size_t at = tree.nodes.nearest(path.front());
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (deadline.stop_requested() || !space_.is_motion_free(tree.nodes[at], path[i])) return;
    at = tree.nodes.add(path[i], at);
  }
}

std::size_t RrtConnect::memory() const {
  std::size_t sum = 0;
  for (const Tree& tree : trees_) sum += tree.nodes.memory();
  return sum;
}

/// Where a step towards a configuration ends.
Eigen::VectorXd RrtConnect::step_end(const Tree& tree, std::size_t from, const Eigen::VectorXd& towards) const {
  const Eigen::VectorXd a = tree.nodes[from], motion = tree.nodes.difference(a, towards);
  const double length = motion.norm();
  if (length > space_.max_step) return a + space_.max_step / length * motion;
  return towards;
}

/// One step towards a configuration; false if it is not free, or if `from` is there already.
bool RrtConnect::extend(Tree& tree, std::size_t from, const Eigen::VectorXd& towards) {
  const Eigen::VectorXd a = tree.nodes[from], motion = tree.nodes.difference(a, towards);
  const double length = motion.norm();
  if (length == 0.0) return false;
  const Eigen::VectorXd b = a + space_.max_step / length * motion;
  const Eigen::VectorXd& to = length > space_.max_step ? b : towards;
  if (space_.project) return extend_projected(tree, from, to, towards);
  if (!space_.is_motion_free(a, to)) return false;
  tree.nodes.add(to, from);
  return true;
}

/// The same where the step is projected: it has to come nearer by a part of it.
bool RrtConnect::extend_projected(Tree& tree, std::size_t from, Eigen::VectorXd to, const Eigen::VectorXd& towards) {
  const Eigen::VectorXd a = tree.nodes[from];
  const double length = tree.nodes.distance(a, towards);
  const bool arrives = length <= space_.max_step;
  const bool on_surface = arrives && space_.is_motion_free(a, towards);  // nodes of the other tree are
  if (!on_surface) {
    if (!space_.project(to) ||
        tree.nodes.distance(to, towards) > length - projection.min_progress * tree.nodes.distance(a, to) ||
        tree.nodes.distance(a, to) < projection.min_step * space_.max_step || !space_.is_motion_free(a, to))
      return false;
  }
  tree.nodes.add(to, from);
  return true;
}

bool RrtConnect::grows_in_directions(const Tree& tree) const {
  return space_.advance && !space_.project && tree.failures >= tree.patience;
}

/// As far as is free in the next directions; true when one of the ends connects the trees.
bool RrtConnect::grow_in_directions(Tree& tree, std::size_t from, Tree& other) {
  tree.failures = 0;
  for (std::size_t i = 0; i < std::min(direction_options.at_once, space_.directions); ++i) {
    const std::size_t direction = tree.next_direction++;
    if (tree.next_direction == space_.directions) {
      tree.next_direction = 0;
      tree.patience *= 2;
    }
    std::size_t at = from;
    for (int step = 0; step < direction_options.steps; ++step) {
      const Eigen::VectorXd a = tree.nodes[at];
      Eigen::VectorXd b = a;
      if (!space_.advance(b, direction) || !space_.is_motion_free(a, b)) break;
      at = tree.nodes.add(b, at);
    }
    if (at != from && connect(other, tree.nodes[at])) return true;
  }
  return false;
}

/// Steps towards q until one is not free; true when the last node is q.
bool RrtConnect::connect(Tree& tree, const Eigen::VectorXd& q) {
  for (std::size_t at = tree.nodes.nearest(q); extend(tree, at, q); at = tree.nodes.size() - 1)
    if (tree.nodes.back() == q) return true;
  return false;
}

/// From the nearest pair of start and goal, if it is free.
std::optional<std::vector<Eigen::VectorXd>> RrtConnect::straight_path() const {
  double least = infinity;
  std::vector<Eigen::VectorXd> path;
  for (const Eigen::VectorXd& start : space_.starts)
    for (const Eigen::VectorXd& goal : space_.goals)
      if (const double length = trees_[0].nodes.distance(start, goal); length < least) {
        least = length;
        path = {start, goal};
      }
  const double steps = std::max(1.0, std::ceil(least / space_.max_step));
  const Eigen::VectorXd step = trees_[0].nodes.difference(path[0], path[1]) / steps;
  for (double k = 1.0; k < steps; ++k) path.insert(path.end() - 1, path[path.size() - 2] + step);
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!space_.is_motion_free(path[i - 1], path[i])) return std::nullopt;
  return path;
}

/// Through the last nodes of the two trees, which are the same configuration.
std::vector<Eigen::VectorXd> RrtConnect::path() const {
  const auto to_root = [](const Tree& tree) { return tree.nodes.to_root(tree.nodes.size() - 1); };
  std::vector<Eigen::VectorXd> path = to_root(trees_[0]);
  const std::vector<Eigen::VectorXd> to_goal = to_root(trees_[1]);
  std::reverse(path.begin(), path.end());
  path.insert(path.end(), to_goal.begin() + 1, to_goal.end());
  return path;
}

}  // namespace srmp::search
