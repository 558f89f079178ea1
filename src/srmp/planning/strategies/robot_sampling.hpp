#pragma once

#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/search/rrt_connect.hpp"

namespace srmp {

/// A robot's joints, for two trees to grow in from `start` and `goals`. Four samples in five are within a quarter turn
/// of the straight ways, the others anywhere within the limits (of joints with wide ones: a turn beyond those).
/// is_motion_free is left to the caller. The model outlives this.
search::RrtSpace rrt_space(const RobotModel& robot, const Eigen::VectorXd& start, std::vector<Eigen::VectorXd> goals);

}  // namespace srmp
