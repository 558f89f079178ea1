#include "srmp/planning/certificates/joint_certificates.hpp"

#include "srmp/core/error.hpp"
#include "srmp/planning/certificates/verify.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/prove_clearance.hpp"
#include "srmp/trajectory/prove_collision_free.hpp"
#include "srmp/trajectory/prove_constraints.hpp"

namespace srmp {

namespace {

/// When the recovery from the start has ended: the motion stops there.
double end_of_recovery(const RobotMotion& robot) {
  if (!robot.motion.timed()) return static_cast<double>(robot.recovery_segments);
  const auto waypoint = robot.motion.waypoints.row(static_cast<Eigen::Index>(robot.recovery_segments));
  Eigen::Index row{};
  (robot.motion.positions.rowwise() - waypoint).rowwise().norm().minCoeff(&row);
  return robot.motion.times[row];
}

Certificate certify_alone(const Checker& checker, const RobotMotion& robot, const CommonOptions& options,
                          const Deadline& until) {
  const Trajectory& motion = robot.motion;
  CertifyOptions certify_options{.limits = motion.timed(), .jerk = options.timing == "ruckig", .deadline = &until};
  if (const auto& begin = robot.task->start_in_motion) {
    certify_options.start_velocity = begin->velocity;
    certify_options.start_acceleration = begin->acceleration;
  }
  if (robot.recovery_segments > 0) certify_options.free_from = end_of_recovery(robot);
  const MotionLimits limits = scaled(robot.task->limits, options);
  Certificate certificate = motion.timed() ? certify(motion, checker, limits, certify_options)
                                           : certify(with_times(motion), checker, limits, certify_options);
  if (!robot.task->may_end_anywhere())
    certificate.goal_error = goal_error(robot.task->goals, checker, motion.positions.bottomRows(1).transpose()).error;
  if (robot.task->constraints) add_constraints(certificate, with_times(motion), *robot.task->constraints, until);
  return certificate;
}

}  // namespace

std::vector<Certificate> joint_certificates(const GroupCheckers& checkers, const GroupCheckers* with_clearance,
                                            const std::vector<RobotMotion>& motions, const CommonOptions& options,
                                            const Deadline& until) {
  std::vector<Certificate> certificates;
  for (const RobotMotion& robot : motions) {
    certificates.emplace_back();
    if (!robot.task) continue;
    certificates.back() = certify_alone(checkers.alone(robot.robot), robot, options, until);
    if (with_clearance)
      add_clearance(certificates.back(), with_times(robot.motion), with_clearance->alone(robot.robot), until);
  }
  const GroupCheckers& of_pairs = with_clearance ? *with_clearance : checkers;
  for (std::size_t i = 0; i < motions.size(); ++i)
    for (std::size_t j = i + 1; j < motions.size(); ++j)
      if (const auto proof = prove_pair(of_pairs, motions[i], motions[j], until))
        add_pair_proof(of_pairs, *proof, motions[i], certificates[i], motions[j], certificates[j]);
  return certificates;
}

std::optional<MotionProof> prove_pair(const GroupCheckers& checkers, const RobotMotion& a, const RobotMotion& b,
                                      const Deadline& until) {
  const Checker* checker = checkers.pair(a.robot, b.robot);
  if (!checker || (!a.task && !b.task)) return std::nullopt;
  return prove_collision_free(*checker, with_times(a.motion), with_times(b.motion), {0.5, &until});
}

void add_pair_proof(const GroupCheckers& checkers, const MotionProof& proof, const RobotMotion& a, Certificate& of_a,
                    const RobotMotion& b, Certificate& of_b) {
  const double clearance = checkers.clearance();
  const auto add = [&](Certificate& certificate, const MotionProof& seen) {
    if (clearance == 0.0) return add_proof(certificate, seen);
    add_proof(certificate, without_clearance(seen, clearance));
    add_clearance(certificate, seen, clearance);
  };
  if (a.task) add(of_a, proof);
  if (b.task) add(of_b, seen_from_other_robot(proof, *checkers.pair(a.robot, b.robot), checkers.names()[b.robot]));
}

void attach_certificate(Trajectory& motion, Certificate certificate, const std::string& robot,
                        const PlanStatistics& statistics) {
  if (!certificate.holds())
    throw Error("internal error: the trajectory found for '" + robot + "' is wrong (" +
                certificate.faults.front().text + "); nothing is returned. Please report this");
  certificate.bound = statistics.bound;
  certificate.bound_graph = statistics.bound_graph;
  motion.certificate = std::make_shared<const Certificate>(std::move(certificate));
}

MotionLimits scaled(MotionLimits limits, const CommonOptions& options) {
  const auto scale = [](Eigen::VectorXd& values, const std::string& what, double factor) {
    values *= factor;
    if (values.minCoeff() < min_motion_limit && factor < 1.0)
      throw InvalidArgument(what + "_scaling is " + to_text(factor) + ", which makes a limit of " +
                            to_text(values.minCoeff()) + "; limits must be " + to_text(min_motion_limit) + " or above");
  };
  scale(limits.velocity, "velocity", options.velocity_scaling);
  scale(limits.acceleration, "acceleration", options.acceleration_scaling);
  limits.jerk *= options.acceleration_scaling;
  return limits;
}

Trajectory with_times(Trajectory trajectory) {
  const Eigen::Index rows = trajectory.positions.rows();
  if (!trajectory.timed()) trajectory.times = Eigen::VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1));
  return trajectory;
}

}  // namespace srmp
