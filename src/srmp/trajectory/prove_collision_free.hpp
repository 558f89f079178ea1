#pragma once

#include <string>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// [s]: the time of its last row.
double end_of(const Trajectory& motion);

/// prove_motion of two robots that move simultaneously: `a` and `b`, whose joints come in this order in the checker's
/// configurations. Both have times, which begin at 0; a robot whose own times are over stays where it ended, even if it
/// arrived with a velocity. Velocities may jump there, and at the rows of a motion without velocities, which is
/// straight between them.
MotionProof prove_collision_free(const Checker& checker, const Trajectory& a, const Trajectory& b,
                                 const ProofOptions& options = {});

/// A proof by `checker` about its robot and `other_robot`, with the bodies named as a checker of the other robot names
/// them.
MotionProof seen_from_other_robot(MotionProof proof, const Checker& checker, const std::string& other_robot);

}  // namespace srmp
