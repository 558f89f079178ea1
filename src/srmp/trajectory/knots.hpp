#pragma once

#include <string>
#include <vector>

#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/timing_options.hpp"
#include "srmp/trajectory/trajectory.hpp"

// Motions in time, before they become rows of a trajectory.
namespace srmp::detail {

/// Knots of a motion, which follows cubics between them.
struct Knots {
  std::vector<double> times;  // [s], from 0
  std::vector<Eigen::VectorXd> positions, velocities;

  void add(double time, Eigen::VectorXd position, Eigen::VectorXd velocity) {
    times.push_back(time);
    positions.push_back(std::move(position));
    velocities.push_back(std::move(velocity));
  }
};

/// The largest fraction of a limit that the cubics use, as far as the rounding of positions allows to know it: the
/// factor by which time must be stretched.
double limit_use(const Knots& knots, const MotionLimits& limits, bool with_jerk);

/// Rows at the knots and at the multiples of the sample period between them, all of the same cubics. Throws
/// PlanningError when it takes long and the deadline of the options passes.
Trajectory to_rows(const Knots& knots, const std::vector<std::string>& joint_names, ConstRows waypoints,
                   const TimingOptions& options);

/// Throws PlanningError once the deadline of the options has passed.
void stop_if_late(const TimingOptions& options);

}  // namespace srmp::detail
