#pragma once

#include <functional>
#include <vector>

#include "srmp/planning/joint_paths.hpp"
#include "srmp/trajectory/multi_trajectory.hpp"
#include "srmp/trajectory/parameterize.hpp"

namespace srmp {

/// What certified_timing may do beyond the time limit and the path.
struct CertifiedTimingOptions {
  double grace_period{0.005};  ///< [s] past the time limit: a path that was found should not be lost
  /// A rounded corner that the certificate cannot prove free gets so many times the deviation, until it is a stop.
  double shrink{0.25};
  double min_deviation{1e-4};  ///< [m]; below, corners are stops
  /// Of a group's trajectories: more take longer than the grace period to be written and verified.
  std::size_t max_rows{200'000};
};

/// The paths in time, with certificates, as the problem's options say. Every group of robots is timed by itself; a
/// rounded corner that the certificate cannot prove free shrinks. Where robots of two groups cannot be proved to stay
/// clear of each other, the two become one group, so that what one does while another does something stays so.
///
/// The first `recovery_segments` segments of one robot's path lead out of a start in collision. Takes what is left of
/// the time limit, and a little more if need be (grace_period). Throws Error when a certificate does not hold.
MultiTrajectory certified_timing(const PlanProblem& problem, JointPaths paths, std::size_t recovery_segments,
                                 ParallelWork& work, const Deadline& deadline, PlanStatistics& statistics);

/// Passes a grace period after the time limit. The deadline outlives it.
Deadline with_grace_period(const Deadline& deadline);

/// As the planner's options say, with corners rounded by `deviation` [m].
TimingOptions timing_options(const CommonOptions& options, double deviation);

}  // namespace srmp
