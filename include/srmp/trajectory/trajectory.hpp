#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/trajectory/certificate.hpp"

namespace srmp {

/// Where a motion is at one instant; dof entries each.
struct MotionState {
  Eigen::VectorXd position;      ///< [rad or m]
  Eigen::VectorXd velocity;      ///< [rad/s or m/s]; where it jumps: just after
  Eigen::VectorXd acceleration;  ///< [rad/s^2 or m/s^2]; where it jumps: just after
  Eigen::VectorXd jerk;          ///< [rad/s^3 or m/s^3]; where it jumps: just after
};

/// A robot and its placement in the world: what forward kinematics needs besides a configuration.
struct PlacedRobot {
  std::shared_ptr<const RobotModel> model;  ///< its immutable model
  Pose base{};                              ///< of the root link, in the world
  Eigen::VectorXd other_positions{};        ///< of RobotModel::other_joints [rad or m]; empty: at their defaults

  bool operator==(const PlacedRobot& other) const;
};

/// A motion: n rows of dof joints. Revolute joints in rad, prismatic ones in m. Values of continuous joints do not
/// jump: they run on past ±pi.
///
/// Between two rows each joint follows the cubic polynomial that has their positions and velocities (so does a ROS
/// joint_trajectory_controller that is given both), a straight line if there are no velocities. Every claim about the
/// motion, its limits and collisions, is about these polynomials. At a row the motion has what the row says, bit for
/// bit.
///
/// Files (CSV, JSON), dictionaries and figures of trajectories are made by the Python package.
struct Trajectory {
  std::vector<std::string> joint_names{};  ///< dof
  RowMatrix positions{};                   ///< n x dof [rad or m]
  RowMatrix velocities{};                  ///< n x dof [rad/s or m/s]; no rows: not known
  RowMatrix accelerations{};  ///< n x dof [rad/s^2 or m/s^2]; where it jumps: just after the row; no rows: not known
  Eigen::VectorXd times{};    ///< n [s], strictly increasing; empty: a path without time
  RowMatrix waypoints{};      ///< m x dof: the checked path, straight between rows; no rows: not known
  std::shared_ptr<const Certificate> certificate{};  ///< null: none was made
  std::shared_ptr<const PlacedRobot> robot{};        ///< for which it was planned; null: not known

  std::size_t size() const { return static_cast<std::size_t>(positions.rows()); }  ///< rows
  /// Number of joints.
  std::size_t dof() const { return joint_names.size(); }
  /// Whether it has times.
  bool timed() const { return times.size() > 0; }
  double duration() const { return times.size() ? times[times.size() - 1] - times[0] : 0.0; }  ///< [s]
  /// Length of the motion: sum of the Euclidean norms of joint differences of rows [rad, prismatic joints m].
  double length() const;

  /// Throws InvalidArgument unless there are rows, all arrays have the shapes above and finite numbers, joint names
  /// differ, times increase (and not by so little that the polynomials overflow), velocities come with times and
  /// accelerations with velocities. Call this after filling the fields by hand; all functions here keep it true.
  void validate() const;

  // All of these throw InvalidArgument for a trajectory without times or rows, for arrays of other shapes, and for NaN.

  /// Position at time t [s]. Times outside are moved to the nearest end.
  Eigen::VectorXd sample(double t) const;
  /// Position, velocity, acceleration and jerk at time t [s], as sample.
  MotionState state(double t) const;
  /// n x dof [rad/s^3 or m/s^3]: of the polynomial after each row, the last row's is that before it.
  RowMatrix jerks() const;

  /// Rows at every multiple of dt [s] from the start that is not within 1 % of dt of the end, and at the end. Another
  /// motion, near this one: the polynomials through the new rows; they may exceed limits that this one obeys. If this
  /// one has a certificate, that of the result says which limits it uses and exceeds; collisions are not checked.
  /// Throws InvalidArgument unless dt > 0 and there are at most ten million rows.
  Trajectory resample(double dt) const;
  /// Rows at multiples of dt [s] from the start, and nowhere else: a motion that keeps the velocity and acceleration
  /// limits (to 1e-9), because it is as much slower as that takes, everywhere. Throws as resample(dt), and for limits
  /// that are not of these joints or not above 0.
  Trajectory resample(double dt, const MotionLimits& limits) const;
  /// The same motion from time `from` to `to` [s], with its times; cut between rows where needed, but at a row that is
  /// within 1 µs. Its waypoints are its own rows (those of a path have no times to cut at). A certificate that holds is
  /// kept, for the scene it was made in: what was proved of the motion is proved of its parts, the use of limits is
  /// found anew; the clearance is what was proved of the whole motion unless its nearest place is in the part;
  /// deviation and goal_error are NaN. Throws InvalidArgument unless from < to and the two overlap the motion.
  Trajectory slice(double from, double to) const;
  /// This motion and then `next`, whose times are moved to follow. Where both have certificates that hold, for the same
  /// limits, it has one: each motion's claims in the scene in which it was verified, but for path constraints, poses
  /// and clearance, which may be of one of them only. Throws InvalidArgument unless joint names agree and `next` starts
  /// where this ends: positions within 1e-9, velocities within 1e-6.
  Trajectory followed_by(const Trajectory& next) const;
  /// The same motion of these joints alone, in this order: for the controller of one arm of several, which may know
  /// them by other `names` (one a joint; none: they keep theirs). It has no certificate and no robot, which are of all
  /// joints. Throws InvalidArgument for no joint, one that is not here (with the nearest name), one that is named
  /// twice, and another number of names.
  Trajectory of_joints(const std::vector<std::string>& joints, const std::vector<std::string>& names = {}) const;

  // These need no times.

  /// Rows first … last-1 and the same motion between them; waypoints and certificate as in slice. Throws
  /// InvalidArgument unless first < last <= size().
  Trajectory rows(std::size_t first, std::size_t last) const;

  /// n x 3 [m]: where the origin of a link ("" = the end effector) is at each row, in the world. The robot is matched
  /// by joint names, in any order; that of the second form is `robot`. Throws InvalidArgument for an unknown robot or
  /// link and when the joints are not its planned ones.
  RowMatrix end_effector_path(const PlacedRobot& of, const std::string& link = "") const;
  RowMatrix end_effector_path(const std::string& link = "") const;
  /// How far that origin travels [m]: the motion is followed in steps of 10 ms, or of 0.01 rad (m) where it has no
  /// times.
  double end_effector_length(const PlacedRobot& of, const std::string& link = "") const;
  double end_effector_length(const std::string& link = "") const;
};

}  // namespace srmp
