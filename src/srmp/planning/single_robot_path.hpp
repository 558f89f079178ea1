#pragma once

#include "srmp/planning/multi_robot.hpp"
#include "srmp/planning/single_robot.hpp"

namespace srmp {

/// The way of a robot of the problem among what stands still for `checker`; of one that may move aside no way, but its
/// start. What it took is added to the statistics. Throws PlanningError that names the robot.
RobotPath find_way_alone(const MultiRobotProblem& problem, const MultiRobotPart& part, const Checker& checker,
                         const Deadline& deadline, PlanStatistics& statistics);

}  // namespace srmp
