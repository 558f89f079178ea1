#pragma once

#include <Eigen/Core>

namespace srmp {

using ConstVector = Eigen::Ref<const Eigen::VectorXd>;
/// Rows are configurations, waypoints or samples, columns are joints; row-major, as numpy's default, so that Python
/// sees it uncopied.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// Takes any matrix of n rows x dof joints; a column-major one is copied.
using ConstRows = Eigen::Ref<const RowMatrix>;

}  // namespace srmp
