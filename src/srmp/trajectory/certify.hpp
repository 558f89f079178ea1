#pragma once

#include <limits>
#include <optional>

#include "srmp/collision/checker.hpp"
#include "srmp/collision/motion_proof.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

struct CertifyOptions {
  bool limits{true};      ///< hold velocities and accelerations against their limits
  bool jerk{false};       ///< hold the motion against the jerk limits too
  bool collisions{true};  ///< look for collisions
  /// [s] what comes before is not held against collisions: the way out of a start in collision.
  double free_from{-std::numeric_limits<double>::infinity()};
  double gap_tolerance{0.5};   ///< of the clearance proved: ProofOptions::gap_tolerance, above 0
  bool at_rest{true};          ///< a velocity at the ends is a fault
  const Deadline* deadline{};  ///< once it passes, what is not proved yet goes to Certificate::sampled; null: none
};

/// Why a trajectory cannot be looked over: joint names, arrays that do not fit together, numbers that are not finite or
/// polynomials that overflow, times that do not increase. None: it can.
std::optional<Fault> unreadable(const Trajectory& trajectory, const RobotModel& robot);

/// Looks a trajectory over, whoever made it, by code that plans nothing: the polynomials' extrema against every limit
/// (to 1e-6 of it, or to what rounded positions let be known), the motion against everything that it could hit
/// (prove_motion), and its distance from its waypoints. Faults are found, not thrown; a trajectory that is
/// unreadable is not looked at further. Best with a checker of CheckMode::coal,
/// which has nothing in common with the one that planned.
Certificate certify(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
                    const CertifyOptions& options = {});

/// What a proof says of a motion, taken into the certificate of that motion.
void add_proof(Certificate& certificate, const MotionProof& proof);

}  // namespace srmp
