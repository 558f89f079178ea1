#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace srmp {

/// Point `index` of a fixed low-discrepancy sequence in the unit cube [0, 1)^dimension (Roberts 2018: additive
/// recurrence on the generalised golden ratio). Uses only + - * /, so it is the same on every machine.
Eigen::VectorXd low_discrepancy_point(std::size_t index, Eigen::Index dimension);

}  // namespace srmp
