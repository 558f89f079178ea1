#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "srmp/search/nearest.hpp"

namespace srmp::search {

/// Configurations, each with the one from which it was reached; the nearest of them to a configuration is found by
/// comparing all. Distances are Euclidean; angles that wrap go by the shorter way.
class ConfigurationTree {
 public:
  /// `wraps`, by component: is it an angle that wraps around [rad]? Empty: none is.
  explicit ConfigurationTree(std::vector<char> wraps = {}) : wraps_(std::move(wraps)) {}

  std::size_t size() const { return parents_.size(); }
  bool empty() const { return parents_.empty(); }
  std::size_t add_root(const Eigen::VectorXd& q);
  std::size_t add(const Eigen::VectorXd& q, std::size_t parent);  ///< the number of the new one
  Eigen::VectorXd operator[](std::size_t i) const;
  Eigen::VectorXd back() const { return (*this)[size() - 1]; }  ///< the newest
  double cost(std::size_t i) const { return costs_[i]; }        ///< length of the way to the root

  /// The first of those that are nearest; there is one.
  std::size_t nearest(const Eigen::VectorXd& q) const;
  /// From number i to its root.
  std::vector<Eigen::VectorXd> to_root(std::size_t i) const;
  /// From a to b.
  Eigen::VectorXd difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  double distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const { return difference(a, b).norm(); }
  std::size_t memory() const;

  /// Do the projections of two trees of one space onto some components overlap? The box around all of them is divided
  /// into about as many boxes as there are configurations; is one of each tree in the same?
  static bool projections_overlap(const ConfigurationTree& a, const ConfigurationTree& b,
                                  std::span<const std::size_t> components);

 private:
  static constexpr std::size_t block = ComponentBlock::size;

  double component(std::size_t i, std::size_t k) const {
    return blocks_[i / block * components_ + k].values[i % block];
  }
  double wrapped_component(std::size_t i, std::size_t k) const;
  std::pair<double, double> range(std::size_t k) const;
  std::size_t append(const Eigen::VectorXd& q, std::size_t parent, double cost);

  std::vector<char> wraps_;
  std::size_t components_{};
  std::vector<ComponentBlock> blocks_;  // a block that is not full is filled up with its last configuration
  std::vector<std::size_t> parents_;    // a root is its own parent
  std::vector<double> costs_;
};

}  // namespace srmp::search
