#include "srmp/planning/endpoints/endpoints.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/planning/endpoints/goal_configurations.hpp"
#include "srmp/planning/endpoints/start_recovery.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

/// From a start in collision, for the reason `why`, to a free one, from which the path is searched.
void recover_start(RobotContext& context, RobotEndpoints& endpoints, const std::string& why) {
  endpoints.recovery = find_start_recovery(context.checks.checker(), endpoints.start, context.checks.workspace(),
                                           [&] { context.stop_if_late("the recovery of the start"); });
  if (endpoints.recovery.empty())
    throw PlanningError(Status::start_invalid,
                        "the start is invalid: " + why +
                            ", and no way out was found along which no pair gets deeper into contact and no other "
                            "comes into contact");
  endpoints.start = endpoints.recovery.back();
  PlanStatistics& statistics = context.statistics;
  statistics.recovery_waypoints = static_cast<int>(endpoints.recovery_segments());
  statistics.recovery_cost_rad = context.length(endpoints.recovery);
  statistics.note += (statistics.note.empty() ? "" : "; ") +
                     ("the start was in collision (" + why + "): the trajectory begins with the way out of it");
}

void find_start(RobotContext& context, RobotEndpoints& endpoints) {
  const RobotProblem& task = context.task;
  context.robot.require_configuration(task.start, "start of '" + task.robot + "'");
  endpoints.start = context.robot.clamped(task.start, limit_tolerance);
  if (endpoints.start != task.start)
    context.statistics.note = "the start was moved onto a joint limit that it missed by at most 1e-6";
  const std::string broken =
      context.checks.constraints() ? context.checks.constraints()->violation(endpoints.start) : "";
  if (!broken.empty()) throw PlanningError(Status::start_invalid, "the start is invalid: " + broken);
  const std::string why = invalidity(context.checks.checker(), endpoints.start, context.checks.workspace());
  if (why.empty()) return;
  if (!context.common.recover_start || context.task.constraints || context.robot.limit_violation(endpoints.start))
    throw PlanningError(Status::start_invalid, "the start is invalid: " + why);
  recover_start(context, endpoints, why);
}

void find_targets(RobotContext& context, RobotEndpoints& endpoints) {
  const PhaseTimer timer(context.deadline, context.statistics.ik_time_s);
  int index = 0;
  std::string first_reason;
  for (const GoalConstraint& goal : context.task.goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      std::string why;
      for (Eigen::VectorXd& q :
           goal_configurations(*context.task.placed, context.task.constraints.get(), goal, target, endpoints.start,
                               context.common.ik_solutions, context.deadline, why)) {
        std::string invalid = context.checks.constraints() ? context.checks.constraints()->violation(q) : "";
        if (invalid.empty()) invalid = invalidity(context.checks.checker(), q, context.checks.workspace());
        if (invalid.empty()) {
          endpoints.targets.push_back(std::move(q));
          endpoints.goal_indices.push_back(index);
        } else if (why.empty()) {
          why = invalid;
        }
        context.stop_if_late("the search for goal configurations");
      }
      if (first_reason.empty()) first_reason = why;
      ++index;
      context.stop_if_late("the search for goal configurations");
    }
  if (endpoints.targets.empty())
    throw PlanningError(
        Status::goal_invalid,
        (index == 1 ? "the goal is invalid: " : "all goals are invalid, the first because ") + first_reason);
}

}  // namespace

int RobotEndpoints::goal_index_of(const Eigen::VectorXd& target) const {
  return goal_indices[static_cast<std::size_t>(std::find(targets.begin(), targets.end(), target) - targets.begin())];
}

RobotEndpoints find_endpoints(RobotContext& context) {
  RobotEndpoints endpoints;
  find_start(context, endpoints);
  if (!context.task.may_end_anywhere()) find_targets(context, endpoints);
  return endpoints;
}

void verify_recovery(const RobotContext& context, const RobotEndpoints& endpoints) {
  if (endpoints.recovery.empty()) return;
  const PhaseTimer timer(context.deadline, context.statistics.verification_time_s);
  const Checker& checker = context.checks.checker();
  const std::string why = recovery_violation(checker, endpoints.recovery, *checker.make_workspace());
  if (!why.empty())
    throw Error("internal error: the recovery of the start does not end in free space (" + why +
                "); nothing is returned. Please report this");
}

}  // namespace srmp
