#pragma once

#include <vector>

#include "srmp/planning/group_checkers.hpp"

namespace srmp {

/// Where a robot starts, and where it may end; no targets: anywhere.
struct RobotEndpoints {
  const Eigen::VectorXd& start;
  const std::vector<Eigen::VectorXd>& targets;
};

/// Of the first robots of the checkers, one entry each. Throws PlanningError, which names what touches: start_invalid
/// where two are in each other at their starts, then goal_invalid where no targets of two go together.
void require_joint_endpoints(const GroupCheckers& checkers, const std::vector<RobotEndpoints>& ends);

}  // namespace srmp
