#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/planning/multi_robot.hpp"

namespace srmp {

/// A robot's motion on the clock of the others.
struct MovingPart {
  std::size_t robot;           ///< its number among the judges
  const MultiRobotPart* part;  ///< null: it is committed, and needs no certificate
  const Trajectory& motion;
};

/// Certificates of robots that move together, by judges that know all of them: each by itself, and each two against
/// each other, numbers increasing. In their order, without bounds; those of committed robots are empty. Once the
/// deadline passes, what is not proved yet goes to Certificate::sampled. References outlive the call.
std::vector<Certificate> certify_together(const GroupCheckers& judges, const std::vector<MovingPart>& moving,
                                          const CommonOptions& options, const Deadline& until);

/// What two robots do to each other, a.robot < b.robot; nothing: they never meet, or neither needs a certificate.
std::optional<MotionProof> prove_pair(const GroupCheckers& judges, const MovingPart& a, const MovingPart& b,
                                      const Deadline& until);
/// Adds that to the certificates of both.
void add_pair_proof(const GroupCheckers& judges, const MotionProof& proof, const MovingPart& a, Certificate& of_a,
                    const MovingPart& b, Certificate& of_b);

/// Gives it to the motion, with the bound of the plan. Throws Error when it does not hold: what was planned is wrong.
void seal(Trajectory& motion, Certificate certificate, const std::string& robot, const PlanStatistics& statistics);

}  // namespace srmp
