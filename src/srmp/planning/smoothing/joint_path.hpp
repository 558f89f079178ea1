#pragma once

#include <optional>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/world.hpp"
#include "srmp/planning/multi_robot_world.hpp"

namespace srmp {

/// Ways of arms side by side: between two rows every arm moves straight, all in the same time; after the last they
/// rest.
struct JointPath {
  std::vector<std::size_t> arms;     ///< numbers in the world, increasing
  std::vector<double> steps;         ///< n, increasing, from 0
  std::vector<RowMatrix> positions;  ///< one an arm, n x its dof, continuous joints unwrapped

  std::size_t size() const { return steps.size(); }
  double length(std::size_t i) const;  ///< of arms[i], joint-space [rad, prismatic joints m]
  double length() const;               ///< sum over the arms
};

/// One arm along waypoints, as fast as it can.
JointPath joint_path(const MultiRobotWorld& world, std::size_t arm, const std::vector<Eigen::VectorXd>& waypoints);
/// Arms along configurations of theirs, as many for each, all from one to the next in the same time: what the slowest
/// needs.
JointPath joint_path(const MultiRobotWorld& world, const std::vector<std::size_t>& arms,
                     const std::vector<std::vector<Eigen::VectorXd>>& ways);
/// Rows wherever an arm's move ends.
JointPath joint_path(const MultiRobotWorld& world, const std::vector<std::size_t>& arms,
                     const std::vector<multi::TimedPath>& paths);
/// Where arms[i] is at a step; after the last it rests.
Eigen::VectorXd position_at(const JointPath& path, std::size_t i, double step);
/// Two at the same time.
JointPath side_by_side(const JointPath& a, const JointPath& b);

/// Does an arm of the one meet an arm of the other?
bool meet(MultiRobotWorld& world, const JointPath& a, const JointPath& b);

/// Shorter, and free where `path` is: all arms at once go straight between rows where they can; then arm by arm, while
/// the others do as before (its own waits go too). No arm's way becomes longer. Stops at the deadline with what it has.
JointPath shortened(JointPath path, MultiRobotWorld& world, const Deadline& deadline);
/// Nearer to straight where it cannot be straight, arm by arm: parts of ways bend no more than they must, from whole
/// ways to parts of two rows.
JointPath tightened(JointPath path, MultiRobotWorld& world, const Deadline& deadline);

}  // namespace srmp
