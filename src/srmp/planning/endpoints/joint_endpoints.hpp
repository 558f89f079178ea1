#pragma once

#include <vector>

#include "srmp/planning/endpoints/endpoints.hpp"

namespace srmp {

/// Are the robots' starts free of collisions with each other, and some of their targets? `endpoints`: one a robot, of
/// the first robots of the checkers. Throws PlanningError, which names the bodies in collision: start_invalid for two
/// starts, then goal_invalid where every target of one robot collides with every target of another.
void require_joint_endpoints(const GroupCheckers& checkers, const std::vector<const RobotEndpoints*>& endpoints);

}  // namespace srmp
