#include "srmp/planning/strategies/path_alone.hpp"

#include "srmp/planning/parallel_work.hpp"

namespace srmp {

RobotPath find_path_alone(const PlanProblem& problem, const RobotProblem& task, const Checker& checker,
                          const Deadline& deadline, PlanStatistics& statistics) {
  CommonOptions common = common_options(problem.options, task.robot);
  common.recover_start = false;
  PlannerOptions options = WAStar{.common = common};
  if (const auto* any = std::get_if<Auto>(&problem.options))
    options = Auto{.common = common, .max_expansions = any->max_expansions};
  else if (std::holds_alternative<RRTConnect>(problem.options))
    options = RRTConnect{.common = common};
  PlanStatistics own;
  RobotContext context(problem, task, options, checker, deadline, own);
  const auto add = [&] {
    if (!own.note.empty()) own.note = "robot '" + task.robot + "': " + own.note;
    add_work(statistics, own);
  };
  try {
    RobotPath path = find_robot_path(context);
    add();
    return path;
  } catch (const PlanningError& error) {
    add();
    throw PlanningError(error.status(), "robot '" + task.robot + "': " + error.what());
  }
}

}  // namespace srmp
