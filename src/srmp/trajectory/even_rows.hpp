#pragma once

#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/timing_options.hpp"

namespace srmp {

/// The motion with rows at multiples of 1/rate [s] and nowhere else: the uniform cubic B-spline (de Boor, "A Practical
/// Guide to Splines", 1978) whose control points are where the motion is at these times. Its acceleration does not
/// jump. First, second and third differences of the control points are averages of the motion's velocity, acceleration
/// and jerk, so it keeps the limits that the motion keeps; it is slower where rounding or a link's speed require it. It
/// takes up to three rows longer, keeps near the motion, and on it where that is straight; both ends are the motion's,
/// bit for bit. The motion begins and ends at rest. TimingMethod::ruckig of the options: the jerk limits count. Throws
/// InvalidArgument for more than TimingOptions::max_rows rows, and PlanningError at the deadline of the options.
Trajectory with_even_rows(const Trajectory& motion, double rate, const MotionLimits& limits, RobotBounds& bounds,
                          const TimingOptions& options);

}  // namespace srmp
