#pragma once

#include "srmp/core/low_discrepancy.hpp"
#include "srmp/robot/robot_model.hpp"

/// The index-th of a fixed sequence of configurations within the limits (continuous joints within half a turn of 0).
inline Eigen::VectorXd sample_configuration(const srmp::RobotModel& robot, std::size_t index) {
  Eigen::VectorXd q = srmp::low_discrepancy_point(index, static_cast<Eigen::Index>(robot.dof()));
  for (std::size_t i = 0; i < robot.dof(); ++i) {
    const srmp::Joint& joint = robot.joints()[i];
    const bool continuous = joint.kind == srmp::JointKind::continuous;
    const double lower = continuous ? -3.14159 : joint.lower, upper = continuous ? 3.14159 : joint.upper;
    double& value = q[static_cast<Eigen::Index>(i)];
    value = lower + value * (upper - lower);
  }
  return q;
}
