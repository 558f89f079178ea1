#pragma once

#include "srmp/trajectory/timing_options.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// How far the robot goes when it stops as fast as the limits allow on the straight line of its velocity, (dof,) [rad
/// or m]: zero where it is at rest. TimingMethod::ruckig keeps the jerk limits too, from the acceleration on, which has
/// the direction of the velocity.
Eigen::VectorXd straight_stop(const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration,
                              const MotionLimits& limits, TimingMethod method);

/// The motion on the same path from time t [s] on, on which the robot brakes as hard as the limits allow at every
/// instant; its times begin at 0. A t within 1 µs of a row of the motion is that row's time. TimingMethod::ruckig keeps
/// the jerk limits too; it needs a path that is straight until the stop. Of the options method, sample period and
/// deadline count. Throws InvalidArgument for a t outside the motion, a motion without times or velocities, limits that
/// it exceeds at t, and one that ends before the robot can stop; and NotSupported for a path that is not straight.
Trajectory stop_on_path(const Trajectory& motion, double t, const MotionLimits& limits, const TimingOptions& options);

}  // namespace srmp
