#include "srmp/planning/endpoints/goal_configurations.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/planning/constraints/constrained_inverse_kinematics.hpp"
#include "srmp/planning/endpoints/ik_goal_connection.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

/// Inverse kinematics of a goal's links with the tolerances that the targets have.
std::vector<Eigen::VectorXd> solutions_of(const PlacedRobot& placed, const std::vector<IkGoal>& targets,
                                          const Eigen::VectorXd& reference, const Deadline& deadline) {
  if (targets.size() > 1) return constrained_inverse_kinematics(placed, nullptr, targets, reference, deadline);
  return all_solutions(*placed.model, targets.front(), reference, deadline);
}

std::string place_of(const RobotModel& robot, const IkGoal& target, const Pose& base) {
  const std::string& link = target.link.empty() ? robot.end_effector() : target.link;
  const Eigen::Vector3d p = (base * target.in_base).p;
  return "'" + link + "' to [" + to_text(p[0]) + ", " + to_text(p[1]) + ", " + to_text(p[2]) + "]";
}

/// Why no configuration meets the targets: one of them that none meets even alone, or all of them.
std::string reason(const PlacedRobot& placed, const std::vector<IkGoal>& targets, const Eigen::VectorXd& reference,
                   const Deadline& deadline) {
  const RobotModel& robot = *placed.model;
  const std::string seeds = " (" + std::to_string(targets.front().options.seeds) + " seeds tried)";
  std::string all;
  for (const IkGoal& target : targets) {
    const std::string place = place_of(robot, target, placed.base);
    if (targets.size() == 1 || solutions_of(placed, {target}, reference, deadline).empty())
      return "no configuration within the joint limits brings " + place + seeds;
    all += (all.empty() ? "" : " and ") + place;
  }
  return "no configuration within the joint limits brings " + all + " at the same time" + seeds;
}

}  // namespace

std::vector<Eigen::VectorXd> goal_configurations(const PlacedRobot& placed, const PlacedConstraints* constraints,
                                                 const GoalConstraint& goal, const Eigen::VectorXd& target,
                                                 const Eigen::VectorXd& reference, int max_solutions,
                                                 const Deadline& deadline, std::string& why) {
  if (goal.type == GoalType::joints) return {placed.model->clamped(target, limit_tolerance)};
  std::vector<IkGoal> targets = ik_goals(goal, target, placed);
  for (IkGoal& each : targets) each.options.max_solutions = max_solutions;
  if (constraints) {  // before those that the constraints may refuse
    auto kept = constrained_inverse_kinematics(placed, constraints, targets, reference, deadline);
    if (!kept.empty()) return kept;
  }
  auto found = solutions_of(placed, targets, reference, deadline);
  if (!found.empty()) return found;
  for (auto& [link, in_base, options] : targets) {  // nothing meets it exactly: whatever is within the tolerances
    options.position_tolerance = goal.position_tolerance;
    if (goal.type == GoalType::pose) options.rotation_tolerance = goal.rotation_tolerance;
  }
  found = solutions_of(placed, targets, reference, deadline);
  if (found.empty()) why = reason(placed, targets, reference, deadline);
  return found;
}

}  // namespace srmp
