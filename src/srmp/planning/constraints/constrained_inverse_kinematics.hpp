#pragma once

#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planning/endpoints/ik_goal_connection.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// As inverse_kinematics, for configurations that bring several links to their targets at the same time and keep path
/// constraints (null: there are none): each target is one constraint more. What is projected onto these is, of one
/// link, all that inverse_kinematics finds; of several, or where that fails, the seeds, until there are max_solutions.
/// The options of the first target count, with the tolerances of each. The same every time.
std::vector<Eigen::VectorXd> constrained_inverse_kinematics(const PlacedRobot& robot,
                                                            const PlacedConstraints* constraints,
                                                            const std::vector<IkGoal>& targets,
                                                            const Eigen::VectorXd& reference, const Deadline& deadline);

}  // namespace srmp
