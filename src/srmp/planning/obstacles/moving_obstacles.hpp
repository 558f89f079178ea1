#pragma once

#include <map>
#include <string>

#include "srmp/planning/multi_robot.hpp"

namespace srmp {

/// Motions of other robots that are settled, by name: they begin at time 0, and the robots rest where they end.
using CommittedMotions = std::map<std::string, Trajectory>;

/// Lets the robots of `committed` stand where their motions end. Throws InvalidArgument for a robot that is not in the
/// scene or has a start, and for a trajectory that is not whole, not the robot's, without times, not beginning at time
/// 0, or beyond the joint limits; and when there are any and `options` ask for no timing.
void stand_at_ends(Scene& scene, const std::map<std::string, Eigen::VectorXd>& starts,
                   const CommittedMotions& committed, const CommonOptions& options);

/// Among robots that move as they are committed to. First plan_multi_robot among those robots where their motions end,
/// as they stand in the problem's scene; its motions are begun together as soon as the others let them pass, in steps
/// of 0.1 s, and rest at their starts until then. Where that fails, or ends much later than with no wait, one robot
/// after the other is planned in time (plan_in_time.hpp), around the committed motions and the robots before it;
/// motions that end late are proved first, and stay if no others are found and proved in the time that is left.
///
/// Every motion returned is proved apart from the committed ones, between rows too, and the certificates cover them.
/// `starts` names the robots that hold as well; `quick`: for checkers that plan.
///
/// Not complete. Throws PlanningError: `exhausted`, with links and time, where no motions were found; start_invalid for
/// a start where a committed motion begins, or ends if the robot does not find a way to leave before.
MultiTrajectory plan_around(const MultiRobotProblem& problem, const std::map<std::string, Eigen::VectorXd>& starts,
                            const CommittedMotions& committed, const CheckerOptions& quick, const Deadline& deadline,
                            PlanStatistics& statistics);

}  // namespace srmp
