#include "srmp/search/rrt_connect.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/search/lazy_tree.hpp"

namespace srmp::search {

namespace {

/// The same turn by the short way round [rad].
double short_way(double angle) { return angle - 2.0 * M_PI * std::nearbyint(angle / (2.0 * M_PI)); }

}  // namespace

double RandomSequence::next() {
  std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
}

RrtConnect::RrtConnect(RrtSpace space, std::uint64_t sequence) : space_(std::move(space)), random_(sequence << 32) {
  if (!(space_.longest_step > 0.0 && space_.longest_step < infinity))
    throw InvalidArgument("longest_step is " + to_text(space_.longest_step) + ", it must be finite and more than 0");
  const auto& some = space_.starts.empty() ? space_.goals : space_.starts;
  const auto size = static_cast<std::size_t>(some.empty() ? 0 : some.front().size());
  for (const auto* ends : {&space_.starts, &space_.goals})
    for (const Eigen::VectorXd& end : *ends)
      if (static_cast<std::size_t>(end.size()) != size)
        throw InvalidArgument("starts and goals of trees have " + std::to_string(size) + " and " +
                              std::to_string(end.size()) + " components, they must have equally many");
  if (!space_.turns.empty() && space_.turns.size() != size)
    throw InvalidArgument("turns has " + std::to_string(space_.turns.size()) + " entries, it must have " +
                          std::to_string(size) + " or none");
  for (const Eigen::VectorXd& start : space_.starts) add(trees_[0], start, trees_[0].size());
  for (const Eigen::VectorXd& goal : space_.goals) add(trees_[1], goal, trees_[1].size());
}

std::optional<std::vector<Eigen::VectorXd>> RrtConnect::grow(std::uint64_t attempts, const Deadline& deadline) {
  if (space_.starts.empty() || space_.goals.empty()) return std::nullopt;
  while (attempts_ < attempts && !stop_status(deadline)) {
    if (attempts_++ == 0) {
      if (auto way = straight_way()) return way;
      continue;
    }
    const bool backward = trees_[1].size() < trees_[0].size();
    Tree &tree = trees_[backward], &other = trees_[!backward];
    const Eigen::VectorXd q = space_.sample(random_);
    if (extend(tree, nearest(tree, q), q) && connect(other, node(tree, tree.size() - 1))) return path();
  }
  return std::nullopt;
}

std::size_t RrtConnect::memory() const {
  std::size_t sum = 0;
  for (const Tree& tree : trees_) sum += tree.size() * (sizeof(double) * tree.columns.size() + sizeof(std::size_t));
  return sum;
}

Eigen::VectorXd RrtConnect::node(const Tree& tree, std::size_t i) const {
  Eigen::VectorXd q(std::ssize(tree.columns));
  for (std::size_t k = 0; k < tree.columns.size(); ++k) q[static_cast<Eigen::Index>(k)] = tree.columns[k][i];
  return q;
}

void RrtConnect::add(Tree& tree, const Eigen::VectorXd& q, std::size_t parent) {
  tree.columns.resize(static_cast<std::size_t>(q.size()));
  for (Eigen::Index k = 0; k < q.size(); ++k) tree.columns[static_cast<std::size_t>(k)].push_back(q[k]);
  tree.parents.push_back(parent);
}

/// The short way round.
Eigen::VectorXd RrtConnect::difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  Eigen::VectorXd way = b - a;
  for (std::size_t k = 0; k < space_.turns.size(); ++k)
    if (double& angle = way[static_cast<Eigen::Index>(k)]; space_.turns[k]) angle = short_way(angle);
  return way;
}

std::size_t RrtConnect::nearest(const Tree& tree, const Eigen::VectorXd& q) {
  distances_.assign(tree.size(), 0.0);
  for (std::size_t k = 0; k < tree.columns.size(); ++k) {
    const double* column = tree.columns[k].data();
    const double at = q[static_cast<Eigen::Index>(k)];
    const bool turns = !space_.turns.empty() && space_.turns[k];
    for (std::size_t i = 0; i < tree.size(); ++i) {
      const double way = turns ? short_way(column[i] - at) : column[i] - at;
      distances_[i] += way * way;
    }
  }
  return static_cast<std::size_t>(std::min_element(distances_.begin(), distances_.end()) - distances_.begin());
}

/// One step; false where it is not free, or there already.
bool RrtConnect::extend(Tree& tree, std::size_t from, const Eigen::VectorXd& towards) {
  const Eigen::VectorXd a = node(tree, from), way = difference(a, towards);
  const double length = way.norm();
  if (length == 0.0) return false;
  const Eigen::VectorXd b = a + space_.longest_step / length * way;
  const Eigen::VectorXd& to = length > space_.longest_step ? b : towards;
  if (!space_.is_motion_free(a, to)) return false;
  add(tree, to, from);
  return true;
}

/// As many steps as are free; true when q is reached, by the last node.
bool RrtConnect::connect(Tree& tree, const Eigen::VectorXd& q) {
  for (std::size_t at = nearest(tree, q); extend(tree, at, q); at = tree.size() - 1)
    if (node(tree, tree.size() - 1) == q) return true;
  return false;
}

/// From a start to the goal that is nearest, if it is free.
std::optional<std::vector<Eigen::VectorXd>> RrtConnect::straight_way() const {
  double least = infinity;
  std::vector<Eigen::VectorXd> way;
  for (const Eigen::VectorXd& start : space_.starts)
    for (const Eigen::VectorXd& goal : space_.goals)
      if (const double length = difference(start, goal).norm(); length < least) {
        least = length;
        way = {start, goal};
      }
  const double steps = std::max(1.0, std::ceil(least / space_.longest_step));
  const Eigen::VectorXd step = difference(way[0], way[1]) / steps;
  for (double k = 1.0; k < steps; ++k) way.insert(way.end() - 1, way[way.size() - 2] + step);
  for (std::size_t i = 1; i < way.size(); ++i)
    if (!space_.is_motion_free(way[i - 1], way[i])) return std::nullopt;
  return way;
}

/// Through the last nodes of the two trees, which are at one place.
std::vector<Eigen::VectorXd> RrtConnect::path() const {
  const auto to_root = [this](const Tree& tree) {
    std::vector<Eigen::VectorXd> way;
    for (std::size_t k = tree.size() - 1;; k = tree.parents[k]) {
      way.push_back(node(tree, k));
      if (tree.parents[k] == k) return way;
    }
  };
  std::vector<Eigen::VectorXd> way = to_root(trees_[0]);
  const std::vector<Eigen::VectorXd> rest = to_root(trees_[1]);
  std::reverse(way.begin(), way.end());
  way.insert(way.end(), rest.begin() + 1, rest.end());
  return way;
}

}  // namespace srmp::search
