#pragma once

#include <functional>
#include <string>
#include <vector>

#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/timing_options.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// The path in time, as fast as velocity and acceleration limits (TimingMethod::ruckig: and jerk limits) allow.
///
/// TimingMethod::toppra: a corner becomes a parabola between the points at the same (scaled) distance before and after
/// it, whose tangents are those of the path; a quarter of the distance between these points and the corner is the
/// farthest that it leaves the path. It takes up no more than half of a segment. Along the rounded path TOPP-RA (Pham,
/// Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis", 2018) finds the fastest
/// motion.
///
/// TimingMethod::ruckig: every straight segment is travelled from rest to rest as one scalar problem along the segment
/// (Berscheid, Kröger, "Jerk-limited Real-time Trajectory Generation with Arbitrary Target States", RSS 2021), with the
/// largest speed, acceleration and jerk that keep every joint within its own.
///
/// Either way the limits hold at every instant of the polynomials between the rows, not at rows alone. First and last
/// row are the first and last waypoint, bit for bit, at rest unless velocities are given. Waypoints nearer than 1e-7
/// to the one before are left out, except the last. Any motion takes 1 ms or more, however short; a path of equal
/// waypoints gives one row at time 0.
///
/// `waypoints` is m x dof. Throws InvalidArgument when it is empty or holds NaN, when a size does not match the joint
/// names, when a limit or option is out of range, when a continuous joint does not go the short way, when a start or
/// end velocity is above its limit, not along the path, or cannot be had within the limits, or when there would be
/// more than TimingOptions::max_rows rows.
/// Throws PlanningError with Status::timed_out or Status::cancelled when the deadline of the options has passed and
/// timing takes long: a thousand rows or more.
Trajectory time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                             const MotionLimits& limits, const TimingOptions& options = {});

}  // namespace srmp
