#pragma once

#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/knots.hpp"
#include "srmp/trajectory/rounded_path.hpp"

// The two methods of time parameterisation.
namespace srmp::detail {

/// Limits of links along a path: `fraction` of them counts.
struct LinkSpeedBounds {
  LinkSpeeds* speeds{};  // null: there are none
  double fraction{1.0};
};

/// Time-optimal; `start_speed` and `end_speed` are ds/dt. Limits of links are kept at grid points. Throws Error when
/// TOPP-RA finds no motion within the limits.
Knots time_with_toppra(const SmoothPath& path, const MotionLimits& limits, double start_speed, double end_speed,
                       const LinkSpeedBounds& links = {});

/// How a path is entered and left.
struct EndSpeeds {
  double start{}, end{};        // ds/dt
  double start_acceleration{};  // d^2s/dt^2; of jerk-limited motions alone

  bool at_rest() const { return start == 0.0 && end == 0.0 && start_acceleration == 0.0; }
};

/// Jerk-limited along one straight segment. Throws Error when Ruckig finds no motion within the limits.
Knots time_with_ruckig(const PathSegment& segment, const MotionLimits& limits, const EndSpeeds& ends);

/// The fastest jerk-limited stop on the straight line that begins at `start`, with this velocity and acceleration along
/// `direction`, whose length is 1. Throws Error when Ruckig finds none.
Knots stop_with_ruckig(const Eigen::VectorXd& start, const Eigen::VectorXd& direction, double speed,
                       double acceleration, const MotionLimits& limits);

/// srmp::time_parameterize with bounds of several robots; those of `limits` do not count.
Trajectory time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                             const MotionLimits& limits, const TimingOptions& options, RobotBounds& bounds);

}  // namespace srmp::detail
