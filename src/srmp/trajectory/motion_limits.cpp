#include "srmp/trajectory/motion_limits.hpp"

#include <cmath>
#include <string_view>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

namespace {

constexpr double no_velocity_limit = 1e6;  // parsers write huge numbers for "unlimited"

void require_link_speed(const LinkSpeedLimit& limit) {
  const std::string name = limit.link.empty() ? "the end effector" : "link '" + limit.link + "'";
  const auto require = [&](double value, const std::string& what) {
    if (!(value >= min_motion_limit) || (value > max_motion_limit && !std::isinf(value)))
      throw InvalidArgument("the " + what + " limit of " + name + " is " + to_text(value) + "; it must be from " +
                            to_text(min_motion_limit) + " to " + to_text(max_motion_limit) + ", or infinite for none");
  };
  require(limit.speed, "speed");
  require(limit.angular_speed, "angular speed");
  if (std::isinf(limit.speed) && std::isinf(limit.angular_speed))
    throw InvalidArgument("neither the speed nor the angular speed of " + name + " is limited; give one of them");
  if (!limit.point.allFinite() || limit.point.cwiseAbs().maxCoeff() > max_motion_limit)
    throw InvalidArgument("the point of " + name + " whose speed is limited must be three finite numbers [m]");
}

void require_payload(const Payload& payload) {
  if (!(payload.mass > 0.0 && payload.mass <= max_motion_limit))
    throw InvalidArgument("the payload's mass is " + to_text(payload.mass) + " kg; it must be above 0 and finite");
  if (!payload.center_of_mass.allFinite() || payload.center_of_mass.cwiseAbs().maxCoeff() > max_motion_limit)
    throw InvalidArgument("the payload's center of mass must be three finite numbers [m]");
  if (!(payload.inertia.minCoeff() >= 0.0 && payload.inertia.maxCoeff() <= max_motion_limit))
    throw InvalidArgument("the payload's inertia must be three finite numbers, 0 or above [kg m^2]");
}

void require_torques(const MotionLimits& limits, const std::vector<std::string>& joint_names) {
  const auto torques = static_cast<std::size_t>(limits.torque.size());
  if (torques != 0 && torques != joint_names.size())
    throw InvalidArgument("torque limits: got " + std::to_string(torques) + ", but there are " +
                          std::to_string(joint_names.size()) + " joints");
  for (std::size_t j = 0; j < torques; ++j) {
    const double limit = limits.torque[static_cast<Eigen::Index>(j)];
    if (!(limit >= min_motion_limit) || (limit > max_motion_limit && !std::isinf(limit)))
      throw InvalidArgument(joint_names[j] + ": the torque limit is " + to_text(limit) + "; it must be from " +
                            to_text(min_motion_limit) + " to " + to_text(max_motion_limit) + ", or infinite for none");
  }
  if (limits.payload) require_payload(*limits.payload);
}

}  // namespace

MotionLimits default_limits(const Eigen::VectorXd& velocity) {
  MotionLimits limits;
  limits.velocity = velocity;
  for (Eigen::Index j = 0; j < velocity.size(); ++j) {
    double& v = limits.velocity[j];
    if (std::isnan(v) || v < 0.0)
      throw InvalidArgument("velocity limit of joint " + std::to_string(j) + " is " + to_text(v) +
                            "; it must be 0 (unknown) or above");
    if (v == 0.0 || v > no_velocity_limit) v = 1.0;
  }
  limits.acceleration = 2.0 * limits.velocity;
  limits.jerk = 10.0 * limits.acceleration;
  return limits;
}

MotionLimits default_limits(const RobotModel& robot) {
  Eigen::VectorXd velocity(static_cast<Eigen::Index>(robot.dof()));
  std::vector<bool> continuous;
  for (const Joint& joint : robot.joints()) {
    velocity[static_cast<Eigen::Index>(continuous.size())] = joint.max_velocity;
    continuous.push_back(joint.kind == JointKind::continuous);
  }
  MotionLimits limits = default_limits(velocity);
  limits.continuous = std::move(continuous);
  return limits;
}

Eigen::VectorXd effort_limits(const RobotModel& robot) {
  Eigen::VectorXd torque(static_cast<Eigen::Index>(robot.dof()));
  for (std::size_t j = 0; j < robot.dof(); ++j) {
    const double effort = robot.joints()[j].max_effort;
    torque[static_cast<Eigen::Index>(j)] = effort > 0.0 ? effort : std::numeric_limits<double>::infinity();
  }
  if (torque.array().isInf().all())
    throw InvalidArgument("the URDF of robot '" + robot.name() + "' gives no planned joint an effort limit above 0");
  return torque;
}

void require_limits(const MotionLimits& limits, const std::vector<std::string>& joint_names) {
  const auto require = [&](const Eigen::VectorXd& values, const std::string& what) {
    if (static_cast<std::size_t>(values.size()) != joint_names.size())
      throw InvalidArgument(what + " limits: got " + std::to_string(values.size()) + ", but there are " +
                            std::to_string(joint_names.size()) + " joints");
    for (std::size_t j = 0; j < joint_names.size(); ++j) {
      const double limit = values[static_cast<Eigen::Index>(j)];
      require_positive(limit, joint_names[j] + ": the " + what + " limit");
      if (limit < min_motion_limit || limit > max_motion_limit)
        throw InvalidArgument(joint_names[j] + ": the " + what + " limit is " + to_text(limit) + "; it must be from " +
                              to_text(min_motion_limit) + " to " + to_text(max_motion_limit));
    }
  };
  require(limits.velocity, "velocity");
  require(limits.acceleration, "acceleration");
  require(limits.jerk, "jerk");
  for (const LinkSpeedLimit& link : limits.link_speeds) require_link_speed(link);
  require_torques(limits, joint_names);
}

}  // namespace srmp
