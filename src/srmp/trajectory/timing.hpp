#pragma once

#include <vector>

#include "srmp/trajectory/rounded_path.hpp"

// The two methods of time parameterisation.
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

/// Time-optimal; `start_speed` and `end_speed` are ds/dt. Throws Error when TOPP-RA finds no motion within the limits.
Knots time_with_toppra(const SmoothPath& path, const MotionLimits& limits, double start_speed, double end_speed);

/// Jerk-limited along one straight segment. Throws Error when Ruckig finds no motion within the limits.
Knots time_with_ruckig(const PathSegment& segment, const MotionLimits& limits, double start_speed, double end_speed);

}  // namespace srmp::detail
