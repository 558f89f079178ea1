#pragma once

#include <vector>

#include "srmp/planning/single_robot.hpp"
#include "srmp/trajectory/parameterize.hpp"

namespace srmp {

/// The path in time, with its certificate, as the problem's options say; a rounded corner that the certificate cannot
/// prove free shrinks. The first `escape` segments lead out of a start in collision. Takes what is left of the time
/// limit, and a little more if need be: never much more than 10 ms past it. Throws Error when the certificate does not
/// hold.
Trajectory post_process(const SingleRobotProblem& problem, const std::vector<Eigen::VectorXd>& path, std::size_t escape,
                        const Deadline& deadline, PlanStatistics& statistics);

// What plans of one robot and of many share.

namespace post {
inline constexpr double grace_period = 0.010;  ///< [s] past the time limit: a path that was found should not be lost
inline constexpr double shrink = 0.25;         ///< of a blend deviation that cannot be proved free
inline constexpr double min_deviation = 1e-4;  ///< [m]; below, corners are stops
}  // namespace post

/// Why there is no trajectory, and how long that took.
void note_failure(const PlanningError& error, const Deadline& deadline, PlanStatistics& statistics);

/// As the options say, with corners rounded by `deviation` [m].
TimingOptions timing_options(const CommonOptions& options, double deviation);

/// With times where it has none, so that its straight motions are as long as one another: a certificate needs times.
Trajectory numbered(Trajectory trajectory);

/// The shares of the limits that the options leave.
MotionLimits scaled(MotionLimits limits, const CommonOptions& options);

}  // namespace srmp
