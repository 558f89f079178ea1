#include "srmp/planning/certificates/verify.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"
#include "srmp/trajectory/prove_clearance.hpp"
#include "srmp/trajectory/prove_constraints.hpp"

namespace srmp {

namespace {

constexpr double rounding = 1e-9;         // [m] of a deviation
constexpr double joint_tolerance = 2e-6;  // [rad or m]: targets outside a limit by 1e-6 are moved onto it

double fraction_of(const Eigen::Vector3d& miss, const AxisTolerance& tolerance) {
  return (miss.cwiseAbs().array() / tolerance.axes.array()).maxCoeff();
}

/// By how much a link that is at `pose` misses its part of a target.
double link_miss(const GoalConstraint& goal, std::span<const double> target, const Pose& pose) {
  if (goal.type == GoalType::position)
    return fraction_of(pose.p - Eigen::Vector3d(target.data()), goal.position_tolerance);
  const Pose off = Pose::from_list(target).inverse() * pose;
  const Eigen::AngleAxisd turn(off.q);
  const double angle = std::remainder(turn.angle(), 2.0 * M_PI);
  return std::max(fraction_of(off.p, goal.position_tolerance),
                  fraction_of(angle * turn.axis(), goal.rotation_tolerance));
}

double miss_of(const GoalConstraint& goal, const Eigen::VectorXd& target, const Checker& checker, ConstVector q) {
  const RobotModel& robot = checker.robot();
  if (goal.type == GoalType::joints) return robot.difference(q, target).cwiseAbs().maxCoeff();
  double worst = 0.0;
  const std::size_t links = std::max<std::size_t>(1, goal.links.size());
  const std::size_t each = static_cast<std::size_t>(target.size()) / links;
  for (std::size_t i = 0; i < links; ++i) {
    const Pose pose =
        checker.base() * robot.compute_fk(q, goal.links.empty() ? "" : goal.links[i], checker.other_positions());
    worst = std::max(worst, link_miss(goal, {target.data() + i * each, each}, pose));
  }
  return worst;
}

/// The values of a row in another order.
bool is_permutation(ConstVector a, ConstVector b) {
  std::vector<double> x(a.begin(), a.end()), y(b.begin(), b.end());
  std::sort(x.begin(), x.end());
  std::sort(y.begin(), y.end());
  return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                    [](double u, double v) { return std::abs(u - v) <= joint_tolerance; });
}

void check_start(const Trajectory& trajectory, const RobotModel& robot, const Eigen::VectorXd& start,
                 Certificate& certificate) {
  const Eigen::VectorXd first = trajectory.positions.row(0).transpose(), off = robot.difference(start, first);
  Eigen::Index j{};
  const double most = off.cwiseAbs().maxCoeff(&j);
  if (most <= joint_tolerance) return;
  const std::string& joint = robot.joint_names()[static_cast<std::size_t>(j)];
  const std::string text = joint + ": the trajectory starts at " + to_text(first[j]) + ", not at " + to_text(start[j]);
  const bool mixed = is_permutation(first, start);
  certificate.faults.push_back({mixed ? FaultKind::joint_names : FaultKind::start,
                                mixed ? "the columns are in another order than the joint names: " + text : text,
                                trajectory.times[0]});
}

void check_goal(const Trajectory& trajectory, const Checker& checker, const std::vector<GoalConstraint>& goals,
                Certificate& certificate) {
  const Eigen::VectorXd end = trajectory.positions.bottomRows(1).transpose();
  const GoalError miss = goal_error(goals, checker, end);
  certificate.goal_error = miss.error;
  if (!(miss.error > miss.allowed)) return;
  certificate.faults.push_back({FaultKind::goal,
                                miss.allowed == 1.0
                                    ? "the end misses the goal by " + to_text(miss.error) + " times its tolerance"
                                    : "the end misses the goal by " + to_text(miss.error) + " rad (m)",
                                trajectory.times[trajectory.times.size() - 1]});
}

}  // namespace

GoalError goal_error(const std::vector<GoalConstraint>& goals, const Checker& checker, ConstVector q) {
  GoalError best;
  double least = std::numeric_limits<double>::infinity();
  for (const GoalConstraint& goal : goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      const double error = miss_of(goal, target, checker, q);
      const double allowed = goal.type == GoalType::joints ? joint_tolerance : 1.0;
      if (error / allowed < least) {
        least = error / allowed;
        best = {error, allowed};
      }
    }
  return best;
}

void require_clearance(double clearance) {
  if (!(clearance >= 0.0 && std::isfinite(clearance)))
    throw InvalidArgument("clearance is " + to_text(clearance) + "; it must be 0 m or above");
}

PlacedVerifyOptions place(const VerifyOptions& options, const Scene& scene, const std::string& robot) {
  require_clearance(options.clearance);
  PlacedVerifyOptions placed{.constraints = place_constraints(scene, robot, options.constraints)};
  if (options.clearance != 0.0)
    placed.with_clearance = make_checker(scene, robot, {.mode = CheckMode::coal, .clearance = options.clearance});
  return placed;
}

Certificate verify(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
                   const VerifyOptions& options, const PlacedVerifyOptions& placed) {
  if (options.max_deviation && !(*options.max_deviation >= 0.0))
    throw InvalidArgument("max_deviation is " + to_text(*options.max_deviation) + "; it must be 0 m or above");
  const RobotModel& robot = checker.robot();
  if (options.start) robot.require_configuration(*options.start, "start of '" + robot.name() + "'");
  for (const auto& [values, what] : {std::pair{&options.start_velocity, "start_velocity of '"},
                                     std::pair{&options.start_acceleration, "start_acceleration of '"}})
    if (values->size()) robot.require_configuration(*values, what + robot.name() + "'");
  Certificate certificate = certify(trajectory, checker, options.limits.value_or(limits),
                                    {.jerk = options.jerk,
                                     .gap_tolerance = options.gap_tolerance,
                                     .at_rest = options.at_rest,
                                     .start_velocity = options.start_velocity,
                                     .start_acceleration = options.start_acceleration});
  if (unreadable(trajectory, robot)) return certificate;
  if (placed.constraints) add_constraints(certificate, trajectory, *placed.constraints, Deadline());
  if (placed.with_clearance) add_clearance(certificate, trajectory, *placed.with_clearance, Deadline());
  if (options.start) check_start(trajectory, robot, *options.start, certificate);
  if (!options.goals.empty()) check_goal(trajectory, checker, options.goals, certificate);
  if (options.max_deviation && certificate.deviation > *options.max_deviation + rounding)
    certificate.faults.push_back({FaultKind::deviation,
                                  "the motion leaves its checked path by " + to_text(certificate.deviation) + " m at " +
                                      to_text(certificate.deviation_time) + " s; " + to_text(*options.max_deviation) +
                                      " m are allowed",
                                  certificate.deviation_time});
  return certificate;
}

}  // namespace srmp
