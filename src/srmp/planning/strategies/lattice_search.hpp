#pragma once

#include "srmp/planning/best_path.hpp"
#include "srmp/planning/endpoints/endpoints.hpp"

namespace srmp {

/// The planners that search one lattice (wAstar, Astar, ARAstar, MHAstar, wPASE): hands what they find to `best`.
/// Throws PlanningError when that is nothing, and NotSupported for planners that plan for many robots only.
void search_lattice(PlanContext& context, const Endpoints& ends, BestPath& best);

}  // namespace srmp
