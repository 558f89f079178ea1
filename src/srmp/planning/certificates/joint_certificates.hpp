#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/planning/problem.hpp"

namespace srmp {

/// A robot's motion on the clock of the others.
struct RobotMotion {
  std::size_t robot;         ///< its index among the checkers
  const RobotProblem* task;  ///< null: a moving obstacle, which needs no certificate
  const Trajectory& motion;
  /// Segments of the waypoints that lead out of a start in collision, and are not checked for collisions.
  std::size_t recovery_segments{0};
};

/// Certificates of robots that move on one clock: of each by itself, and of each two against each other. In the order
/// of `motions`, whose indices increase; without bounds; empty for moving obstacles. Once the deadline passes, what is
/// not proved yet goes to Certificate::sampled. `checkers`: of all these robots, by Coal alone. `with_clearance`: the
/// same with the clearance that they have to keep; null: none. References outlive the call.
std::vector<Certificate> joint_certificates(const GroupCheckers& checkers, const GroupCheckers* with_clearance,
                                            const std::vector<RobotMotion>& motions, const CommonOptions& options,
                                            const Deadline& until);

/// The proof that two robots do not collide, a.robot < b.robot, or that they keep the checkers' clearance; nothing:
/// they cannot reach each other, or neither needs a certificate.
std::optional<MotionProof> prove_pair(const GroupCheckers& checkers, const RobotMotion& a, const RobotMotion& b,
                                      const Deadline& until);
/// Adds that proof, by the same checkers, to the certificates of both.
void add_pair_proof(const GroupCheckers& checkers, const MotionProof& proof, const RobotMotion& a, Certificate& of_a,
                    const RobotMotion& b, Certificate& of_b);

/// Gives the certificate to the motion, with the bound of the plan. Throws Error when it does not hold: then what was
/// planned is wrong.
void attach_certificate(Trajectory& motion, Certificate certificate, const std::string& robot,
                        const PlanStatistics& statistics);

/// The fractions of the limits that the options allow.
MotionLimits scaled(MotionLimits limits, const CommonOptions& options);

/// With times where it has none, one a row: a certificate needs times.
Trajectory with_times(Trajectory trajectory);

}  // namespace srmp
