#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/goal.hpp"
#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/path_constraint.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// What a trajectory is verified against, besides the scene.
struct VerifyOptions {
  std::optional<Eigen::VectorXd> start{};  ///< (dof,) [rad or m]: where it should begin
  std::vector<GoalConstraint> goals{};     ///< it should reach one of them; none: it may end anywhere
  std::optional<MotionLimits> limits{};    ///< none: PlannerInterface::motion_limits
  bool jerk{false};                        ///< verify the jerk limits too
  bool at_rest{true};                      ///< a velocity at the ends is a fault; false: it may be a slice in motion
  Eigen::VectorXd start_velocity{};       ///< (dof,) [rad/s or m/s]: with which it should begin; empty: as at_rest says
  Eigen::VectorXd start_acceleration{};   ///< (dof,) [rad/s^2 or m/s^2] before the motion, for its jerk; empty: 0
  std::optional<double> max_deviation{};  ///< [m] that it may leave its waypoints by, to 1e-9; none: any
  /// In (0, 1): the clearance is proved until (clearance - clearance_proved) / clearance is no more than this, within
  /// some hundred distances. What is proved free does not depend on it.
  double gap_tolerance{0.5};
  std::vector<PathConstraint> constraints{};  ///< that it should keep at every instant; Certificate::constraints
  /// [m] that it should keep from everything, except near ends that are closer, as CommonOptions::clearance says; 0:
  /// none. Certificate::clearance_kept.
  double clearance{0.0};
};

/// What trajectories of many robots are verified against, besides the scene and each other.
struct MultiVerifyOptions {
  std::map<std::string, Eigen::VectorXd> starts{};  ///< by robot name, (dof,) [rad or m]: where they should begin
  /// By robot name: what they should reach. A robot with a goal of type hold should end where it should begin, or where
  /// it does begin if that is not given; one of type any, anywhere.
  std::map<std::string, GoalConstraint> goals{};
  std::map<std::string, Trajectory> obstacles{};  ///< by robot name: motions that are not verified themselves
  bool jerk{false};                               ///< as VerifyOptions::jerk
  bool at_rest{true};                             ///< as VerifyOptions::at_rest
  std::optional<double> max_deviation{};          ///< as VerifyOptions::max_deviation
  double gap_tolerance{0.5};                      ///< as VerifyOptions::gap_tolerance
  double clearance{0.0};  ///< [m] as VerifyOptions::clearance; from each other the robots keep it at their ends too
  std::map<std::string, std::vector<PathConstraint>> constraints{};  ///< by robot name, as VerifyOptions::constraints
};

}  // namespace srmp
