#include "srmp/planning/robot_context.hpp"

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

std::size_t worker_count(const PlannerOptions& options) {
  const auto* parallel = std::get_if<WPASE>(&options);
  return parallel ? static_cast<std::size_t>(parallel->num_threads) : 1;
}

}  // namespace

RobotContext::RobotContext(const PlanProblem& problem, const RobotProblem& task, const PlannerOptions& options,
                           const Checker& checker, const Deadline& deadline, PlanStatistics& statistics)
    : problem(problem),
      task(task),
      options(options),
      common(common_options(options)),
      robot(checker.robot()),
      deadline(deadline),
      statistics(statistics),
      checks(checker, deadline, worker_count(options), task.constraints.get(), task.limits) {}

void RobotContext::stop_if_late(const std::string& phase) const {
  if (deadline.cancelled()) throw PlanningError(Status::cancelled, "the plan was cancelled during " + phase);
  if (deadline.expired())
    throw PlanningError(Status::timed_out, "no path within the time limit of " + to_text(common.time_limit) +
                                               " s, which passed during " + phase);
}

std::string RobotContext::no_path_sentence(const search::Result& result, const std::string& no_path,
                                           const std::string& expanded) const {
  const std::string work = std::to_string(result.statistics.expansions) + " " + expanded + ", " +
                           std::to_string(result.statistics.evaluations) + " edges checked";
  switch (result.status) {
    case Status::exhausted:
      return no_path + " path: every state that can be reached was expanded (" + work +
             "); a finer resolution or other motion primitives may hold one";
    case Status::cancelled: return "the plan was cancelled during the search (" + work + ")";
    default: return "no path within the time limit of " + to_text(common.time_limit) + " s (" + work + ")";
  }
}

void RobotContext::count(const search::Statistics& work) {
  statistics.expansions += work.expansions;
  statistics.generated += work.generated;
}

double RobotContext::length(const std::vector<Eigen::VectorXd>& path) const {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += robot.difference(path[i - 1], path[i]).norm();
  return sum;
}

}  // namespace srmp
