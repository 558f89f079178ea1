#include "srmp/planning/certificates/certify_together.hpp"

#include "srmp/planning/certificates/verify.hpp"
#include "srmp/planning/post_process.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/prove_collision_free.hpp"

namespace srmp {

namespace {

Certificate certify_alone(const Checker& judge, const MultiRobotPart& part, const Trajectory& motion,
                          const CommonOptions& options, const Deadline& until) {
  Certificate certificate = certify(numbered(motion), judge, scaled(part.limits, options),
                                    {.limits = motion.timed(), .jerk = options.timing == "ruckig", .deadline = &until});
  if (part.goal.type != GoalType::any)
    certificate.goal_error = goal_error({part.goal}, judge, motion.positions.bottomRows(1).transpose()).error;
  return certificate;
}

}  // namespace

std::vector<Certificate> certify_together(const GroupCheckers& judges, const std::vector<MovingPart>& moving,
                                          const CommonOptions& options, const Deadline& until) {
  std::vector<Certificate> certificates;
  for (const auto& [robot, part, motion] : moving)
    certificates.push_back(part ? certify_alone(judges.alone(robot), *part, motion, options, until) : Certificate{});
  for (std::size_t i = 0; i < moving.size(); ++i)
    for (std::size_t j = i + 1; j < moving.size(); ++j)
      if (const auto proof = prove_pair(judges, moving[i], moving[j], until))
        add_pair_proof(judges, *proof, moving[i], certificates[i], moving[j], certificates[j]);
  return certificates;
}

std::optional<MotionProof> prove_pair(const GroupCheckers& judges, const MovingPart& a, const MovingPart& b,
                                      const Deadline& until) {
  const Checker* judge = judges.pair(a.robot, b.robot);
  if (!judge || (!a.part && !b.part)) return std::nullopt;
  return prove_collision_free(*judge, numbered(a.motion), numbered(b.motion), {0.5, &until});
}

void add_pair_proof(const GroupCheckers& judges, const MotionProof& proof, const MovingPart& a, Certificate& of_a,
                    const MovingPart& b, Certificate& of_b) {
  if (a.part) add_proof(of_a, proof);
  if (b.part) add_proof(of_b, seen_from_other_robot(proof, *judges.pair(a.robot, b.robot), judges.names()[b.robot]));
}

void seal(Trajectory& motion, Certificate certificate, const std::string& robot, const PlanStatistics& statistics) {
  if (!certificate.holds())
    throw Error("internal error: the trajectory found for '" + robot + "' is wrong (" +
                certificate.faults.front().text + "); nothing is returned. Please report this");
  certificate.bound = statistics.bound;
  certificate.bound_graph = statistics.bound_graph;
  motion.certificate = std::make_shared<const Certificate>(std::move(certificate));
}

}  // namespace srmp
