#include "srmp/planning/single_robot_path.hpp"

#include <algorithm>

#include "srmp/planning/parallel_work.hpp"

namespace srmp {

RobotPath find_way_alone(const MultiRobotProblem& problem, const MultiRobotPart& part, const Checker& checker,
                         const Deadline& deadline, PlanStatistics& statistics) {
  const bool any = part.goal.type == GoalType::any;
  const std::vector<GoalConstraint> goals{any ? GoalConstraint::joints(part.start) : part.goal};
  Auto alone{.common = common_options(problem.options, part.robot)};
  alone.common.recover_start = false;
  const PlannerOptions options = alone;
  PlanStatistics own;
  const SingleRobotProblem question{problem.scene, part.robot,         checker,     part.start, goals,
                                    options,       problem.heuristics, part.limits, {},         part.placed};
  const Deadline left(std::max(deadline.remaining(), 1e-6), [&] { return deadline.cancelled(); });
  const auto add = [&] {
    if (!own.note.empty()) own.note = "robot '" + part.robot + "': " + own.note;
    add_work(statistics, own);
  };
  try {
    RobotPath path = find_robot_path(question, left, own);
    add();
    if (any) return {std::move(path.start), {}, {}, {}};
    return path;
  } catch (const PlanningError& error) {
    add();
    throw PlanningError(error.status(), "robot '" + part.robot + "': " + error.what());
  }
}

}  // namespace srmp
