#pragma once

#include "srmp/planner/single_arm/best_path.hpp"
#include "srmp/planner/single_arm/plan_ends.hpp"

namespace srmp {

/// The planner `auto`: trees and several lattices in turns, then better paths for as long as the options ask. Hands
/// what it finds to `best`; throws PlanningError when that is nothing.
void search_in_turns(PlanContext& context, const PlanEnds& ends, const Auto& options, BestPath& best);

}  // namespace srmp
