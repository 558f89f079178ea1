#pragma once

#include <limits>
#include <optional>

#include "srmp/collision/checker.hpp"
#include "srmp/collision/motion_proof.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

struct CertifyOptions {
  bool limits{true};      ///< check velocities and accelerations against their limits
  bool jerk{false};       ///< check the jerk limits too
  bool collisions{true};  ///< check for collisions
  /// [s] what comes before is not checked for collisions: the recovery from a start in collision.
  double free_from{-std::numeric_limits<double>::infinity()};
  double gap_tolerance{0.5};             ///< of the clearance proved: ProofOptions::gap_tolerance, in (0, 1)
  bool at_rest{true};                    ///< a velocity at the ends is a fault
  Eigen::VectorXd start_velocity{};      ///< (dof,) with which it should begin; empty: as at_rest says
  Eigen::VectorXd start_acceleration{};  ///< (dof,) before the motion, with at_rest; empty: 0
  const Deadline* deadline{};  ///< once it passes, what is not proved yet goes to Certificate::sampled; null: none
};

/// Why a trajectory cannot be verified: joint names, arrays that do not fit together, numbers that are not finite or
/// polynomials that overflow, times that do not increase. None: it can.
std::optional<Fault> unreadable(const Trajectory& trajectory, const RobotModel& robot);

/// Verifies a trajectory, whoever made it, by code that is no part of planning: the extrema of its polynomials against
/// every limit (to 1e-6 of it, or as far as the rounding of positions and times allows), the motion against everything
/// that it could hit (prove_motion), and its deviation from its waypoints. Faults are returned, not thrown; an
/// unreadable trajectory is not verified further. Best with a checker of CheckMode::coal, which shares no sphere and no
/// table with the one that planned. Throws InvalidArgument for limits and options out of range, and, where collisions
/// are to be checked, for a checker that is not the library's own.
Certificate certify(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
                    const CertifyOptions& options = {});

/// Adds the results of a proof to the certificate of the motion: the smaller clearance counts, faults and unproved
/// parts are appended.
void add_proof(Certificate& certificate, const MotionProof& proof);

}  // namespace srmp
