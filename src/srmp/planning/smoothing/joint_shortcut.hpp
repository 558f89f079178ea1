#pragma once

#include "srmp/core/deadline.hpp"
#include "srmp/planning/world_paths.hpp"

namespace srmp {

/// Shorter, and free where `path` is: all robots at once go straight between rows where they can; then robot by robot,
/// while the others do as before (its own waits go too). No robot's way becomes longer. Stops at the deadline with what
/// it has.
JointPath shortened(JointPath path, MultiRobotWorld& world, const Deadline& deadline);
/// Nearer to straight where it cannot be straight, robot by robot: parts of paths bend no more than they must, from
/// whole paths to parts of two rows.
JointPath tightened(JointPath path, MultiRobotWorld& world, const Deadline& deadline);

}  // namespace srmp
