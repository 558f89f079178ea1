#pragma once

#include "srmp/planning/best_path.hpp"
#include "srmp/planning/endpoints/endpoints.hpp"

namespace srmp {

/// The planner `auto`: trees and several lattices in turns, then better paths for as long as the options ask. Hands
/// what it finds to `best`; throws PlanningError when that is nothing.
void search_in_turns(PlanContext& context, const Endpoints& ends, const Auto& options, BestPath& best);

}  // namespace srmp
