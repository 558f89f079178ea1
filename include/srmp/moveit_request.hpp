#pragma once

#include <string>
#include <vector>

#include "srmp/io/moveit.hpp"
#include "srmp/planner_interface.hpp"

namespace srmp {

/// A MoveIt motion request as a planning problem of one robot.
struct MoveItProblem {
  Eigen::VectorXd start;              ///< (dof,) [rad or m]; joints that the file leaves out stand at their set_qpos
  std::vector<GoalConstraint> goals;  ///< any one of them is enough
  std::vector<std::string> ignored_joints;  ///< named by the start state, but not movable joints of this robot
};

/// Converts the request to a problem of `robot`: start, goals, and the joints that the request names and the robot does
/// not have. Movable joints that are not planned (a gripper's) are set in the planner's world, and held objects are
/// attached. Its planning time, speed scalings and workspace are not used: the options of make_planner say these.
/// Throws InvalidArgument for joints or links that a goal names and the robot does not have, and NotSupported for goals
/// that cannot be stated here (some of the joints only, a region that is not a point, tolerances that differ by axis).
MoveItProblem apply_moveit_request(PlannerInterface& planner, const std::string& robot, const io::RequestFile& request);

}  // namespace srmp
