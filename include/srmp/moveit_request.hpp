#pragma once

#include <string>
#include <vector>

#include "srmp/io/moveit.hpp"
#include "srmp/planner_interface.hpp"

namespace srmp {

/// A MoveIt motion request, in the terms of one robot of a planner.
struct MoveItProblem {
  Eigen::VectorXd start;                    ///< planned joints; those the file leaves out stand where set_qpos put them
  std::vector<GoalConstraint> goals;        ///< any one of them will do
  std::vector<std::string> ignored_joints;  ///< named by the start state, but no movable joints of this robot
};

/// Reads the request for `robot`: its start state and goals. Movable joints of the start state that are not planned (a
/// gripper's) are set in the planner's world, and held objects are attached. Throws InvalidArgument for joints or links
/// that a goal names and the robot does not have, and NotSupported for goals this library cannot state (part of the
/// joints only, a region that is not a point, tolerances that differ by axis).
MoveItProblem apply_moveit_request(PlannerInterface& planner, const std::string& robot, const io::RequestFile& request);

}  // namespace srmp
