#include "srmp/planning/goal.hpp"

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"

namespace srmp {

std::string_view to_string(GoalType type) {
  switch (type) {
    case GoalType::joints: return "joints";
    case GoalType::pose: return "pose";
    case GoalType::position: return "position";
    case GoalType::hold: return "hold";
    case GoalType::any: return "any";
  }
  return "unknown";
}

GoalConstraint GoalConstraint::joints(const Eigen::VectorXd& q) { return {GoalType::joints, {q}}; }

GoalConstraint GoalConstraint::pose(const Pose& pose) {
  const auto numbers = pose.to_list();
  return {GoalType::pose, {Eigen::Map<const Eigen::VectorXd>(numbers.data(), 7)}};
}

GoalConstraint GoalConstraint::position(const Eigen::Vector3d& p) { return {GoalType::position, {p}}; }

GoalConstraint GoalConstraint::hold() { return {GoalType::hold, {}}; }
GoalConstraint GoalConstraint::any() { return {GoalType::any, {}}; }

void GoalConstraint::validate() const {
  if (type == GoalType::hold || type == GoalType::any) {
    if (!targets.empty()) throw InvalidArgument("a goal of type '" + std::string(to_string(type)) + "' has no target");
    return;
  }
  if (targets.empty()) throw InvalidArgument("the goal has no target; give at least one");
  position_tolerance.validate("goal position_tolerance");
  rotation_tolerance.validate("goal rotation_tolerance");
  if (type != GoalType::joints && position_tolerance.axes.array().isInf().all() &&
      (type == GoalType::position || rotation_tolerance.axes.array().isInf().all()))
    throw InvalidArgument("the goal's tolerances leave every axis free; nothing is asked for");
  for (const Eigen::VectorXd& target : targets) {
    if (target.size() == 0) throw InvalidArgument("the goal has an empty target; a target is a row of numbers");
    const std::span<const double> numbers(target.data(), static_cast<std::size_t>(target.size()));
    if (type == GoalType::pose) {
      require_position(Pose::from_list(numbers).p, "goal pose position");
    } else {
      require_finite(numbers, "goal " + std::string(to_string(type)));
      if (type == GoalType::position && target.size() != 3)
        throw InvalidArgument("a position goal is 3 numbers, x, y, z, but got " + std::to_string(target.size()));
      if (type == GoalType::position) require_position(target, "goal position");
    }
  }
}

}  // namespace srmp
