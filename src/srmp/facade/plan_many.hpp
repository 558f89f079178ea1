#pragma once

#include <functional>
#include <vector>

#include "srmp/planning/single_robot.hpp"

namespace srmp {

/// Makes the question of a request; throws InvalidArgument. What its references name must outlive plan_many.
using PoseProblem = std::function<SingleRobotProblem(const PlanRequest&)>;

/// The work behind PlannerInterface::plan_many. Every plan has workspaces and a deadline of its own, so which thread it
/// runs in, and what runs beside it, cannot change its answer. `interrupt` and `progress` are called by the caller's
/// thread, which does not plan.
std::vector<PlanResult> plan_many(const std::vector<PlanRequest>& requests, const PoseProblem& pose,
                                  std::size_t threads, const Deadline::Interrupt& interrupt,
                                  const PlanProgress& progress);

}  // namespace srmp
