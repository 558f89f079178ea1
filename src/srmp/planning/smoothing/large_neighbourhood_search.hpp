#pragma once

#include "srmp/planning/world_paths.hpp"

namespace srmp {

/// Shorter where one arm has a better way than its own while all others do as before: through the corners of the way
/// that it would go alone and of the one that it goes, waiting wherever and whenever it likes, also after the others
/// are done; and through `places` of that arm's, if there are any, by its number in the world (large neighbourhood
/// search, Li et al. 2021, "Anytime multi-agent path finding via large neighborhood search", with neighbourhoods of
/// one). No arm's way becomes longer. Stops at the deadline with what it has.
JointPath reroute_one_robot(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                            const std::vector<std::vector<Eigen::VectorXd>>& places = {});

}  // namespace srmp
