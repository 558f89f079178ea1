#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "srmp/planner/goal.hpp"
#include "srmp/trajectory/certify.hpp"

namespace srmp {

/// What a trajectory is held against, besides the scene.
struct VerifyOptions {
  std::optional<Eigen::VectorXd> start{};  ///< dof [rad or m]: where it should begin
  std::vector<GoalConstraint> goals{};     ///< it should reach one of them; none: any end will do
  std::optional<MotionLimits> limits{};    ///< none: PlannerInterface::motion_limits
  bool jerk{false};                        ///< hold it against the jerk limits too
  std::optional<double> max_deviation{};   ///< [m] from its waypoints, to 1e-9; none: any
  double tightness{0.5};                   ///< of the clearance proved: ProofOptions::tightness
};

/// How far q misses the nearest of the goals: joint goals in rad (m), the worst joint; poses and positions as a share
/// of their tolerances, the worst axis. NaN when there is none.
struct GoalMiss {
  double error{std::numeric_limits<double>::quiet_NaN()};
  double allowed{};
};
GoalMiss goal_miss(const std::vector<GoalConstraint>& goals, const Checker& checker, ConstVector q);

/// certify, and whether the trajectory begins and ends where it should. Throws InvalidArgument for options out of
/// range.
Certificate verify(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
                   const VerifyOptions& options);

}  // namespace srmp
