#include "srmp/planning/constraints/constrained_inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "srmp/core/low_discrepancy.hpp"
#include "srmp/planning/motion_checks.hpp"
#include "srmp/robot/distinct_configurations.hpp"

namespace srmp {

namespace {

constexpr std::size_t max_combinations = 256;  // of solutions for several links

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

/// The planned joints that move the link of a target.
std::vector<char> joints_of(const RobotModel& robot, const IkGoal& target) {
  std::vector<char> moves(robot.dof());
  const std::uint64_t support = robot.link_support(robot.link_or_end_effector(target.link));
  for (std::size_t k = 0; k < robot.actuated_joints().size(); ++k)
    if (support >> k & 1) moves[robot.actuated_joints()[k].joint] = 1;
  return moves;
}

/// What inverse_kinematics finds for each of the links alone, in all combinations, the nearest to the reference first;
/// nullopt where a joint moves several of the links.
std::optional<std::vector<Eigen::VectorXd>> combinations(const RobotModel& robot, const std::vector<IkGoal>& targets,
                                                         const Eigen::VectorXd& reference, const Deadline& deadline) {
  std::vector<std::vector<char>> own;  // joints of each link
  std::vector<char> taken(robot.dof());
  for (const IkGoal& target : targets) {
    own.push_back(joints_of(robot, target));
    for (std::size_t j = 0; j < taken.size(); ++j) {
      if (own.back()[j] && taken[j]) return std::nullopt;
      taken[j] |= own.back()[j];
    }
  }
  std::vector<Eigen::VectorXd> found{reference};
  for (std::size_t i = 0; i < targets.size(); ++i) {
    std::vector<Eigen::VectorXd> extended;
    for (const Eigen::VectorXd& q : all_solutions(robot, targets[i], reference, deadline))
      for (const Eigen::VectorXd& before : found) {
        Eigen::VectorXd& combined = extended.emplace_back(before);
        for (std::size_t j = 0; j < taken.size(); ++j)
          if (own[i][j]) combined[static_cast<Eigen::Index>(j)] = q[static_cast<Eigen::Index>(j)];
      }
    found = nearest_first(robot, reference, std::move(extended));
    if (found.size() > max_combinations) found.resize(max_combinations);
  }
  return found;
}

}  // namespace

std::vector<Eigen::VectorXd> constrained_inverse_kinematics(const PlacedRobot& placed,
                                                            const PlacedConstraints* constraints,
                                                            const std::vector<IkGoal>& targets,
                                                            const Eigen::VectorXd& reference,
                                                            const Deadline& deadline) {
  const RobotModel& robot = *placed.model;
  const IkOptions& options = targets.front().options;
  const auto alone = combinations(robot, targets, reference, deadline);
  if (alone && !constraints) return *alone;
  const PlacedConstraints all = with_targets(placed, constraints, targets);
  ConstraintChecker checker(all);
  DistinctConfigurations found(robot, options.distinct);
  const auto project = [&](Eigen::VectorXd q) {
    if (checker.project(q, constraint_fractions.configurations) && !found.has_one_close_to(q)) found.add(std::move(q));
  };
  if (alone)
    for (const Eigen::VectorXd& q : *alone) {
      if (deadline.stop_requested() || found.size() == static_cast<std::size_t>(options.seeds)) break;
      project(q);
    }
  if (found.size() > 0) return found.take_nearest_first(reference);
  const auto enough = static_cast<std::size_t>(options.max_solutions);
  for (int i = 0; i < options.seeds && found.size() < enough && !deadline.stop_requested(); ++i)
    project(seed(robot, reference, i));
  return found.take_nearest_first(reference);
}

}  // namespace srmp
