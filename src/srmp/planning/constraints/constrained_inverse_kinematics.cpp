#include "srmp/planning/constraints/constrained_inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/low_discrepancy.hpp"
#include "srmp/planning/motion_checks.hpp"
#include "srmp/robot/distinct_configurations.hpp"

namespace srmp {

namespace {

PlacedConstraints with_targets(const PlacedRobot& robot, const PlacedConstraints* constraints,
                               const std::vector<IkGoal>& targets) {
  std::vector<PlacedConstraint> all;
  if (constraints) all = constraints->constraints();
  for (const auto& [link, in_base, options] : targets)
    all.push_back({.constraint = PathConstraint::pose(in_base, options.position_tolerance, options.rotation_tolerance),
                   .link = robot.model->link_or_end_effector(link),
                   .body = Eigen::Isometry3d::Identity(),
                   .frame = std::nullopt,
                   .target = in_base.isometry(),
                   .text = "the goal"});
  return {*robot.model, robot.other_positions, std::move(all)};
}

/// The reference, then a fixed sequence within the limits; continuous joints within half a turn of the reference.
Eigen::VectorXd seed(const RobotModel& robot, const Eigen::VectorXd& reference, int index) {
  if (index == 0) return reference;
  const Eigen::VectorXd unit = low_discrepancy_point(static_cast<std::size_t>(index), reference.size());
  Eigen::VectorXd q = reference;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const Joint& joint = robot.joints()[static_cast<std::size_t>(j)];
    const double lower = std::max(joint.lower, reference[j] - M_PI), upper = std::min(joint.upper, reference[j] + M_PI);
    q[j] = lower + unit[j] * (upper - lower);
  }
  return q;
}

/// They take a fraction of the time, and most of them are near what keeps the constraints.
std::vector<Eigen::VectorXd> solutions_without_constraints(const RobotModel& robot, const IkGoal& target,
                                                           const Eigen::VectorXd& reference, const Deadline& deadline) {
  IkOptions options = target.options;
  options.max_solutions = options.seeds;
  return inverse_kinematics(robot, target.in_base, reference, options, target.link, deadline);
}

}  // namespace

std::vector<Eigen::VectorXd> constrained_inverse_kinematics(const PlacedRobot& placed,
                                                            const PlacedConstraints* constraints,
                                                            const std::vector<IkGoal>& targets,
                                                            const Eigen::VectorXd& reference,
                                                            const Deadline& deadline) {
  const RobotModel& robot = *placed.model;
  const IkOptions& options = targets.front().options;
  const PlacedConstraints all = with_targets(placed, constraints, targets);
  ConstraintChecker checker(all);
  DistinctConfigurations found(robot, options.distinct);
  const auto project = [&](Eigen::VectorXd q) {
    if (checker.project(q, constraint_fractions.configurations) && !found.has_one_close_to(q)) found.add(std::move(q));
  };
  if (targets.size() == 1)
    for (Eigen::VectorXd& q : solutions_without_constraints(robot, targets.front(), reference, deadline)) {
      if (deadline.stop_requested()) break;
      project(std::move(q));
    }
  if (found.size() > 0) return found.take_nearest_first(reference);
  const auto enough = static_cast<std::size_t>(options.max_solutions);
  for (int i = 0; i < options.seeds && found.size() < enough && !deadline.stop_requested(); ++i)
    project(seed(robot, reference, i));
  return found.take_nearest_first(reference);
}

}  // namespace srmp
