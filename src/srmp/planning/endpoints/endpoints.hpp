#pragma once

#include <vector>

#include "srmp/planning/robot_context.hpp"

namespace srmp {

/// Where a robot's path may begin and end; all free and within limits.
struct RobotEndpoints {
  Eigen::VectorXd start;  ///< where `recovery` ends, if there is one
  /// Path out of a start in collision, or closer to something than CommonOptions::clearance; empty: the start is free.
  std::vector<Eigen::VectorXd> recovery;
  bool starts_in_collision{};            ///< and not only too close
  std::vector<Eigen::VectorXd> targets;  ///< where the search may end; none: the robot may end anywhere
  std::vector<int> goal_indices;         ///< one a target: PlanStatistics::goal_index
  /// One a target: the path from it to the configuration that meets the goal, where that is closer to something than
  /// CommonOptions::clearance; empty: the target itself meets the goal.
  std::vector<std::vector<Eigen::VectorXd>> approaches;

  /// Segments of `recovery`.
  std::size_t recovery_segments() const { return recovery.empty() ? 0 : recovery.size() - 1; }
  /// Of these, the segments that lead out of a collision.
  std::size_t collision_segments() const { return starts_in_collision ? recovery_segments() : 0; }
};

/// Checks the start, recovers it from collision where the options ask for that (start_recovery.hpp), and finds the
/// configurations that meet the goals, by inverse kinematics for poses and positions. Of a robot that may end anywhere
/// the start alone. Ends that are closer to something than CommonOptions::clearance, but free, are left and reached by
/// the same rule as a start in collision; with `start_may_be_close`, such a start is as good as any other, and its way
/// out is the caller's. Throws PlanningError: start_invalid, goal_invalid, timed_out or cancelled.
RobotEndpoints find_endpoints(RobotContext& context, bool start_may_be_close = false);

/// Adds the approach to the goal, if the path's last row needs one.
RowMatrix with_approach(const RobotContext& context, const RobotEndpoints& endpoints, const RowMatrix& waypoints);

/// Checks the recovery from the start again, as a certificate checks a trajectory; throws Error when it is wrong.
void verify_recovery(const RobotContext& context, const RobotEndpoints& endpoints);

}  // namespace srmp
