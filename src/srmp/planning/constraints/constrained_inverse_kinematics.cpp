#include "srmp/planning/constraints/constrained_inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/low_discrepancy.hpp"
#include "srmp/planning/motion_checks.hpp"

namespace srmp {

namespace {

PlacedConstraints with_target(const PlacedConstraints& constraints, const Pose& target, const IkOptions& options) {
  std::vector<PlacedConstraint> all = constraints.constraints();
  all.push_back({.constraint = PathConstraint::pose(target, options.position_tolerance, options.rotation_tolerance),
                 .link = constraints.robot().link_index(constraints.robot().end_effector()),
                 .body = Eigen::Isometry3d::Identity(),
                 .frame = std::nullopt,
                 .target = target.isometry(),
                 .text = "the goal"});
  return {constraints.robot(), constraints.other_positions(), std::move(all)};
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

}  // namespace

std::vector<Eigen::VectorXd> constrained_inverse_kinematics(const PlacedConstraints& constraints, const Pose& target,
                                                            const Eigen::VectorXd& reference, const IkOptions& options,
                                                            const Deadline& deadline) {
  const RobotModel& robot = constraints.robot();
  const PlacedConstraints all = with_target(constraints, target, options);
  ConstraintChecker checker(all);
  std::vector<Eigen::VectorXd> found;
  for (int i = 0; i < options.seeds && std::ssize(found) < options.max_solutions; ++i) {
    if (deadline.stop_requested()) break;
    Eigen::VectorXd q = seed(robot, reference, i);
    if (!checker.project(q, constraint_fractions.configurations)) continue;
    const bool is_new = std::none_of(found.begin(), found.end(), [&](const Eigen::VectorXd& other) {
      return robot.difference(other, q).cwiseAbs().maxCoeff() < options.distinct;
    });
    if (is_new) found.push_back(std::move(q));
  }
  std::stable_sort(found.begin(), found.end(), [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return robot.difference(reference, a).norm() < robot.difference(reference, b).norm();
  });
  return found;
}

}  // namespace srmp
