#pragma once

#include <functional>
#include <map>
#include <string>

#include "srmp/planning/problem.hpp"
#include "srmp/trajectory/multi_trajectory.hpp"

namespace srmp {

/// Moves the robots of `obstacles` to where their motions end. Throws InvalidArgument for a robot that is not in the
/// scene or has a start, and for a trajectory that is not valid, not the robot's, without times, not beginning at time
/// 0, or beyond the joint limits; and when there are any and `options` ask for no timing.
void stand_at_ends(Scene& scene, const std::map<std::string, Eigen::VectorXd>& starts,
                   const std::map<std::string, Trajectory>& obstacles, const CommonOptions& options);

/// Plans the problem's robots as if its moving obstacles stood where their motions end, with certificates.
using PlanTogether = std::function<MultiTrajectory()>;

/// How long motions may wait at their starts, next to paths around the obstacles.
struct WaitingOptions {
  double delay_step{0.1};  ///< [s], > 0, between delays that are tried: a smaller one wastes less time, for more checks
  /// A plan around the obstacles must save more than `min_gain` [s] and more than `min_gain_fraction` of the time until
  /// all robots have arrived: less saves more time, but more often makes longer paths and takes longer to plan.
  double min_gain{0.1}, min_gain_fraction{0.1};
};

/// Motions among moving obstacles. First those of `plan_together`, which begin together as soon as the obstacles let
/// them pass, in steps of WaitingOptions::delay_step, and are stationary at their starts until then. Where that fails,
/// or ends much later than without waiting, the robots are planned one after the other in time (plan_in_time.hpp),
/// around the obstacles and the robots before them; motions that end late are proved first, and stay if no others are
/// found and proved in the time that is left.
///
/// Every motion returned is proved clear of the obstacles, between rows too, and the certificates cover them.
///
/// Not complete. Throws PlanningError: `exhausted`, with links and time, where no motions were found; start_invalid for
/// a start where an obstacle's motion begins, or ends if the robot does not find a way to leave before.
MultiTrajectory plan_among_obstacles(const PlanProblem& problem, const PlanTogether& plan_together,
                                     const Deadline& deadline, PlanStatistics& statistics,
                                     const WaitingOptions& waiting = {});

/// Removes the costs of motions that were found, but are not returned.
void forget_motions(PlanStatistics& statistics);

}  // namespace srmp
