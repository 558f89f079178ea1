#include "srmp/search/configuration_tree.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>

#include "srmp/core/error.hpp"

namespace srmp::search {

namespace {

static_assert(FLT_EVAL_METHOD == 0, "wrapped() needs sums that are rounded to double precision");
#ifdef __FAST_MATH__
#error "wrapped() needs sums in the order in which they are written, so no -ffast-math"
#endif

/// Angles wrapped to [-pi, pi] [rad]. Adding and subtracting `rounding` rounds to the nearest whole number, as
/// std::nearbyint does, but several at once; below 2^51 turns.
template <class Angles>
Angles wrapped(const Angles& angles) {
  constexpr double rounding = 0x1.8p52;
  return angles - 2.0 * M_PI * ((angles * (0.5 / M_PI) + rounding) - rounding);
}

}  // namespace

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
  if (in_block == 0) values_.resize(values_.size() + components_ * block);
  for (std::size_t k = 0; k < components_; ++k)
    std::fill_n(values_.begin() + static_cast<std::ptrdiff_t>(place(size(), k)), block - in_block,
                q[static_cast<Eigen::Index>(k)]);
  parents_.push_back(parent);
  costs_.push_back(cost);
  return size() - 1;
}

Eigen::VectorXd ConfigurationTree::operator[](std::size_t i) const {
  Eigen::VectorXd q(static_cast<Eigen::Index>(components_));
  for (std::size_t k = 0; k < components_; ++k) q[static_cast<Eigen::Index>(k)] = values_[place(i, k)];
  return q;
}

std::size_t ConfigurationTree::nearest(const Eigen::VectorXd& q) const {
  using Block = Eigen::Array<double, block, 1>;
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  const double* values = values_.data();
  for (std::size_t first = 0; first < size(); first += block) {
    Block squares = Block::Zero();
    for (std::size_t k = 0; k < components_; ++k, values += block) {
      Block difference = Eigen::Map<const Block>(values) - q[static_cast<Eigen::Index>(k)];
      if (!wraps_.empty() && wraps_[k]) difference = wrapped(difference);
      squares += difference.square();
    }
    if (!(squares.minCoeff() < least)) continue;
    for (std::size_t i = 0; i < block; ++i)
      if (const double square = squares[static_cast<Eigen::Index>(i)]; square < least) {
        least = square;
        best = first + i;
      }
  }
  return best;
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
  return sizeof(double) * values_.size() + size() * (sizeof(double) + sizeof(std::size_t));
}

}  // namespace srmp::search
