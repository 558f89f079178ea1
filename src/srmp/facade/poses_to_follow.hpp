#pragma once

#include <vector>

#include "srmp/planning/cartesian/follow_poses.hpp"
#include "srmp/planning/request.hpp"

namespace srmp {

/// What a link is to follow, from where it is at the start. Throws InvalidArgument as PlannerInterface::follow says.
PosesToFollow poses_to_follow(const PlacedRobot& robot, ConstVector start, const std::vector<Pose>& poses,
                              const CartesianOptions& options);

}  // namespace srmp
