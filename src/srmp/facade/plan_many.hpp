#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "srmp/planning/problem.hpp"
#include "srmp/planning/result.hpp"

namespace srmp {

/// A problem with what it refers to.
struct OwnedProblem {
  std::shared_ptr<const ProblemCheckers> checkers;
  std::unique_ptr<const PlannerOptions> options;
  std::unique_ptr<const PlanProblem> problem;
};
/// Makes the problem of a request; throws InvalidArgument. What else its references name must outlive plan_many.
using MakeProblem = std::function<OwnedProblem(const PlanRequest&)>;

/// The work behind PlannerInterface::plan_many. Every plan has workspaces and a deadline of its own, so which thread it
/// runs in, and what runs beside it, cannot change its result. `interrupt` and `progress` are called by the caller's
/// thread, which does not plan.
std::vector<PlanResult> plan_many(const std::vector<PlanRequest>& requests, const MakeProblem& make_problem,
                                  std::size_t threads, const Deadline::Interrupt& interrupt,
                                  const PlanProgress& progress);

}  // namespace srmp
