#include "srmp/planner/multi_arm/composite_trees.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/search/lazy_tree.hpp"

namespace srmp {

namespace {
constexpr double longest_step = 1.0;  // over all joints [rad, prismatic joints m]
constexpr double stays = 0.1;         // share of the samples in which an arm is at its start; as many, at its goal
}  // namespace

CompositeTrees::CompositeTrees(const CompositeSpace& space, std::uint64_t sequence)
    : space_(space), random_(sequence << 32) {
  trees_[0].push_back({space_.start(), 0});
  for (const Eigen::VectorXd& target : space_.targets()) trees_[1].push_back({target, trees_[1].size()});
}

std::optional<CoupledPath> CompositeTrees::grow(std::uint64_t attempts, const Deadline& deadline) {
  if (trees_[1].empty()) return std::nullopt;
  while (attempts_ < attempts && !search::stop_status(deadline)) {
    const bool backward = attempts_++ % 2 != 0;
    Tree &tree = trees_[backward], &other = trees_[!backward];
    const Eigen::VectorXd q = sample();
    if (extend(tree, nearest(tree, q), q) && connect(other, tree.back().q)) return path(tree, other, backward);
  }
  return std::nullopt;
}

/// In [0, 1): splitmix64 (Steele, Lea, Flood 2014).
double CompositeTrees::random() {
  std::uint64_t z = random_ += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
}

Eigen::VectorXd CompositeTrees::sample() {
  Eigen::VectorXd q = space_.start();
  for (std::size_t i = 0; i < space_.size(); ++i) {
    const double choice = random();
    if (choice < stays) continue;
    auto part = space_.part(q, i);
    if (choice < 2 * stays && !space_.task(i).anywhere) {
      part = space_.task(i).targets.front();
      continue;
    }
    for (Eigen::Index k = 0; k < part.size(); ++k) {
      const Joint& joint = space_.joints()[static_cast<std::size_t>(space_.first(i) + k)];
      const double lower = std::max(joint.lower, -M_PI), upper = std::min(joint.upper, M_PI);
      part[k] = lower + (upper - lower) * random();
    }
  }
  return q;
}

std::size_t CompositeTrees::nearest(const Tree& tree, const Eigen::VectorXd& q) {
  std::size_t best = 0;
  double least = search::infinity;
  for (std::size_t i = 0; i < tree.size(); ++i)
    if (const double distance = (tree[i].q - q).squaredNorm(); distance < least) {
      least = distance;
      best = i;
    }
  return best;
}

/// One step; false where it is not free, or there already.
bool CompositeTrees::extend(Tree& tree, std::size_t from, const Eigen::VectorXd& towards) {
  const Eigen::VectorXd a = tree[from].q, way = towards - a;
  const double length = way.norm();
  if (length == 0.0) return false;
  Eigen::VectorXd b = length > longest_step ? Eigen::VectorXd(a + longest_step / length * way) : towards;
  if (!space_.is_motion_free(a, b)) return false;
  tree.push_back({std::move(b), from});
  return true;
}

/// As many steps as are free; true when q is reached, by the last node.
bool CompositeTrees::connect(Tree& tree, const Eigen::VectorXd& q) {
  for (std::size_t at = nearest(tree, q); extend(tree, at, q); at = tree.size() - 1)
    if (tree.back().q == q) return true;
  return false;
}

/// Through the last nodes of the two trees, which are at one place.
CoupledPath CompositeTrees::path(const Tree& from, const Tree& to, bool backward) const {
  const auto to_root = [](const Tree& tree) {
    std::vector<Eigen::VectorXd> rows;
    for (std::size_t k = tree.size() - 1;; k = tree[k].parent) {
      rows.push_back(tree[k].q);
      if (tree[k].parent == k) return rows;
    }
  };
  std::vector<Eigen::VectorXd> rows = to_root(from);
  const std::vector<Eigen::VectorXd> rest = to_root(to);
  std::reverse(rows.begin(), rows.end());
  rows.insert(rows.end(), rest.begin() + 1, rest.end());
  if (backward) std::reverse(rows.begin(), rows.end());
  return space_.path(rows);
}

}  // namespace srmp
