#pragma once

#include <Eigen/Core>

namespace srmp {

/// A vector argument, such as a configuration; vectors and rows of matrices are passed without a copy where their
/// elements are contiguous.
using ConstVector = Eigen::Ref<const Eigen::VectorXd>;
/// Rows are configurations, waypoints or samples; columns are joints. Row-major as numpy's arrays, so that Python reads
/// it without a copy.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// A matrix argument of shape (n, dof); a column-major matrix is copied.
using ConstRows = Eigen::Ref<const RowMatrix>;

}  // namespace srmp
