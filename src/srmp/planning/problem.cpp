#include "srmp/planning/problem.hpp"

#include "srmp/planning/options/registry.hpp"

namespace srmp {

bool PlanProblem::is_for_one() const { return robots.size() == 1 && registered_planner(options).info.one_robot; }

}  // namespace srmp
