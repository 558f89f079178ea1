#include "srmp/core/low_discrepancy.hpp"

#include <array>
#include <cmath>

namespace srmp {

namespace {

/// The solution of x^(dimension + 1) = x + 1, by Newton's method.
double ratio_of(Eigen::Index dimension) {
  double ratio = 2.0;
  for (int step = 0; step < 64; ++step) {
    double power = 1.0;
    for (Eigen::Index i = 0; i < dimension; ++i) power *= ratio;
    ratio -= (power * ratio - ratio - 1.0) / (static_cast<double>(dimension + 1) * power - 1.0);
  }
  return ratio;
}

/// The same; solved once for the dimensions that robots have.
double known_ratio(Eigen::Index dimension) {
  static const auto known = [] {
    std::array<double, 33> ratios{};  // by dimension
    for (std::size_t i = 1; i < ratios.size(); ++i) ratios[i] = ratio_of(static_cast<Eigen::Index>(i));
    return ratios;
  }();
  return dimension < std::ssize(known) ? known[static_cast<std::size_t>(dimension)] : ratio_of(dimension);
}

}  // namespace

Eigen::VectorXd low_discrepancy_point(std::size_t index, Eigen::Index dimension) {
  const double ratio = known_ratio(dimension);
  Eigen::VectorXd point(dimension);
  double alpha = 1.0;
  for (Eigen::Index i = 0; i < dimension; ++i) {
    alpha /= ratio;
    const double value = 0.5 + alpha * static_cast<double>(index);
    point[i] = value - std::floor(value);
  }
  return point;
}

}  // namespace srmp
