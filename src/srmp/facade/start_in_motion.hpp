#pragma once

#include "srmp/planning/problem.hpp"
#include "srmp/trajectory/timing_options.hpp"

namespace srmp {

/// Throws InvalidArgument for a velocity or acceleration at the start that has a wrong size, is not finite, is above
/// its limit, or cannot be continued by the planner's timing.
void require_start_in_motion(const PlanRequest& request, const PlacedRobot& placed, const MotionLimits& limits,
                             const CommonOptions& options);

/// Throws NotSupported where the options have a sample rate.
void require_no_sample_rate(const CommonOptions& options, const std::string& what);

/// Where the motion of a request that begins in motion goes first: straight ahead, until it could stop.
void begin_in_motion(RobotProblem& robot, const PlanRequest& request, const CommonOptions& options);

/// The planner's timing. A path without time (`none`) cannot begin in motion: InvalidArgument.
TimingMethod timing_in_motion(const CommonOptions& options);

}  // namespace srmp
