#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// The tolerance of a target along, or about, the axes x, y and z of the target's own frame, in both directions [m or
/// rad]. Infinity leaves an axis free. A single number is the tolerance of all three axes.
struct AxisTolerance {
  AxisTolerance(double all) : axes(Eigen::Vector3d::Constant(all)) {}  // NOLINT: implicit, for options
  AxisTolerance(const Eigen::Vector3d& each) : axes(each) {}           // NOLINT
  AxisTolerance(double x, double y, double z) : axes(x, y, z) {}

  /// Is the tolerance of this axis (0, 1 or 2) infinite?
  bool is_free(Eigen::Index axis) const { return std::isinf(axes[axis]); }
  /// The same with the smaller of `value` and the tolerance for each axis that is not free.
  AxisTolerance tightened(double value) const;
  /// Throws InvalidArgument unless all three are above 0; `what` names the argument.
  void validate(const std::string& what) const;
  bool operator==(const AxisTolerance& other) const { return axes == other.axes; }

  Eigen::Vector3d axes;  ///< x, y, z
};

/// Options of inverse_kinematics.
struct IkOptions {
  int max_solutions{16};    ///< stop once this many different solutions are known, > 0
  int seeds{64};            ///< initial guesses: the reference first, then a fixed low-discrepancy sequence, > 0
  int max_iterations{100};  ///< damped least-squares steps for each seed, > 0
  AxisTolerance position_tolerance{1e-5};  ///< [m], > 0
  AxisTolerance rotation_tolerance{1e-4};  ///< [rad], > 0; infinity: position only
  double distinct{0.05};  ///< >= 0: of solutions closer than this (largest joint difference [rad or m]), one is kept
  Eigen::VectorXd other_positions{};  ///< of RobotModel::other_joints [rad or m]; empty: at their defaults
};

/// Configurations that put `link` ("" = end effector) at `target` (in the robot's base frame) to the tolerances: each
/// of shape (dof,), within limits, the nearest to `reference` first. Empty when none was found. Deterministic, unless
/// `deadline`, which is checked every few seeds, ends the search.
///
/// Damped least squares on the link's Jacobian (Sugihara 2011, "Solvability-unconcerned inverse kinematics by the
/// Levenberg-Marquardt method") with each step kept within the limits, from several seeds. Joints that do not move the
/// link keep the value of `reference`; continuous joints are returned within half a turn of it. Seeds are solved side
/// by side, as many as the CPU's vectors hold, with the same bits for each instruction set.
///
/// Throws InvalidArgument for options out of range, a reference of the wrong size, numbers that are not finite, and
/// unknown links.
std::vector<Eigen::VectorXd> inverse_kinematics(const RobotModel& robot, const Pose& target, ConstVector reference,
                                                const IkOptions& options = {}, const std::string& link = "",
                                                const Deadline& deadline = {});

/// For each of `references`, the solution that is reached from this seed alone, as by inverse_kinematics with `seeds` =
/// 1; nullopt: none. All are solved side by side, so that several take about as long as one. Of `options`, `seeds` and
/// `max_solutions` do not matter. Throws as inverse_kinematics does.
std::vector<std::optional<Eigen::VectorXd>> inverse_kinematics_from(const RobotModel& robot, const Pose& target,
                                                                    const std::vector<Eigen::VectorXd>& references,
                                                                    const IkOptions& options = {},
                                                                    const std::string& link = "");

}  // namespace srmp
