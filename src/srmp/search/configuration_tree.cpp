#include "srmp/search/configuration_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/core/error.hpp"

namespace srmp::search {

std::size_t ConfigurationTree::add_root(const Eigen::VectorXd& q) { return append(q, size(), 0.0); }

std::size_t ConfigurationTree::add(const Eigen::VectorXd& q, std::size_t parent) {
  return append(q, parent, costs_[parent] + distance((*this)[parent], q));
}

std::size_t ConfigurationTree::append(const Eigen::VectorXd& q, std::size_t parent, double cost) {
  if (empty()) components_ = static_cast<std::size_t>(q.size());
  if (static_cast<std::size_t>(q.size()) != components_)
    throw InvalidArgument("the tree's configurations have " + std::to_string(components_) + " components, not " +
                          std::to_string(q.size()));
  const std::size_t in_block = size() % block;
  if (in_block == 0) blocks_.resize(blocks_.size() + components_);
  for (std::size_t k = 0; k < components_; ++k) {
    ComponentBlock& components = blocks_[size() / block * components_ + k];
    std::fill(components.values + in_block, components.values + block, q[static_cast<Eigen::Index>(k)]);
  }
  parents_.push_back(parent);
  costs_.push_back(cost);
  return size() - 1;
}

Eigen::VectorXd ConfigurationTree::operator[](std::size_t i) const {
  Eigen::VectorXd q(static_cast<Eigen::Index>(components_));
  for (std::size_t k = 0; k < components_; ++k) q[static_cast<Eigen::Index>(k)] = component(i, k);
  return q;
}

std::size_t ConfigurationTree::nearest(const Eigen::VectorXd& q) const {
  static const NearestFunction function = nearest_function(default_simd_backend());
  return function({blocks_.data(), (size() + block - 1) / block, components_, wraps_.empty() ? nullptr : wraps_.data()},
                  q.data());
}

std::vector<Eigen::VectorXd> ConfigurationTree::to_root(std::size_t i) const {
  std::vector<Eigen::VectorXd> path{(*this)[i]};
  for (; parents_[i] != i; i = parents_[i]) path.push_back((*this)[parents_[i]]);
  return path;
}

Eigen::VectorXd ConfigurationTree::difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  Eigen::VectorXd result = b - a;
  for (std::size_t k = 0; k < wraps_.size(); ++k)
    if (double& angle = result[static_cast<Eigen::Index>(k)]; wraps_[k]) angle = wrapped(angle);
  return result;
}

double ConfigurationTree::wrapped_component(std::size_t i, std::size_t k) const {
  return !wraps_.empty() && wraps_[k] ? wrapped(component(i, k)) : component(i, k);
}

std::size_t ConfigurationTree::memory() const {
  return sizeof(ComponentBlock) * blocks_.size() + size() * (sizeof(double) + sizeof(std::size_t));
}

/// The smallest and the largest value of a component; angles are wrapped.
std::pair<double, double> ConfigurationTree::range(std::size_t k) const {
  std::pair<double, double> range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < size(); ++i) {
    range.first = std::min(range.first, wrapped_component(i, k));
    range.second = std::max(range.second, wrapped_component(i, k));
  }
  return range;
}

bool ConfigurationTree::projections_overlap(const ConfigurationTree& a, const ConfigurationTree& b,
                                            std::span<const std::size_t> components) {
  if (a.empty() || b.empty() || components.empty()) return false;
  const double count = static_cast<double>(a.size() + b.size());
  const double divisions = std::ceil(std::pow(count, 1.0 / static_cast<double>(components.size())));
  std::vector<std::size_t> boxes_of_a(a.size()), boxes_of_b(b.size());
  for (const std::size_t k : components) {
    const auto range_a = a.range(k), range_b = b.range(k);
    const double low = std::min(range_a.first, range_b.first), high = std::max(range_a.second, range_b.second);
    const double per_unit = high - low > 1e-9 ? divisions / (high - low) : 0.0;
    const auto divide = [&](const ConfigurationTree& tree, std::vector<std::size_t>& boxes) {
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const double division = std::min((tree.wrapped_component(i, k) - low) * per_unit, divisions - 1.0);
        boxes[i] = boxes[i] * static_cast<std::size_t>(divisions) + static_cast<std::size_t>(division);
      }
    };
    divide(a, boxes_of_a);
    divide(b, boxes_of_b);
  }
  std::sort(boxes_of_a.begin(), boxes_of_a.end());
  return std::any_of(boxes_of_b.begin(), boxes_of_b.end(),
                     [&](std::size_t box) { return std::binary_search(boxes_of_a.begin(), boxes_of_a.end(), box); });
}

}  // namespace srmp::search
