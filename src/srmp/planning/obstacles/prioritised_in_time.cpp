#include "srmp/planning/obstacles/prioritised_in_time.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "srmp/core/stopping.hpp"
#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/planning/endpoints/joint_endpoints.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/strategies/path_alone.hpp"
#include "srmp/planning/validity.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

PrioritisedInTime::PrioritisedInTime(const PlanProblem& problem, const GroupCheckers& group, const Deadline& deadline,
                                     PlanStatistics& statistics, const PrioritisedOptions& options)
    : problem_(problem),
      options_(options),
      common_(common_options(problem.options)),
      group_(group),
      quick_(problem.scene, group.names(), problem.checkers.options, 1, problem.checkers.planning.backend()),
      deadline_(deadline),
      statistics_(statistics) {
  for (std::size_t i = 0; i < problem.robots.size(); ++i) {
    workspaces_.push_back(quick_.alone(i).make_workspace());
    quick_.alone(i).stop_at(deadline_, *workspaces_.back());
  }
}

// --- starts and goals

void PrioritisedInTime::require_endpoints() {
  std::vector<const RobotEndpoints*> endpoints;
  for (std::size_t i = 0; i < problem_.robots.size(); ++i) endpoints.push_back(&path_of(i).endpoints);
  require_joint_endpoints(group_, endpoints);
}

/// Among what stands still: of the robots that move none stands anywhere. Its targets are free of the committed robots
/// where those rest at last.
const RobotPath& PrioritisedInTime::path_of(std::size_t i) {
  if (const auto known = paths_.find(i); known != paths_.end()) return known->second;
  const RobotProblem& part = problem_.robots[i];
  RobotPath path = find_path_alone(problem_, part, quick_.alone(i), deadline_, statistics_);
  const Checker& at_last = problem_.checkers.planning.alone(i);
  const auto workspace = at_last.make_workspace();
  at_last.stop_at(deadline_, *workspace);
  std::string why;
  try {
    std::erase_if(path.endpoints.targets, [&](const Eigen::VectorXd& target) {
      const std::string wrong = invalidity(at_last, target, *workspace);
      if (why.empty()) why = wrong;
      return !wrong.empty();
    });
  } catch (const MotionCheckStopped&) {
    throw PlanningError(stop_status(deadline_).value_or(Status::timed_out),
                        "robot '" + part.robot + "': the plan was stopped while its goals were checked");
  }
  if (path.endpoints.targets.empty() && !why.empty())
    throw PlanningError(Status::goal_invalid, "robot '" + part.robot + "': the goal is invalid: " + why);
  return paths_.emplace(i, std::move(path)).first->second;
}

// --- plans

std::optional<PrioritisedInTime::Motions> PrioritisedInTime::plan(const Motions& at_once) {
  std::vector<std::size_t> order(problem_.robots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::set<std::vector<std::size_t>> tried;
  while (tried.insert(order).second && !deadline_.stop_requested()) {
    Motions found;
    const auto stuck = std::find_if_not(order.begin(), order.end(), [&](std::size_t i) {
      std::uint64_t checks = options_.max_checks;
      return plan_one(i, at_once, {std::numeric_limits<double>::infinity(), options_.max_roadmaps, checks, deadline_},
                      found);
    });
    if (stuck == order.end()) return found;
    std::rotate(order.begin(), stuck, std::next(stuck));
  }
  return std::nullopt;
}

std::optional<PrioritisedInTime::Motions> PrioritisedInTime::plan_earlier(const Motions& at_once, double before) {
  std::uint64_t checks = options_.checks_for_earlier;
  Motions found;
  try {
    for (std::size_t i = 0; i < problem_.robots.size(); ++i)
      if (!plan_one(i, at_once, {before, 1, checks, deadline_}, found)) return std::nullopt;
  } catch (const PlanningError&) {
    return std::nullopt;  // no path of a robot alone was found, or not in time
  }
  return found;
}

/// Adds the robot's motion to `done`; false: none was found.
bool PrioritisedInTime::plan_one(std::size_t i, const Motions& at_once, const TimedBudget& budget, Motions& done) {
  const RobotProblem& part = problem_.robots[i];
  const std::vector<MovingRobot> others = others_of(i, done);
  if (const auto known = at_once.find(part.robot);
      known != at_once.end() && end_of(known->second) < budget.max_arrival) {
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    CollisionMonitor monitor(others, budget.deadline);
    const bool collision_free = !monitor.find(known->second);
    budget.checks -= std::min(budget.checks, monitor.checks());
    if (collision_free) {
      done.emplace(part.robot, known->second);
      return true;
    }
  }
  const TimedTask task = task_of(i, at_once, others);
  const PhaseTimer timer(deadline_, statistics_.search_time_s);
  TimedResult result = plan_in_time(task, budget);
  statistics_.expansions += result.expansions;
  statistics_.edge_checks += result.edge_checks;
  statistics_.memory_bytes = std::max(statistics_.memory_bytes, result.memory_bytes);
  if (result.status != Status::solved) return false;
  result.motion.robot = part.placed;
  done.emplace(part.robot, std::move(result.motion));
  return true;
}

std::vector<MovingRobot> PrioritisedInTime::others_of(std::size_t i, const Motions& done) const {
  std::vector<MovingRobot> others;
  for (std::size_t j = 0; j < group_.size(); ++j) {
    const std::string& name = group_.names()[j];
    const Trajectory* motion = nullptr;
    if (const auto committed = problem_.obstacles.find(name); committed != problem_.obstacles.end())
      motion = &committed->second;
    else if (const auto planned = done.find(name); planned != done.end())
      motion = &planned->second;
    if (!motion || !group_.may_conflict(i, j)) continue;
    const auto [a, b] = std::minmax(i, j);
    others.push_back({quick_.pair(a, b), group_.pair(a, b), j < i, motion});
  }
  return others;
}

/// Its path among what stands still leads the search; where it arrives at once is a target too.
TimedTask PrioritisedInTime::task_of(std::size_t i, const Motions& at_once, const std::vector<MovingRobot>& others) {
  const RobotProblem& part = problem_.robots[i];
  const Checker& checker = quick_.alone(i);
  const RobotPath& path = path_of(i);
  TimedTask task{checker,
                 group_.alone(i),
                 others,
                 path.endpoints.start,
                 path.endpoints.targets,
                 unstack_waypoints(path.waypoints),
                 scaled(part.limits, common_),
                 part.constraints.get(),
                 {}};
  if (const auto known = at_once.find(part.robot); known != at_once.end() && !part.may_end_anywhere()) {
    const Eigen::VectorXd end = known->second.positions.bottomRows(1).transpose();
    if (std::find(task.targets.begin(), task.targets.end(), end) == task.targets.end()) task.targets.push_back(end);
  }
  task.parameterize = [this, &checker, &workspace = *workspaces_[i], limits = task.limits,
                       robot = part.placed](const RowMatrix& rows) {
    TimingOptions timing = timing_options(common_, common_.blend_deviation);
    timing.reach = checker.reach();
    timing.robot = robot;
    timing.deadline = &deadline_;
    timing.is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return checker.is_free(a, workspace) && checker.is_motion_free(a, b, workspace, {.start_is_free = true});
    };
    return time_parameterize(rows, checker.robot().joint_names(), limits, timing);
  };
  return task;
}

}  // namespace srmp
