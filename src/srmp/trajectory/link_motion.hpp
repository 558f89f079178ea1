#pragma once

#include <span>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/trajectory/cubic.hpp"

namespace srmp {

/// The joints that move a link, and how fast they can move a point of it: bounds that hold for every configuration,
/// from the joints' rates and the farthest that the point can be from each joint's axis.
///
/// They follow from the product of exponentials: the derivative of the point's position by joints i, j, k, from the
/// root on, is z_i x (z_j x (z_k x r_k)), where r_k is the vector from the axis of the most distal one to the point; it
/// is zero where a joint before the last one is prismatic. So it is no longer than the reach of the most distal joint.
class LinkChain {
 public:
  /// Bounds over a part of a motion.
  struct Bounds {
    double speed{}, turning{};                      // of the link [m/s, rad/s]
    double acceleration{}, turning_acceleration{};  // [m/s^2, rad/s^2]
  };
  /// Bounds on the second derivatives of the velocity and the angular velocity.
  struct Curvature {
    double velocity{};          // [m/s^3]
    double angular_velocity{};  // [rad/s^3]
  };

  /// `point` is in the link's frame [m]. The model outlives this; `data` is overwritten.
  LinkChain(const RobotModel& robot, RobotData& data, std::size_t link, const Eigen::Vector3d& point);

  /// Of the motion of all joints, each along its cubic, between two times of it.
  Bounds bounds(std::span<const detail::Cubic> joints, double from, double to) const;
  Curvature curvature(std::span<const detail::Cubic> joints, double from, double to) const;
  /// (dof,): what a unit of each joint moves the point [m] and turns the link [rad], at most.
  const Eigen::VectorXd& travel() const { return travel_; }
  const Eigen::VectorXd& turn() const { return turn_; }

 private:
  /// Bounds on the rates of an actuated joint over a part of a motion.
  struct Rates {
    double speed, acceleration, jerk;
  };
  Rates rates(const ActuatedJoint& actuated, std::span<const detail::Cubic> joints, double from, double to) const;

  const RobotModel& robot_;
  std::vector<std::size_t> chain_;  // numbers of the actuated joints that move the link, parents before children
  std::vector<double> reach_;       // of each: the point is never farther from its axis [m]
  Eigen::VectorXd travel_, turn_;
};

}  // namespace srmp
