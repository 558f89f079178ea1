#include "srmp/planner/multi_arm/way_alone.hpp"

#include <algorithm>

namespace srmp {

namespace {

/// The robots are planned one after the other.
void add(PlanStatistics& sum, const std::string& robot, const PlanStatistics& alone) {
  sum.ik_time_s += alone.ik_time_s;
  sum.heuristic_time_s += alone.heuristic_time_s;
  sum.search_time_s += alone.search_time_s;
  sum.shortcut_time_s += alone.shortcut_time_s;
  sum.expansions += alone.expansions;
  sum.generated += alone.generated;
  sum.edge_checks += alone.edge_checks;
  sum.states += alone.states;
  sum.memory_bytes = std::max(sum.memory_bytes, alone.memory_bytes);
  if (alone.note.empty()) return;
  const std::string note = "robot '" + robot + "': " + alone.note;
  if (sum.note.find(note) != std::string::npos) return;  // asked for the second time
  sum.note += (sum.note.empty() ? "" : "; ") + note;
}

}  // namespace

RobotPath find_way_alone(const MultiRobotProblem& problem, const MultiRobotPart& part, const Checker& checker,
                         const Deadline& deadline, PlanStatistics& statistics) {
  const bool aside = part.goal.type == GoalType::aside;
  const std::vector<GoalConstraint> goals{aside ? GoalConstraint::joints(part.start) : part.goal};
  Auto alone{.common = common_options(problem.options)};
  alone.common.escape_start = false;
  const PlannerOptions options = alone;
  PlanStatistics own;
  const SingleRobotProblem question{problem.scene, part.robot,         checker,     part.start, goals,
                                    options,       problem.heuristics, part.limits, {},         part.placed};
  const Deadline left(std::max(deadline.remaining(), 1e-6), [&] { return deadline.cancelled(); });
  try {
    RobotPath path = find_robot_path(question, left, own);
    add(statistics, part.robot, own);
    if (aside) return {std::move(path.start), {}, {}, {}};
    return path;
  } catch (const PlanningError& error) {
    add(statistics, part.robot, own);
    throw PlanningError(error.status(), "robot '" + part.robot + "': " + error.what());
  }
}

}  // namespace srmp
