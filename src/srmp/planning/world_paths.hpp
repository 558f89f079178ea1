#pragma once

#include <vector>

#include "srmp/multi/world.hpp"
#include "srmp/planning/joint_path.hpp"
#include "srmp/planning/multi_robot_world.hpp"

namespace srmp {

/// One robot of the world along waypoints, each segment in as many steps as it needs at full speed.
JointPath joint_path(const MultiRobotWorld& world, std::size_t robot, const std::vector<Eigen::VectorXd>& waypoints);
/// Robots along waypoints, as many for each, all from one to the next in the same time: what the slowest needs.
JointPath joint_path(const MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                     const std::vector<std::vector<Eigen::VectorXd>>& waypoints);
/// Robots along the moves of agents: rows wherever a move of one of them begins.
JointPath joint_path(const MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                     const std::vector<multi::TimedPath>& paths);

/// Does a robot of the one path collide with a robot of the other?
bool in_conflict(MultiRobotWorld& world, const JointPath& a, const JointPath& b);

}  // namespace srmp
