#pragma once

#include <cstddef>
#include <vector>

#include "srmp/core/matrix.hpp"

namespace srmp {

/// Paths of one or more robots on one clock: between two rows every robot moves straight, all in the same time; after
/// the last row they are stationary.
struct JointPath {
  std::vector<std::size_t> robots;   ///< indices of the robots in their problem, increasing
  std::vector<double> steps;         ///< n, increasing, from 0: time in steps of any length
  std::vector<RowMatrix> positions;  ///< one a robot, n x its dof [rad or m], continuous joints unwrapped

  std::size_t size() const { return steps.size(); }
  double length(std::size_t i) const;  ///< of robots[i], in joint space [rad, prismatic joints m]
  double length() const;               ///< sum over the robots
};

/// The path of the first robot alone, a step for each segment.
JointPath path_of_one(RowMatrix positions);
/// From its end to its beginning.
JointPath reversed(JointPath path);
/// Where robots[i] is at a step; after the last it is stationary.
Eigen::VectorXd position_at(const JointPath& path, std::size_t i, double step);
/// The steps of all, in order, each once.
std::vector<double> all_steps(const std::vector<const JointPath*>& paths);
/// All on one clock, with rows at the steps of all. No two have a robot in common.
JointPath side_by_side(const std::vector<const JointPath*>& paths);

}  // namespace srmp
