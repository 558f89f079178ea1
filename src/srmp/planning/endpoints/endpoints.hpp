#pragma once

#include <vector>

#include "srmp/planning/robot_context.hpp"

namespace srmp {

/// Where a robot's path may begin and end; all free and within limits.
struct RobotEndpoints {
  Eigen::VectorXd start;                  ///< where `recovery` ends, if there is one
  std::vector<Eigen::VectorXd> recovery;  ///< path out of a start in collision; empty: the start is free
  std::vector<Eigen::VectorXd> targets;   ///< configurations that meet a goal; none: the robot may end anywhere
  std::vector<int> goal_indices;          ///< one a target: PlanStatistics::goal_index

  /// Of one of the targets.
  int goal_index_of(const Eigen::VectorXd& target) const;
  /// Segments of `recovery`.
  std::size_t recovery_segments() const { return recovery.empty() ? 0 : recovery.size() - 1; }
};

/// Checks the start, recovers it from collision where the options ask for that (start_recovery.hpp), and finds the
/// configurations that meet the goals, by inverse kinematics for poses and positions. Of a robot that may end anywhere
/// the start alone. Throws PlanningError: start_invalid, goal_invalid, timed_out or cancelled.
RobotEndpoints find_endpoints(RobotContext& context);

/// Checks the recovery from the start again, as a certificate checks a trajectory; throws Error when it is wrong.
void verify_recovery(const RobotContext& context, const RobotEndpoints& endpoints);

}  // namespace srmp
