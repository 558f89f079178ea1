#pragma once

#include <string>
#include <vector>

#include "srmp/lattice/lattice.hpp"
#include "srmp/multi/conflict_search.hpp"
#include "srmp/planning/multi_robot_world.hpp"
#include "srmp/planning/search_trace.hpp"

namespace srmp {

/// Records a robot's lattice under this name, where a trace is recorded; otherwise an observer that does nothing.
LatticeObserver lattice_recorder(const std::string& robot, const std::string& name);

/// Records the constraint tree of some robots of a world, where a trace is recorded; otherwise empty. The arguments
/// outlive it.
multi::OnOpenedNode constraint_tree_recorder(const MultiRobotWorld& world, const std::vector<std::size_t>& robots);

}  // namespace srmp
