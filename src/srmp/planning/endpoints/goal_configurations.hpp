#pragma once

#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planning/goal.hpp"
#include "srmp/trajectory/placed_constraints.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Configurations within the joint limits that meet a target of a goal, in collision or not, the nearest to `reference`
/// first: of joints the target itself, otherwise all that inverse kinematics finds, but of several links that a joint
/// moves together up to `max_solutions`. Those that keep the path constraints (null: there are none) come alone where
/// some are found. `why` says why there are none.
std::vector<Eigen::VectorXd> goal_configurations(const PlacedRobot& placed, const PlacedConstraints* constraints,
                                                 const GoalConstraint& goal, const Eigen::VectorXd& target,
                                                 const Eigen::VectorXd& reference, int max_solutions,
                                                 const Deadline& deadline, std::string& why);

}  // namespace srmp
