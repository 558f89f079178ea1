#pragma once

#include "srmp/planning/problem.hpp"
#include "srmp/trajectory/multi_trajectory.hpp"

namespace srmp {

/// Moves the stationary robots of a problem to their starts in its scene, if those are within limits; starts that miss
/// a limit by at most limit_tolerance are moved onto it.
void stand_at_starts(Scene& scene, std::vector<RobotProblem>& stationary);

/// Throws PlanningError, start_invalid, for the first stationary robot of the problem whose start is outside its
/// limits, in self-collision, or in collision with what stands still.
void require_stationary_starts(const PlanProblem& problem);

/// Adds the stationary robots to the others' motions, with certificates that cover those and the moving obstacles, if
/// the options ask for certificates.
void add_stationary_robots(const PlanProblem& problem, MultiTrajectory& motions, const Deadline& deadline,
                           PlanStatistics& statistics);

}  // namespace srmp
