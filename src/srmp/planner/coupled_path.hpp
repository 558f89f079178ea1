#pragma once

#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/multi/world.hpp"
#include "srmp/planner/arm_world.hpp"

namespace srmp {

/// Many arms' ways side by side: between two rows every arm moves straight, all in the same time.
struct CoupledPath {
  std::vector<double> steps;         ///< n, increasing
  std::vector<RowMatrix> positions;  ///< one an arm, n x its dof, continuous joints unwrapped

  std::size_t size() const { return steps.size(); }
  double length(std::size_t arm) const;  ///< joint-space [rad, prismatic joints m]
  double length() const;                 ///< sum over the arms
};

/// Rows wherever an arm's move ends.
CoupledPath coupled_path(const ArmWorld& world, const std::vector<multi::TimedPath>& paths);

/// Shorter for every arm, or as long, and free where `path` is: arm by arm, parts of its way become straight motions at
/// constant speed while the others do as before (its own waits go too); then corners are taken away for all at once.
/// Stops at the deadline with what it has.
CoupledPath shortened(CoupledPath path, ArmWorld& world, const Deadline& deadline);

}  // namespace srmp
