#pragma once

#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/robot/inverse_kinematics.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// As inverse_kinematics of the end effector, for configurations that keep path constraints too: the target is one
/// constraint more, onto which the seeds are projected. The same every time.
std::vector<Eigen::VectorXd> constrained_inverse_kinematics(const PlacedConstraints& constraints, const Pose& target,
                                                            const Eigen::VectorXd& reference, const IkOptions& options,
                                                            const Deadline& deadline);

}  // namespace srmp
