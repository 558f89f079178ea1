#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/goal.hpp"
#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// What a trajectory is held against, besides the scene.
struct VerifyOptions {
  std::optional<Eigen::VectorXd> start{};  ///< dof [rad or m]: where it should begin
  std::vector<GoalConstraint> goals{};     ///< it should reach one of them; none: any end will do
  std::optional<MotionLimits> limits{};    ///< none: PlannerInterface::motion_limits
  bool jerk{false};                        ///< hold it against the jerk limits too
  std::optional<double> max_deviation{};   ///< [m] from its waypoints, to 1e-9; none: any
  double gap_tolerance{0.5};               ///< of the clearance proved: ProofOptions::gap_tolerance
};

/// What trajectories of many robots are held against, besides the scene and each other.
struct MultiVerifyOptions {
  std::map<std::string, Eigen::VectorXd> starts{};  ///< by robot name, dof [rad or m]: where they should begin
  /// By robot name: what they should reach. One that holds should end where it should begin, or does if that is not
  /// said; one aside, anywhere.
  std::map<std::string, GoalConstraint> goals{};
  std::map<std::string, Trajectory> obstacles{};  ///< by robot name: motions that are not judged themselves
  bool jerk{false};                               ///< the rest as in VerifyOptions
  std::optional<double> max_deviation{};
  double gap_tolerance{0.5};
};

}  // namespace srmp
