#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "srmp/core/matrix.hpp"

namespace srmp {

/// A motion: n samples of dof joints. Revolute joints in rad, prismatic ones in m. Values of continuous joints do not
/// jump: they run on past ±pi.
struct Trajectory {
  std::vector<std::string> joint_names;  ///< dof
  RowMatrix positions;                   ///< n x dof [rad or m]
  RowMatrix velocities;                  ///< n x dof [rad/s or m/s]
  RowMatrix accelerations;               ///< n x dof [rad/s^2 or m/s^2]
  Eigen::VectorXd times;                 ///< n [s], starts at 0, strictly increasing
  RowMatrix waypoints;                   ///< m x dof: the checked path; between rows the motion is a straight line

  std::size_t size() const { return static_cast<std::size_t>(positions.rows()); }  ///< samples
  std::size_t dof() const { return joint_names.size(); }
  double duration() const { return times.size() ? times[times.size() - 1] - times[0] : 0.0; }  ///< [s]
  /// Length of the path through the samples: sum of the Euclidean norms of joint differences [rad, prismatic joints m].
  double length() const;
  /// Position at time t [s], linear between samples (so it stays on the checked path, whose corners are samples).
  /// Times outside are moved to the nearest end. Throws InvalidArgument when t is NaN or the trajectory is empty.
  Eigen::VectorXd sample(double t) const;
};

}  // namespace srmp
