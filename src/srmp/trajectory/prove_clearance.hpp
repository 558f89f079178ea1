#pragma once

#include "srmp/collision/motion_proof.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Adds to the certificate of a timed trajectory how it keeps the clearance of a checker (CheckerOptions::clearance >
/// 0, of the library's own kind), and a fault where it does not. From the first row that keeps it to the last one, the
/// motion is proved to keep it (prove_motion). Before and after, it is checked at samples that no pair that is closer
/// comes closer still on its way from the start, or back from the end, and that no other pair comes closer than the
/// clearance. What is not proved once the deadline has passed goes to Certificate::sampled.
void add_clearance(Certificate& certificate, const Trajectory& trajectory, const Checker& checker,
                   const Deadline& deadline);

/// The same of a proof (with ProofOptions of any kind) that two robots keep a clearance [m] all along, by a checker
/// with that clearance; near the ends too. Adds what it did not prove to Certificate::sampled.
void add_clearance(Certificate& certificate, const MotionProof& proof, double required);

/// What such a proof says of contacts, as add_proof takes it: distances are larger by the clearance. What it did not
/// prove is left out.
MotionProof without_clearance(MotionProof proof, double required);

/// Whether no required clearance is broken.
bool keeps_clearance(const Certificate& certificate);

}  // namespace srmp
