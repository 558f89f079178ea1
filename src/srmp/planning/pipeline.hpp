#pragma once

#include "srmp/core/error.hpp"
#include "srmp/planning/problem.hpp"
#include "srmp/trajectory/multi_trajectory.hpp"

namespace srmp {

/// Plans: endpoints (checks, inverse kinematics, start recovery), path search by the strategies that the options name,
/// smoothing, timing, certificate; the same steps for one robot and for many. Motions of stationary robots are part of
/// the result. Motions among moving obstacles begin when those let them pass, or are planned in time around them
/// (obstacles/moving_obstacles.hpp).
///
/// Fills the statistics, whether it finds motions or throws PlanningError. Throws Error when a certificate does not
/// hold: nothing is returned then.
MultiTrajectory run_pipeline(const PlanProblem& problem, const Deadline& deadline, PlanStatistics& statistics);

/// Fills what the statistics say of a plan that ends with this error.
void record_failure(const PlanningError& error, const Deadline& deadline, PlanStatistics& statistics);

}  // namespace srmp
