#pragma once

#include <functional>
#include <vector>

#include "srmp/planning/multi_robot.hpp"
#include "srmp/planning/parallel_work.hpp"
#include "srmp/planning/smoothing/joint_path.hpp"

namespace srmp {

/// Told of the paths that are returned, before they are sealed by certificates: costs and bound are known then.
using PathsKnown = std::function<void(const std::vector<JointPath>& paths)>;

/// Paths of groups of arms, in time and proved (post_process for many). Each group is timed by itself; where arms of
/// two groups cannot be proved apart, the two become one, so that what one does while another does something stays so.
/// `raw`: the groups as they were found, which do not meet; `shortened`: each for itself.
MultiTrajectory coupled_post_process(const MultiRobotProblem& problem, MultiRobotWorld& world,
                                     const std::vector<JointPath>& raw, const std::vector<JointPath>& shortened,
                                     const PathsKnown& paths_known, ParallelWork& work, const Deadline& deadline,
                                     PlanStatistics& statistics);

}  // namespace srmp
