#pragma once

#include <map>
#include <string>

#include "srmp/planner/multi_arm/multi_robot.hpp"

namespace srmp {

/// Motions of other robots that are settled, by name: they begin at time 0, and the robots rest where they end.
using CommittedMotions = std::map<std::string, Trajectory>;

/// Lets the robots of `committed` stand where their motions end. Throws InvalidArgument for a robot that is not in the
/// scene or has a start, and for a trajectory that is not whole, not the robot's, without times, not beginning at time
/// 0, or beyond the joint limits; and when there are any and `options` ask for no timing.
void stand_at_ends(Scene& scene, const std::map<std::string, Eigen::VectorXd>& starts,
                   const CommittedMotions& committed, const CommonOptions& options);

/// plan_multi_robot among robots that move as they are committed to, and stand at the ends of their motions in the
/// problem's scene: paths are planned there, and begun together as soon as the others let them pass, in steps of 0.1 s;
/// until then the robots rest at their starts. Every motion returned is proved apart from the committed ones, between
/// rows too, and the certificates cover them. `starts` names the robots that hold as well.
///
/// Not complete: no way is planned that leads out of a committed motion's way. Throws PlanningError for that
/// (`exhausted`, with links and time), and start_invalid for a start where a committed motion begins or ends.
MultiTrajectory plan_around(const MultiRobotProblem& problem, const std::map<std::string, Eigen::VectorXd>& starts,
                            const CommittedMotions& committed, const Deadline& deadline, PlanStatistics& statistics);

}  // namespace srmp
