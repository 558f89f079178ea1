#pragma once

#include <Eigen/Core>

#include "srmp/core/matrix.hpp"

namespace srmp {

/// A motion of all joints of a checker: between two rows every joint follows the cubic polynomial with their positions
/// and velocities, a straight line if there are no velocities. References outlive the call.
struct CubicMotion {
  const Eigen::VectorXd& times;  ///< n [s], strictly increasing
  ConstRows positions;           ///< n x dof [rad or m]
  ConstRows velocities;          ///< n x dof, or no rows
  /// Where velocities jump at rows: those with which each row is reached, n x dof; `velocities` are those with which it
  /// is left. Null: they are the same.
  const RowMatrix* arrivals{};
};

}  // namespace srmp
