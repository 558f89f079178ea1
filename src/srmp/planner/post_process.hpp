#pragma once

#include <vector>

#include "srmp/planner/single_robot.hpp"

namespace srmp {

/// The path in time, with its certificate, as the problem's options say; a rounded corner that the certificate cannot
/// prove free shrinks. The first `escape` segments lead out of a start in collision. Takes what is left of the time
/// limit, and a little more if need be: never much more than 10 ms past it. Throws Error when the certificate does not
/// hold.
Trajectory post_process(const SingleRobotProblem& problem, const std::vector<Eigen::VectorXd>& path, std::size_t escape,
                        const Deadline& deadline, PlanStatistics& statistics);

/// The shares of the limits that the options leave.
MotionLimits scaled(MotionLimits limits, const CommonOptions& options);

}  // namespace srmp
