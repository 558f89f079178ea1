#pragma once

#include <string>
#include <vector>

#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// The path in time, with bounded velocity, acceleration and jerk.
///
/// Every straight segment is travelled from rest to rest as one scalar problem along the segment (Ruckig; Berscheid and
/// Kröger, "Jerk-limited Real-time Trajectory Generation with Arbitrary Target States", RSS 2021), with the largest
/// speed, acceleration and jerk that keep every joint within its own. So the motion never leaves the checked path,
/// every limit holds at every instant, and it is as fast as possible under the condition that it stops at every corner.
///
/// Samples: every multiple of `sample_period` [s], and the exact end of every segment. First and last row are the first
/// and last waypoint, bit for bit, at rest. A segment takes 1 µs or more, however short; a waypoint that repeats its
/// predecessor takes no time, so a path of equal waypoints gives one sample at time 0.
///
/// `waypoints` is m x dof. Throws InvalidArgument when it is empty or holds NaN, when a size does not match the joint
/// names, when a limit or the period is not above 0, when a continuous joint does not go by the short way, or when
/// there would be more than ten million samples.
Trajectory time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                             const MotionLimits& limits, double sample_period = 0.01);

}  // namespace srmp
