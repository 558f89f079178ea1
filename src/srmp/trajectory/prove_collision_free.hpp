#pragma once

#include <string>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// [s]: the time of its last row.
double end_of(const Trajectory& motion);

/// prove_motion of two robots that move at once, each by its own rows: `a` and then `b`, whose joints stand in this
/// order in the judge's configurations. Both have times, which begin at 0; one whose own times are over rests where it
/// ended, however fast it came. Velocities may jump there, and at the rows of a motion without velocities: those are
/// straight.
MotionProof prove_collision_free(const Checker& judge, const Trajectory& a, const Trajectory& b,
                                 const ProofOptions& options = {});

/// What `judge` proved of its robot and `companion`, as the companion's own judge names the bodies.
MotionProof seen_from_other_robot(MotionProof proof, const Checker& judge, const std::string& companion);

}  // namespace srmp
