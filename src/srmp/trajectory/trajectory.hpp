#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/trajectory/certificate.hpp"

namespace srmp {

/// Where a motion is at one instant; dof entries each.
struct MotionState {
  Eigen::VectorXd position;      ///< [rad or m]
  Eigen::VectorXd velocity;      ///< [rad/s or m/s]
  Eigen::VectorXd acceleration;  ///< [rad/s^2 or m/s^2]; where it jumps: just after
  Eigen::VectorXd jerk;          ///< [rad/s^3 or m/s^3]; where it jumps: just after
};

/// A motion: n rows of dof joints. Revolute joints in rad, prismatic ones in m. Values of continuous joints do not
/// jump: they run on past ±pi.
///
/// Between two rows each joint follows the cubic polynomial that has their positions and velocities (so does a ROS
/// joint_trajectory_controller that is given both), a straight line if there are no velocities. Every claim about the
/// motion, its limits and collisions, is about these polynomials.
struct Trajectory {
  std::vector<std::string> joint_names;  ///< dof
  RowMatrix positions;                   ///< n x dof [rad or m]
  RowMatrix velocities;                  ///< n x dof [rad/s or m/s]; no rows: not known
  RowMatrix accelerations;  ///< n x dof [rad/s^2 or m/s^2]; where it jumps: just after the row; no rows: not known
  Eigen::VectorXd times;    ///< n [s], strictly increasing; empty: a path without time
  RowMatrix waypoints;      ///< m x dof: the checked path, straight between rows
  std::shared_ptr<const Certificate> certificate{};  ///< null: none was made

  std::size_t size() const { return static_cast<std::size_t>(positions.rows()); }  ///< rows
  std::size_t dof() const { return joint_names.size(); }
  bool timed() const { return times.size() > 0; }
  double duration() const { return times.size() ? times[times.size() - 1] - times[0] : 0.0; }  ///< [s]
  /// Length of the motion: sum of the Euclidean norms of joint differences of rows [rad, prismatic joints m].
  double length() const;

  // All of these throw InvalidArgument for a trajectory without times or rows, and for NaN.

  /// Position at time t [s]. Times outside are moved to the nearest end.
  Eigen::VectorXd sample(double t) const;
  MotionState state(double t) const;
  /// n x dof: of the polynomial after each row, the last row's is that before it.
  RowMatrix jerks() const;

  /// Rows at every multiple of dt [s] from the start, and at the end. Another motion, near this one: the polynomials
  /// through the new rows. Throws InvalidArgument unless dt > 0 and there are at most ten million rows.
  Trajectory resample(double dt) const;
  /// The same motion from time `from` to `to` [s], with its times; cut between rows where needed. Throws
  /// InvalidArgument unless from < to and the two overlap the motion.
  Trajectory slice(double from, double to) const;
  /// This motion and then `next`, whose times are moved to follow. Throws InvalidArgument unless joint names agree and
  /// `next` starts where this ends: positions within 1e-9, velocities within 1e-6.
  Trajectory followed_by(const Trajectory& next) const;
};

}  // namespace srmp
