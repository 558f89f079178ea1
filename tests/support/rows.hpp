#pragma once

#include <initializer_list>

#include "srmp/core/matrix.hpp"

/// {{1, 2}, {3, 4}} as a matrix.
inline srmp::RowMatrix rows(std::initializer_list<std::initializer_list<double>> values) {
  srmp::RowMatrix m(static_cast<Eigen::Index>(values.size()), static_cast<Eigen::Index>(values.begin()->size()));
  Eigen::Index i = 0;
  for (const auto& row : values) {
    Eigen::Index j = 0;
    for (const double v : row) m(i, j++) = v;
    ++i;
  }
  return m;
}
