#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "srmp/planning/sequence.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// The positions by joint name [rad or m] of a segment of type gripper. Throws InvalidArgument for an end effector or a
/// state that does not exist, with the nearest name, and for a width that it does not have.
std::map<std::string, double> gripper_positions(const RobotModel& robot, const Segment& segment);

/// The same robot with these joints planned, which must be some of other_joints(), and all others fixed.
std::shared_ptr<const RobotModel> with_planned_joints(const RobotModel& robot, const std::vector<std::string>& joints);

/// Is the straight motion of the model's joints from where the scene has them to `positions` proved free? `model` is
/// that of with_planned_joints for the robot of the scene, which stands at its set_qpos.
bool is_finger_motion_free(const Scene& scene, const std::string& robot, std::shared_ptr<const RobotModel> model,
                           const std::map<std::string, double>& positions);

}  // namespace srmp
