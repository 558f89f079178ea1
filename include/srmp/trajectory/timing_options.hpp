#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>

#include "srmp/core/deadline.hpp"

namespace srmp {

struct PlacedRobot;

/// How a path becomes a motion in time.
enum class TimingMethod {
  toppra,  ///< time-optimal along the path with rounded corners; accelerations may jump (Pham, Pham 2018)
  ruckig,  ///< jerk-limited, from rest to rest between corners, on the path itself (Berscheid, Kröger 2021)
};

/// Options of time_parameterize.
struct TimingOptions {
  TimingMethod method{TimingMethod::toppra};  ///< how the path is timed
  double sample_period{0.02};        ///< [s], > 0: there is a row at every multiple of it, or less than 0.5 ms from it
  std::size_t max_rows{10'000'000};  ///< a sample period that gives more is refused
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
  /// dof [rad/s^2 or m/s^2], along the first segment; empty: 0. Of TimingMethod::ruckig: other accelerations may jump.
  Eigen::VectorXd start_acceleration{};
  /// Whose joints these are, in its order: for MotionLimits::link_speeds; null: there are none.
  std::shared_ptr<const PlacedRobot> robot{};
  const Deadline* deadline{};  ///< once it passes, a long time_parameterize throws PlanningError; null: none
};

}  // namespace srmp
