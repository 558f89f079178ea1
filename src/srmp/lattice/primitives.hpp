#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace srmp {

/// Where on the way a family of motion primitives is used.
enum class Use {
  always,
  far,   ///< more than near_distance from the goal
  near,  ///< at most near_distance from the goal
};

/// Motion primitives that belong together: joint moves of one size.
struct PrimitiveFamily {
  std::string name;
  Use use{Use::always};
  std::vector<Eigen::VectorXd> moves;  ///< dof entries each [rad or m]; with every move its opposite
};

/// The moves of a lattice, in the order in which they are tried.
struct PrimitiveSet {
  std::vector<PrimitiveFamily> families;
  double near_distance{0.4};  ///< joint-space distance to the goal [rad, prismatic joints m], >= 0
};

}  // namespace srmp
