#pragma once

#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planning/endpoints/ik_goal_connection.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// As inverse_kinematics, for configurations that bring several links to their targets at the same time and keep path
/// constraints (null: there are none). Where no joint moves two of the links, these are combinations of what
/// inverse_kinematics finds for each alone, projected onto the constraints. Where a joint does, or that fails, each
/// target is one constraint more, onto which seeds are projected until there are max_solutions. The options of the
/// first target count, with the tolerances of each. The same every time.
std::vector<Eigen::VectorXd> constrained_inverse_kinematics(const PlacedRobot& robot,
                                                            const PlacedConstraints* constraints,
                                                            const std::vector<IkGoal>& targets,
                                                            const Eigen::VectorXd& reference, const Deadline& deadline);

}  // namespace srmp
