#include "srmp/planning/single_robot.hpp"

#include "srmp/planning/post_process.hpp"
#include "srmp/planning/strategies/lattice_search.hpp"
#include "srmp/planning/strategies/portfolio.hpp"

namespace srmp {

namespace {

/// From the start to a goal.
std::vector<Eigen::VectorXd> find_path(PlanContext& context, const Endpoints& ends) {
  BestPath best(context);
  try {
    if (const auto* options = std::get_if<Auto>(&context.problem.options))
      search_in_turns(context, ends, *options, best);
    else
      search_lattice(context, ends, best);
  } catch (const MotionCheckStopped&) {
    if (best.empty()) context.stop_if_late("a check of a motion");
  }
  context.checks.write(context.statistics);
  return best.waypoints();
}

Trajectory find_trajectory(PlanContext& context) {
  const Endpoints ends = find_endpoints(context);
  std::vector<Eigen::VectorXd> path = find_path(context, ends);
  context.statistics.plan_time_s = context.deadline.elapsed();
  const std::size_t escape = ends.escape.empty() ? 0 : ends.escape.size() - 1;  // segments
  path.insert(path.begin(), ends.escape.begin(), ends.escape.begin() + static_cast<std::ptrdiff_t>(escape));
  verify_recovery(context, ends);
  return post_process(context.problem, path, escape, context.deadline, context.statistics);
}

}  // namespace

RobotPath find_robot_path(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics) {
  PlanContext context(problem, deadline, statistics);
  const Endpoints ends = find_endpoints(context);
  return {ends.start, ends.targets, ends.goal_indices, find_path(context, ends)};
}

Trajectory plan_single_robot(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics) {
  PlanContext context(problem, deadline, statistics);
  try {
    Trajectory trajectory = find_trajectory(context);
    statistics.status = Status::solved;
    statistics.total_time_s = deadline.elapsed();
    return trajectory;
  } catch (const PlanningError& error) {
    context.checks.write(statistics);
    note_failure(error, deadline, statistics);
    throw;
  }
}

}  // namespace srmp
