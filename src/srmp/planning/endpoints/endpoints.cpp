#include "srmp/planning/endpoints/endpoints.hpp"

#include <algorithm>
#include <optional>

#include "srmp/core/error.hpp"
#include "srmp/planning/endpoints/goal_configurations.hpp"
#include "srmp/planning/endpoints/start_recovery.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

/// Contacts computed for one end that is too close to something, at most.
constexpr int max_approach_checks = 4000;

/// Is a configuration that is not free within the limits and only closer to something than the required clearance,
/// which is relaxed there? For several robots it is not.
bool is_only_close(RobotContext& context, const Eigen::VectorXd& q) {
  const Checker& checker = context.checks.checker();
  if (checker.clearance_kept() == 0.0 || checker.robot().limit_violation(q)) return false;
  if (!context.problem.is_for_one()) return false;
  const Checker& contacts = context.problem.checkers.verification().alone(0);
  return contacts.is_free(q, *contacts.make_workspace());
}

/// From an end that is too close to something, on which no pair comes closer; empty: none was found.
std::vector<Eigen::VectorXd> find_departure(RobotContext& context, const Eigen::VectorXd& end) {
  return find_start_recovery(context.checks.checker(), end, context.checks.workspace(),
                             [&] { context.stop_if_late("the search for a way out of a lack of clearance"); },
                             {.max_checks = max_approach_checks});
}

void add_note(PlanStatistics& statistics, const std::string& note) {
  statistics.note += (statistics.note.empty() ? "" : "; ") + note;
}

/// From a start in collision, for the reason `why`, to a free one, from which the path is searched.
void recover_start(RobotContext& context, RobotEndpoints& endpoints, const std::string& why) {
  endpoints.starts_in_collision = !is_only_close(context, endpoints.start);
  endpoints.recovery = endpoints.starts_in_collision
                           ? find_start_recovery(context.checks.checker(), endpoints.start, context.checks.workspace(),
                                                 [&] { context.stop_if_late("the recovery of the start"); })
                           : find_departure(context, endpoints.start);
  if (endpoints.recovery.empty() && !endpoints.starts_in_collision)
    throw PlanningError(Status::start_invalid,
                        "the start is invalid: " + why +
                            ", and no motion was found to where the clearance is kept along which no pair that is "
                            "closer comes closer still");
  if (endpoints.recovery.empty())
    throw PlanningError(Status::start_invalid,
                        "the start is invalid: " + why +
                            ", and no way out was found along which no pair gets deeper into contact and no other "
                            "comes into contact");
  endpoints.start = endpoints.recovery.back();
  PlanStatistics& statistics = context.statistics;
  statistics.recovery_waypoints = static_cast<int>(endpoints.recovery_segments());
  statistics.recovery_cost_rad = context.length(endpoints.recovery);
  add_note(statistics, endpoints.starts_in_collision
                           ? "the start was in collision (" + why + "): the trajectory begins with the way out of it"
                           : "the start does not keep the clearance (" + why +
                                 "): the trajectory begins with the way "
                                 "to where it is kept");
}

void find_start(RobotContext& context, RobotEndpoints& endpoints, bool may_be_close) {
  const RobotProblem& task = context.task;
  context.robot.require_configuration(task.start, "start of '" + task.robot + "'");
  endpoints.start = context.robot.clamped(task.start, limit_tolerance);
  if (endpoints.start != task.start)
    context.statistics.note = "the start was moved onto a joint limit that it missed by at most 1e-6";
  const std::string broken = context.checks.violation(endpoints.start);
  if (!broken.empty()) throw PlanningError(Status::start_invalid, "the start is invalid: " + broken);
  const std::string why = invalidity(context.checks.checker(), endpoints.start, context.checks.workspace());
  if (why.empty() || (may_be_close && is_only_close(context, endpoints.start))) return;
  const bool may_recover = context.common.recover_start || is_only_close(context, endpoints.start);
  if (!may_recover || context.task.constraints || context.robot.limit_violation(endpoints.start))
    throw PlanningError(Status::start_invalid, "the start is invalid: " + why);
  recover_start(context, endpoints, why);
}

bool may_be_approached(RobotContext& context, const Eigen::VectorXd& q) {
  return !context.task.constraints && is_only_close(context, q);
}

/// Adds a configuration that satisfies a goal as a target; if it does not keep the clearance, where the approach to it
/// begins, as long as `searches` for approaches are left. False: it is invalid.
bool add_target(RobotContext& context, RobotEndpoints& endpoints, Eigen::VectorXd q, int goal_index, int& searches) {
  if (!context.checks.violation(q).empty()) return false;
  std::vector<Eigen::VectorXd> approach;
  if (context.robot.limit_violation(q) || !context.checks.checker().is_free(q, context.checks.workspace())) {
    if (!may_be_approached(context, q) || searches-- <= 0) return false;
    approach = find_departure(context, q);
    if (approach.empty()) return false;
    std::reverse(approach.begin(), approach.end());
    q = approach.front();
  }
  endpoints.targets.push_back(std::move(q));
  endpoints.goal_indices.push_back(goal_index);
  endpoints.approaches.push_back(std::move(approach));
  return true;
}

/// Why a configuration that satisfies a goal is invalid. Points of contact take longer to find than all else here.
std::string reason_against_target(RobotContext& context, const Eigen::VectorXd& q) {
  const std::string broken = context.checks.violation(q);
  if (!broken.empty()) return broken;
  return invalidity(context.checks.checker(), q, context.checks.workspace()) +
         (may_be_approached(context, q)
              ? ", and no motion was found from where the clearance is kept along which no pair comes closer "
                "than at the goal"
              : "");
}

/// Why there is no target yet.
struct NoTarget {
  std::string reason;                      // of the first goal that no configuration satisfies
  std::optional<Eigen::VectorXd> invalid;  // the first configuration that satisfies a goal
};

/// Adds up to ik_solutions valid configurations that satisfy a goal.
void find_targets(RobotContext& context, RobotEndpoints& endpoints, const GoalConstraint& goal,
                  const Eigen::VectorXd& target, int goal_index, NoTarget& no_target) {
  const int enough = context.common.ik_solutions;
  int valid = 0, searches = enough;
  std::string why;
  for (const int most : {enough, IkOptions().seeds}) {
    auto found = goal_configurations(*context.task.placed, context.task.constraints.get(), goal, target,
                                     endpoints.start, most, context.deadline, why);
    for (Eigen::VectorXd& q : found) {
      if (add_target(context, endpoints, q, goal_index, searches)) {
        if (++valid == enough) break;
      } else if (!no_target.invalid) {
        no_target.invalid = std::move(q);
      }
      context.stop_if_late("the search for goal configurations");
    }
    // Those of several links are found one by one: no more than necessary at first.
    if (valid > 0 || goal.links.size() <= 1 || std::ssize(found) < most) break;
  }
  if (no_target.reason.empty() && !no_target.invalid) no_target.reason = why;
}

void find_targets(RobotContext& context, RobotEndpoints& endpoints) {
  const PhaseTimer timer(context.deadline, context.statistics.ik_time_s);
  int index = 0;
  NoTarget no_target;
  for (const GoalConstraint& goal : context.task.goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      find_targets(context, endpoints, goal, target, index, no_target);
      ++index;
      context.stop_if_late("the search for goal configurations");
    }
  if (!endpoints.targets.empty()) return;
  if (no_target.reason.empty() && no_target.invalid)
    no_target.reason = reason_against_target(context, *no_target.invalid);
  throw PlanningError(
      Status::goal_invalid,
      (index == 1 ? "the goal is invalid: " : "all goals are invalid, the first because ") + no_target.reason);
}

}  // namespace

RobotEndpoints find_endpoints(RobotContext& context, bool start_may_be_close) {
  RobotEndpoints endpoints;
  find_start(context, endpoints, start_may_be_close);
  if (!context.task.may_end_anywhere()) find_targets(context, endpoints);
  return endpoints;
}

RowMatrix with_approach(const RobotContext& context, const RobotEndpoints& endpoints, const RowMatrix& waypoints) {
  const Eigen::VectorXd end = waypoints.bottomRows(1).transpose();
  for (std::size_t i = 0; i < endpoints.targets.size(); ++i) {
    const std::vector<Eigen::VectorXd>& approach = endpoints.approaches[i];
    if (approach.empty() || !context.robot.difference(endpoints.targets[i], end).isZero(1e-9)) continue;
    RowMatrix whole(waypoints.rows() + static_cast<Eigen::Index>(approach.size()) - 1, waypoints.cols());
    whole.topRows(waypoints.rows()) = waypoints;
    for (std::size_t k = 1; k < approach.size(); ++k)  // continuous joints may have turned
      whole.row(waypoints.rows() + static_cast<Eigen::Index>(k) - 1) =
          (end + approach[k] - endpoints.targets[i]).transpose();
    add_note(context.statistics,
             "the goal does not keep the clearance: the trajectory ends with the way to it from "
             "where it is kept");
    return whole;
  }
  return waypoints;
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
