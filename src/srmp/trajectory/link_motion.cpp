#include "srmp/trajectory/link_motion.hpp"

#include <algorithm>
#include <cmath>

namespace srmp {

LinkChain::LinkChain(const RobotModel& robot, RobotData& data, std::size_t link, const Eigen::Vector3d& point)
    : robot_(robot), travel_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot.dof()))), turn_(travel_) {
  // The origins of two joints of a chain keep their distance, but for the travel of prismatic joints.
  robot.forward(data, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot.dof())));
  const std::vector<ActuatedJoint>& joints = robot.actuated_joints();
  for (std::size_t k = 0; k < joints.size(); ++k)
    if (robot.link_support(link) >> k & 1) chain_.push_back(k);
  reach_.resize(chain_.size());
  Eigen::Vector3d next = robot.link_pose(data, link).translation();
  double reach = point.norm();
  for (std::size_t i = chain_.size(); i-- > 0;) {
    const ActuatedJoint& actuated = joints[chain_[i]];
    const Joint& planned = robot.joints()[actuated.joint];
    const Eigen::Vector3d origin = robot.actuated_joint_axis(data, chain_[i]).first;
    reach += (next - origin).norm();
    if (actuated.prismatic)
      reach += std::abs(actuated.ratio) * std::max(std::abs(planned.lower), std::abs(planned.upper));
    reach_[i] = reach;
    next = origin;
    const auto joint = static_cast<Eigen::Index>(actuated.joint);
    travel_[joint] += std::abs(actuated.ratio) * (actuated.prismatic ? 1.0 : reach);
    turn_[joint] += actuated.prismatic ? 0.0 : std::abs(actuated.ratio);
  }
}

LinkChain::Rates LinkChain::rates(const ActuatedJoint& actuated, std::span<const detail::Cubic> joints, double from,
                                  double to) const {
  const detail::Cubic& cubic = joints[actuated.joint];
  const double ratio = std::abs(actuated.ratio), middle = (from + to) / 2.0;
  const double acceleration = ratio * std::max(std::abs(cubic.acceleration(from)), std::abs(cubic.acceleration(to)));
  const double speed = ratio * std::abs(cubic.velocity(middle)) + acceleration * (to - from) / 2.0;
  return {speed, acceleration, ratio * std::abs(cubic.jerk())};
}

LinkChain::Bounds LinkChain::bounds(std::span<const detail::Cubic> joints, double from, double to) const {
  Bounds motion;
  double turning = 0.0;  // of the joints before
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    const ActuatedJoint& actuated = robot_.actuated_joints()[chain_[i]];
    const auto [speed, acceleration, jerk] = rates(actuated, joints, from, to);
    const double arm = actuated.prismatic ? 1.0 : reach_[i];
    motion.speed += arm * speed;
    motion.acceleration += arm * (acceleration + speed * ((actuated.prismatic ? 0.0 : speed) + 2.0 * turning));
    if (actuated.prismatic) continue;
    motion.turning_acceleration += acceleration + turning * speed;
    turning += speed;
  }
  motion.turning = turning;
  return motion;
}

LinkChain::Curvature LinkChain::curvature(std::span<const detail::Cubic> joints, double from, double to) const {
  Curvature most;
  double w = 0.0, w_dot = 0.0;  // of the joints before: bounds on their angular velocity and its derivative,
  double accelerations = 0.0;   // and the sum of their angular accelerations
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    const ActuatedJoint& actuated = robot_.actuated_joints()[chain_[i]];
    const auto [s, a, j] = rates(actuated, joints, from, to);
    // Of the third derivative, all terms whose most distal joint is this one.
    double term = j + 3.0 * (s * accelerations + a * w) + 3.0 * s * w * w;
    if (!actuated.prismatic) term += 3.0 * s * a + s * s * (s + 3.0 * w);
    most.velocity += (actuated.prismatic ? 1.0 : reach_[i]) * term;
    if (actuated.prismatic) continue;
    most.angular_velocity += j + 2.0 * w * a + (w_dot + w * w) * s;
    w_dot += a + w * s;
    accelerations += a;
    w += s;
  }
  return most;
}

}  // namespace srmp
