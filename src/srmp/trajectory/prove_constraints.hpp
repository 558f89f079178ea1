#pragma once

#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/placed_constraints.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Adds to the certificate of a timed trajectory how far it goes, at most, from what each path constraint asks for, and
/// a fault for each that it is not proved to keep. Throws PlanningError (timed_out, cancelled) at the deadline.
void add_constraints(Certificate& certificate, const Trajectory& trajectory, const PlacedConstraints& constraints,
                     const Deadline& deadline);

/// Whether no path constraint is broken.
bool keeps_constraints(const Certificate& certificate);

}  // namespace srmp
