#pragma once

#include <functional>
#include <string>
#include <vector>

#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// How a path becomes a motion in time.
enum class TimingMethod {
  toppra,  ///< time-optimal along the path with rounded corners; accelerations may jump (Pham, Pham 2018)
  ruckig,  ///< jerk-limited, from rest to rest between corners, on the path itself (Berscheid, Kröger 2021)
};

/// Options of time_parameterize.
struct TimingOptions {
  TimingMethod method{TimingMethod::toppra};  ///< how the path is timed
  double sample_period{0.02};  ///< [s], > 0: there is a row at every multiple of it, or less than 0.5 ms from it
  /// Corners are rounded so that no point of the robot leaves the path by more than this [m], >= 0; 0: a stop at each.
  double blend_deviation{0.005};
  /// How far a unit of each joint moves any point of the robot, at most [m/rad, prismatic joints 1] (Checker::reach);
  /// empty: 1 each.
  Eigen::VectorXd reach{};
  /// Is the straight motion from one configuration to another free? Called for the chords of rounded corners, which
  /// shrink until it says yes. Empty: all is free.
  std::function<bool(const Eigen::VectorXd&, const Eigen::VectorXd&)> is_free{};
  Eigen::VectorXd start_velocity{};  ///< dof [rad/s or m/s], along the first segment; empty: at rest
  Eigen::VectorXd end_velocity{};    ///< the same along the last segment
};

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
/// more than ten million rows.
Trajectory time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                             const MotionLimits& limits, const TimingOptions& options = {});

}  // namespace srmp
