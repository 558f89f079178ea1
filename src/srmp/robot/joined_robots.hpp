#pragma once

#include <string>
#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// One of several robots, as it stands in the world.
struct RobotToJoin {
  std::string name;
  const RobotModel& model;
  Pose base;                        ///< of its root link, in the world
  Eigen::VectorXd other_positions;  ///< of RobotModel::other_joints() [rad or m]
};

/// What a link or joint of a robot is called in the joined one: "<robot>_<name>".
std::string joined_name(const std::string& robot, const std::string& name);

/// One robot that is all of these: its root link, "<name>_origin", is the world's origin, and from there a fixed joint
/// leads to the root link of each. The planned joints are those of the robots, one robot after the other. Links of one
/// robot may touch as before, links of two may not. Named states are those that all robots have; end effectors and
/// groups of the SRDFs are kept, under joined names; visuals, virtual and passive joints are not. Throws
/// InvalidArgument where joined names are the same.
RobotDescription join_robots(const std::string& name, const std::vector<RobotToJoin>& robots);

}  // namespace srmp
