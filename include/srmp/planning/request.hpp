#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/goal.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/trajectory/path_constraint.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// A request to PlannerInterface::plan or plan_many.
struct PlanRequest {
  std::string robot;                          ///< name of the robot that is planned
  Eigen::VectorXd start;                      ///< (dof,) [rad or m]
  std::vector<GoalConstraint> goals;          ///< any one of them is enough
  std::optional<PlannerOptions> options{};    ///< none: those of make_planner
  std::vector<PathConstraint> constraints{};  ///< that hold at every instant of the motion
  Eigen::VectorXd start_velocity{};           ///< (dof,) [rad/s or m/s]; empty: the motion begins at rest
  /// (dof,) [rad/s^2 or m/s^2], in the direction of the velocity; empty: 0. It counts with the timing `ruckig`, which
  /// limits the jerk; other accelerations may jump.
  Eigen::VectorXd start_acceleration{};
};

/// How a link is to pass poses: PlannerInterface::follow.
struct CartesianOptions {
  std::string link{};                         ///< that moves; "" = the end effector
  double max_deviation{1e-3};                 ///< [m], > 0: that its origin may leave the path by
  double max_rotation{M_PI / 360.0};          ///< [rad], > 0: that its rotation may differ by; half a degree
  std::vector<PathConstraint> constraints{};  ///< that hold at every instant of the motion besides
};

/// Called by plan_many in the caller's thread, with the number of requests done and of all.
using PlanProgress = std::function<void(std::size_t done, std::size_t total)>;

/// A request to PlannerInterface::plan_multi: its arguments.
struct MultiPlanRequest {
  std::map<std::string, Eigen::VectorXd> starts;  ///< by robot name, (dof,) [rad or m]
  std::map<std::string, GoalConstraint> goals;    ///< by robot name; a robot with a start and no goal holds
  std::map<std::string, Trajectory> obstacles{};  ///< by robot name: motions that other robots are committed to
  /// By robot name: hold at every instant. Frames are as in PlanRequest::constraints, but no robot that moves has them.
  std::map<std::string, std::vector<PathConstraint>> constraints{};
};

}  // namespace srmp
