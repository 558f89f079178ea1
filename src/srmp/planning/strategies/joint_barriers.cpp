#include "srmp/planning/strategies/joint_barriers.hpp"

#include <algorithm>
#include <string>

#include "srmp/collision/joint_barrier.hpp"
#include "srmp/core/error.hpp"

namespace srmp {

namespace {

std::string sentence(const RobotModel& robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                     const JointBarrier& barrier) {
  const auto j = static_cast<Eigen::Index>(barrier.joint);
  return "there is no path: joint '" + robot.joints()[barrier.joint].name + "' cannot get from " + to_text(from[j]) +
         " to " + to_text(to[j]) + ", because at " + to_text(barrier.position) + " " + barrier.contact.describe() +
         " wherever the other joints are";
}

}  // namespace

Attempt JointBarriers::attempt(const AttemptBudget& budget, const Deadline&) {
  Attempt result;
  const auto is_configuration = [](const GoalConstraint& goal) { return goal.type == GoalType::joints; };
  if (budget.round > 0 || endpoints_.targets.empty() ||
      !std::all_of(context_.task.goals.begin(), context_.task.goals.end(), is_configuration))
    return result;
  for (const Eigen::VectorXd& target : endpoints_.targets) {
    const auto barrier =
        find_joint_barrier(context_.checks.checker(), endpoints_.start, target, context_.checks.workspace());
    if (!barrier) return result;
    if (result.reason.empty()) result.reason = sentence(context_.robot, endpoints_.start, target, *barrier);
  }
  result.status = Status::exhausted;
  result.of_all_paths = true;
  return result;
}

}  // namespace srmp
