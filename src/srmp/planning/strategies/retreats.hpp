#pragma once

#include <vector>

#include "srmp/planning/multi_robot_world.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// Displacements [rad, prismatic joints m] of one joint, and of a second one beside it, from a branch point: they span
/// the retreat candidates.
struct RetreatOffsets {
  std::vector<double> joint{-1.2, -0.8, -0.4, 0.4, 0.8, 1.2}, second_joint{-0.8, 0.8};
};

/// Where a robot may be clear of the others: configurations within its limits, around the branch points (at least one)
/// with one or two joints displaced. Those of the shortest detour between the ends of its path come first.
std::vector<Eigen::VectorXd> retreat_candidates(const RobotModel& robot, const Eigen::VectorXd& start,
                                                const Eigen::VectorXd& goal,
                                                const std::vector<Eigen::VectorXd>& branch_points,
                                                const RetreatOffsets& offsets = {});

/// The fraction of the points of other robots' paths (by number in the world; none: left out) with which the robot at q
/// is surely collision-free.
double collision_free_fraction(MultiRobotWorld& world, std::size_t robot, const Eigen::VectorXd& q,
                               const std::vector<std::vector<Eigen::VectorXd>>& paths);

}  // namespace srmp
