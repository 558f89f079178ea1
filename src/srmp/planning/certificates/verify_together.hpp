#pragma once

#include <map>
#include <string>

#include "srmp/planning/certificates/verify.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/trajectory/prove_collision_free.hpp"

namespace srmp {

// Certificates of robots of a scene that move on one clock from time 0 on, and rest where their motions end: each by
// itself among robots that stand still, and then against every other. By Coal alone.

/// certify of one robot. `others`, by robot name, are whole, and all motions have times.
Certificate certify_among(const Scene& scene, const std::string& robot, const Trajectory& motion,
                          const std::map<std::string, Trajectory>& others, const MotionLimits& limits,
                          const CertifyOptions& options);

/// verify of any motions.
class MotionsTogether {
 public:
  /// Of proofs of two, as in VerifyOptions.
  struct Options {
    double gap_tolerance{0.5};
    double clearance{0.0};  ///< [m]
  };

  /// By robot name; references outlive this. Throws InvalidArgument for a robot that is not in the scene and for a
  /// clearance that is not 0 or above.
  MotionsTogether(const Scene& scene, const std::map<std::string, Trajectory>& motions, const Options& options);

  /// Of one of the robots. A motion of another one that cannot be read, or does not begin at time 0, is a fault too.
  Certificate verify(const std::string& robot, const MotionLimits& limits, const VerifyOptions& options,
                     std::shared_ptr<const PlacedConstraints> constraints = {});

 private:
  using Proofs = std::map<std::pair<std::string, std::string>, MotionProof>;
  /// Of two robots, as the first one's checker names the bodies; made once for both.
  const MotionProof& proof(const std::string& robot, const std::string& other);
  MotionProof clearance_proof(const std::string& robot, const std::string& other);
  const MotionProof& known_or_made(Proofs& proofs, const std::string& robot, const std::string& other,
                                   double clearance);

  const Scene& scene_;
  const std::map<std::string, Trajectory>& motions_;
  const Options options_;
  Proofs proofs_, clearance_proofs_;
  std::map<std::string, Fault> unfit_;  // why a motion cannot be verified against others
};

}  // namespace srmp
