#include "srmp/core/low_discrepancy.hpp"

#include <cmath>

namespace srmp {

Eigen::VectorXd low_discrepancy_point(std::size_t index, Eigen::Index dimension) {
  double ratio = 2.0;  // solves x^(dimension + 1) = x + 1, by Newton's method
  for (int step = 0; step < 64; ++step) {
    double power = 1.0;
    for (Eigen::Index i = 0; i < dimension; ++i) power *= ratio;
    ratio -= (power * ratio - ratio - 1.0) / (static_cast<double>(dimension + 1) * power - 1.0);
  }
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
