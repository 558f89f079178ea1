#include "srmp/planner/multi_arm/among_others.hpp"

#include <optional>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/prove_apart.hpp"

namespace srmp {

namespace {

using Motions = std::map<std::string, Trajectory>;

Checker without(const Scene& scene, const std::string& robot, const Motions& others) {
  CheckerOptions options{.mode = CheckMode::coal};
  for (const auto& [name, other] : others)
    if (name != robot) options.absent.push_back(name);
  return Checker(scene, robot, options);
}

void add_proof_against(const std::string& other, const Trajectory& its, const Scene& scene, const std::string& robot,
                       const Trajectory& motion, const ProofOptions& options, Certificate& certificate) {
  const Checker judge(scene, robot, {.mode = CheckMode::coal, .companions = {other}, .companions_only = true});
  add_proof(certificate, prove_apart(judge, motion, its, options));
}

/// Why a motion cannot be held against others; nothing: it can.
std::optional<Fault> unfitness(const Trajectory& motion, const Checker& checker) {
  const Certificate certificate =
      certify(motion, checker, default_limits(checker.robot()), {.limits = false, .collisions = false});
  for (const Fault& fault : certificate.faults)
    if (fault.kind == FaultKind::joint_names || fault.kind == FaultKind::shape || fault.kind == FaultKind::not_finite ||
        fault.kind == FaultKind::times)
      return fault;
  const double begin = motion.times[0];
  if (begin == 0.0) return std::nullopt;
  const std::string text = "the trajectory begins at " + to_text(begin) + " s; motions on one clock begin at time 0";
  return Fault{FaultKind::times, text, begin};
}

}  // namespace

Certificate certify_among(const Scene& scene, const std::string& robot, const Trajectory& motion, const Motions& others,
                          const MotionLimits& limits, const CertifyOptions& options) {
  Certificate certificate = certify(motion, without(scene, robot, others), limits, options);
  for (const auto& [name, other] : others)
    add_proof_against(name, other, scene, robot, motion, {options.tightness, options.deadline}, certificate);
  return certificate;
}

MotionsTogether::MotionsTogether(const Scene& scene, const Motions& motions) : scene_(scene), motions_(motions) {
  for (const auto& [name, motion] : motions)
    if (const auto fault = unfitness(motion, Checker(scene, name, {.mode = CheckMode::coal})))
      unfit_.emplace(name, *fault);
}

Certificate MotionsTogether::verify(const std::string& robot, const MotionLimits& limits,
                                    const VerifyOptions& options) const {
  const Trajectory& motion = motions_.at(robot);
  Certificate certificate = srmp::verify(motion, without(scene_, robot, motions_), limits, options);
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
      add_proof_against(name, other, scene_, robot, motion, {.tightness = options.tightness}, certificate);
    }
  }
  return certificate;
}

}  // namespace srmp
