#pragma once

#include <vector>

#include "srmp/planning/plan_context.hpp"

namespace srmp {

/// Where the path of a plan may begin and end; all free and within limits.
struct Endpoints {
  Eigen::VectorXd start;                 ///< the end of `escape`, if there is one
  std::vector<Eigen::VectorXd> escape;   ///< from a start in collision; empty: the start is free
  std::vector<Eigen::VectorXd> targets;  ///< configurations that meet a goal, at least one
  std::vector<int> goal_indices;         ///< of the targets: PlanStatistics::goal_index

  /// Of one of the targets.
  int goal_index_of(const Eigen::VectorXd& target) const;
};

/// Checks start and goals, with a way out of a start in collision where the options ask for one, and inverse kinematics
/// for poses and positions. Throws PlanningError.
Endpoints find_endpoints(PlanContext& context);

/// Looks at the way out of the start again, as a certificate looks at a trajectory; throws Error when it is wrong.
void verify_recovery(const PlanContext& context, const Endpoints& ends);

}  // namespace srmp
