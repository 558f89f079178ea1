#pragma once

#include "srmp/planning/strategies/robot_path.hpp"

namespace srmp {

/// The path that one of several robots would take if the others were not there, among what stands still for `checker`:
/// by `auto`, with the options of this robot. Its work is added to the statistics. Throws PlanningError that names the
/// robot.
RobotPath find_path_alone(const PlanProblem& problem, const RobotProblem& task, const Checker& checker,
                          const Deadline& deadline, PlanStatistics& statistics);

}  // namespace srmp
