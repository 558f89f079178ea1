#include "srmp/planning/certificates/verify_together.hpp"

#include <optional>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/prove_clearance.hpp"
#include "srmp/trajectory/prove_collision_free.hpp"

namespace srmp {

namespace {

using Motions = std::map<std::string, Trajectory>;

std::unique_ptr<const Checker> without(const Scene& scene, const std::string& robot, const Motions& others,
                                       double clearance = 0.0) {
  CheckerOptions options{.mode = CheckMode::coal, .clearance = clearance};
  for (const auto& [name, other] : others)
    if (name != robot) options.excluded_robots.push_back(name);
  return make_checker(scene, robot, options);
}

std::unique_ptr<const Checker> beside(const Scene& scene, const std::string& robot, const std::string& other,
                                      double clearance = 0.0) {
  return make_checker(
      scene, robot,
      {.mode = CheckMode::coal, .other_robots = {other}, .other_robots_only = true, .clearance = clearance});
}

/// Why a motion cannot be verified against others; nothing: it can.
std::optional<Fault> unfitness(const Trajectory& motion, const RobotModel& robot) {
  if (auto fault = unreadable(motion, robot)) return fault;
  const double begin = motion.times[0];
  if (begin == 0.0) return std::nullopt;
  const std::string text = "the trajectory begins at " + to_text(begin) + " s; motions on one clock begin at time 0";
  return Fault{FaultKind::times, text, begin};
}

}  // namespace

Certificate certify_among(const Scene& scene, const std::string& robot, const Trajectory& motion, const Motions& others,
                          const MotionLimits& limits, const CertifyOptions& options) {
  Certificate certificate = certify(motion, *without(scene, robot, others), limits, options);
  for (const auto& [name, other] : others)
    add_proof(certificate, prove_collision_free(*beside(scene, robot, name), motion, other,
                                                {options.gap_tolerance, options.deadline}));
  return certificate;
}

MotionsTogether::MotionsTogether(const Scene& scene, const Motions& motions, const Options& options)
    : scene_(scene), motions_(motions), options_(options) {
  require_clearance(options.clearance);
  for (const auto& [name, motion] : motions)
    if (const auto fault = unfitness(motion, *scene.robot(name).model)) unfit_.emplace(name, *fault);
}

const MotionProof& MotionsTogether::proof(const std::string& robot, const std::string& other) {
  return known_or_made(proofs_, robot, other, 0.0);
}

/// The proof ends where the clearance is first broken; how near the two really come, the other proof knows.
MotionProof MotionsTogether::clearance_proof(const std::string& robot, const std::string& other) {
  MotionProof kept = known_or_made(clearance_proofs_, robot, other, options_.clearance);
  const MotionProof& nearest = proof(robot, other);
  if (kept.free || nearest.clearance - options_.clearance >= kept.clearance) return kept;
  kept.clearance = nearest.clearance - options_.clearance;
  kept.time = nearest.time;
  kept.body_a = nearest.body_a;
  kept.body_b = nearest.body_b;
  return kept;
}

const MotionProof& MotionsTogether::known_or_made(Proofs& proofs, const std::string& robot, const std::string& other,
                                                  double clearance) {
  if (const auto known = proofs.find({robot, other}); known != proofs.end()) return known->second;
  const std::unique_ptr<const Checker> checker = beside(scene_, robot, other, clearance);
  const MotionProof proof =
      prove_collision_free(*checker, motions_.at(robot), motions_.at(other), {.gap_tolerance = options_.gap_tolerance});
  proofs.emplace(std::pair(other, robot), seen_from_other_robot(proof, *checker, other));
  return proofs.emplace(std::pair(robot, other), proof).first->second;
}

Certificate MotionsTogether::verify(const std::string& robot, const MotionLimits& limits, const VerifyOptions& options,
                                    std::shared_ptr<const PlacedConstraints> constraints) {
  PlacedVerifyOptions placed{.constraints = std::move(constraints)};
  if (options_.clearance > 0.0) placed.with_clearance = without(scene_, robot, motions_, options_.clearance);
  Certificate certificate =
      srmp::verify(motions_.at(robot), *without(scene_, robot, motions_), limits, options, placed);
  if (!certificate.collisions_checked) return certificate;
  if (const auto unfit = unfit_.find(robot); unfit != unfit_.end()) {
    certificate.faults.push_back(unfit->second);
    return certificate;
  }
  for (const auto& [name, other] : motions_) {
    if (name == robot) continue;
    if (const auto unfit = unfit_.find(name); unfit != unfit_.end()) {
      const Fault& its = unfit->second;
      certificate.faults.push_back({its.kind, "'" + name + "' cannot be kept clear of: " + its.text, its.time});
    } else {
      add_proof(certificate, proof(robot, name));
      if (options_.clearance > 0.0) add_clearance(certificate, clearance_proof(robot, name), options_.clearance);
    }
  }
  return certificate;
}

}  // namespace srmp
