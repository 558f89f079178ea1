#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// How far off something may be along or about x, y and z of the target's own frame, on either side; infinity: an axis
/// is free. A number holds for all three.
struct AxisTolerance {
  AxisTolerance(double all) : axes(Eigen::Vector3d::Constant(all)) {}  // NOLINT: a number is one
  AxisTolerance(const Eigen::Vector3d& each) : axes(each) {}           // NOLINT
  AxisTolerance(double x, double y, double z) : axes(x, y, z) {}

  bool is_free(Eigen::Index axis) const { return std::isinf(axes[axis]); }
  /// Of the axes that are not free: `value` instead.
  AxisTolerance tightened(double value) const;
  /// Throws InvalidArgument unless all three are above 0.
  void validate(const std::string& what) const;
  bool operator==(const AxisTolerance& other) const { return axes == other.axes; }

  Eigen::Vector3d axes;
};

struct IkOptions {
  int max_solutions{16};    ///< stop once this many different solutions are known, > 0
  int seeds{64};            ///< starts tried: the reference first, then a fixed low-discrepancy sequence, > 0
  int max_iterations{100};  ///< damped least-squares steps a seed, > 0
  AxisTolerance position_tolerance{1e-5};  ///< [m], > 0
  AxisTolerance rotation_tolerance{1e-4};  ///< [rad], > 0; infinity: position only
  double distinct{0.05};                   ///< solutions nearer than this (largest joint difference [rad or m]) are one
  Eigen::VectorXd other_positions{};       ///< of RobotModel::other_joints [rad or m]; empty: at their defaults
};

/// Configurations that put `link` ("" = end effector) at `target` (robot base frame), but for the axes that are free:
/// within limits, nearest to `reference` first, the same every time. Empty when none was found. Damped least squares on
/// the frame's Jacobian (Sugihara 2011, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt
/// method"), each step kept inside the limits, from several seeds. Joints that do not move the link keep the
/// reference's value; continuous joints are given within half a turn of it. `deadline` is looked at between seeds.
/// Throws InvalidArgument.
std::vector<Eigen::VectorXd> inverse_kinematics(const RobotModel& robot, const Pose& target, ConstVector reference,
                                                const IkOptions& options = {}, const std::string& link = "",
                                                const Deadline& deadline = {});

}  // namespace srmp
