#include "srmp/search/configuration_tree.hpp"

#include <algorithm>
#include <cmath>

namespace srmp::search {

namespace {

/// The angle wrapped to [-pi, pi] [rad].
double wrapped(double angle) { return angle - 2.0 * M_PI * std::nearbyint(angle / (2.0 * M_PI)); }

}  // namespace

std::size_t ConfigurationTree::add_root(const Eigen::VectorXd& q) { return append(q, size(), 0.0); }

std::size_t ConfigurationTree::add(const Eigen::VectorXd& q, std::size_t parent) {
  return append(q, parent, costs_[parent] + distance((*this)[parent], q));
}

std::size_t ConfigurationTree::append(const Eigen::VectorXd& q, std::size_t parent, double cost) {
  columns_.resize(static_cast<std::size_t>(q.size()));
  for (Eigen::Index k = 0; k < q.size(); ++k) columns_[static_cast<std::size_t>(k)].push_back(q[k]);
  parents_.push_back(parent);
  costs_.push_back(cost);
  return size() - 1;
}

Eigen::VectorXd ConfigurationTree::operator[](std::size_t i) const {
  Eigen::VectorXd q(std::ssize(columns_));
  for (std::size_t k = 0; k < columns_.size(); ++k) q[static_cast<Eigen::Index>(k)] = columns_[k][i];
  return q;
}

std::size_t ConfigurationTree::nearest(const Eigen::VectorXd& q) const {
  distances_.assign(size(), 0.0);
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const double* column = columns_[k].data();
    const double at = q[static_cast<Eigen::Index>(k)];
    const bool wraps = !wraps_.empty() && wraps_[k];
    for (std::size_t i = 0; i < size(); ++i) {
      const double d = wraps ? wrapped(column[i] - at) : column[i] - at;
      distances_[i] += d * d;
    }
  }
  return static_cast<std::size_t>(std::min_element(distances_.begin(), distances_.end()) - distances_.begin());
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

std::size_t ConfigurationTree::memory() const {
  return size() * (sizeof(double) * (columns_.size() + 1) + sizeof(std::size_t));
}

}  // namespace srmp::search
