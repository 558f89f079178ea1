#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "srmp/core/interruption.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/facade/plan_many.hpp"
#include "srmp/facade/problem_file.hpp"
#include "srmp/facade/request_checks.hpp"
#include "srmp/facade/scene_checkers.hpp"
#include "srmp/facade/start_in_motion.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"
#include "srmp/planning/options/registry.hpp"
#include "srmp/planning/pipeline.hpp"
#include "srmp/planning/stationary_robots.hpp"

namespace srmp {

/// What a PlannerInterface holds, and what its members share.
struct PlannerInterface::Impl {
  Scene scene;
  PlannerTable planners;
  mutable SceneCheckers checkers;
  UserHeuristics heuristics;
  std::map<std::string, MotionLimits> motion_limits;  // of the user; other robots have default_limits
  PlanStatistics statistics;                          // of the last plan
  std::optional<LastRequest> request;                 // of the last plan
  std::optional<LastResult> result;                   // of it, while nothing that it depends on has changed

  /// Runs a change of the scene.
  template <class Change>
  void change(Change&& apply) {
    apply(scene);
    checkers.scene_changed();
    result.reset();
  }

  /// Planners, checkers and the last request go with their robots.
  template <class Gone>
  void forget(Gone&& gone) {
    checkers.clear();
    std::erase_if(planners,
                  [&](const auto& entry) { return std::any_of(entry.first.begin(), entry.first.end(), gone); });
    if (request && std::visit([&](const auto& last) { return names_any(last, gone); }, *request)) request.reset();
    std::erase_if(motion_limits, [&](const auto& entry) { return gone(entry.first); });
  }

  /// Single queries go to Coal alone, so that they do not wait for sphere covers.
  const Checker& checker(const std::string& robot) const { return checkers.of(scene, robot, CheckMode::coal); }

  const RobotModel& model(const std::string& robot) const { return *scene.robot(robot).model; }

  MotionLimits limits_of(const std::string& robot) const {
    const RobotModel& model = this->model(robot);
    const auto set = motion_limits.find(robot);
    return set == motion_limits.end() ? default_limits(model) : set->second;
  }

  void require_state(const std::string& robot, ConstVector q) const {
    model(robot).require_configuration(q, "q of '" + robot + "'");
  }

  const PlannerOptions& planner_options(const std::vector<std::string>& robots) const {
    const auto it = planners.find(planner_key(scene, robots));
    return it == planners.end() ? registry().front().defaults : it->second;
  }

  std::vector<std::string> heuristic_names() const {
    std::vector<std::string> names;
    for (const auto& [name, heuristic] : heuristics) names.push_back(name);
    return names;
  }

  std::shared_ptr<const PlacedRobot> placed(const std::string& robot) const {
    const RobotInstance& instance = scene.robot(robot);
    return std::make_shared<const PlacedRobot>(PlacedRobot{instance.model, instance.base, instance.other_positions});
  }

  RobotProblem robot_problem(const std::string& robot, ConstVector start, std::vector<GoalConstraint> goals) const {
    return {robot, start, std::move(goals), limits_of(robot), placed(robot)};
  }

  void require_problem(const PlanRequest& request, const PlannerOptions& options) const {
    require_heuristics(options, heuristic_names());
    require_robots(options, {request.robot});
    require_planner_for_one(options);
    require_backend_keeps_clearance(options);
    require_request(scene, request.robot, request.start, request.goals);
    place_constraints(scene, request.robot, request.constraints);  // throws
    require_start_in_motion(request, *placed(request.robot), scaled(limits_of(request.robot), common_options(options)),
                            common_options(options));
  }

  void require_backend_keeps_clearance(const PlannerOptions& options) const {
    if (checkers.has_other_backend()) require_no_clearance(options, "a collision backend of your own");
  }

  /// Forgets the last plan.
  void begin(LastRequest next) {
    request = std::move(next);
    result.reset();
    statistics = {};
  }

  /// Prepares robots and makes checkers; the statistics tell when the deadline ends that.
  template <class Make>
  auto make_checkers(const Deadline& deadline, Make&& make) {
    const InterruptionScope scope([&] { stop_if_late(deadline, "collision checkers were made"); });
    try {
      checkers.prepare_in_background(scene);
      return make();
    } catch (const PlanningError& error) {
      record_failure(error, deadline, statistics);
      throw;
    }
  }

  /// The problem of one robot in the scene as it is now; the scene and the heuristics must outlive it.
  OwnedProblem problem_of(const PlanRequest& request, const PlannerOptions& options,
                          const OnSolution& on_solution = {}) const {
    OwnedProblem owned{checkers.of_one(scene, request.robot, common_options(options).clearance),
                       std::make_unique<const PlannerOptions>(options),
                       {}};
    RobotProblem robot = robot_problem(request.robot, request.start, request.goals);
    robot.constraints = place_constraints(scene, request.robot, request.constraints);
    begin_in_motion(robot, request, common_options(options));
    owned.problem = std::make_unique<const PlanProblem>(
        PlanProblem{scene, {std::move(robot)}, *owned.checkers, *owned.options, heuristics, on_solution});
    return owned;
  }

  /// A path of one robot in time, with a certificate; corners are rounded by `blend_deviation` [m] at most.
  Trajectory timed(const PlanRequest& request, const RowMatrix& waypoints, double blend_deviation,
                   const Deadline::Interrupt& interrupt) {
    PlannerOptions options = planner_options({request.robot});
    std::visit([&](auto& typed) { typed.common.blend_deviation = blend_deviation; }, options);
    const Deadline deadline(common_options(options).time_limit, interrupt);
    const OwnedProblem owned = make_checkers(deadline, [&] { return problem_of(request, options); });
    JointPaths paths;
    paths.smoothed.push_back(path_of_one(waypoints));
    ParallelWork work(1, statistics);
    MultiTrajectory motions = certified_timing(*owned.problem, std::move(paths), 0, work, deadline, statistics);
    return std::move(motions.robots.begin()->second);
  }

  /// One robot's of many.
  VerifyOptions verify_options(const std::string& robot, const Trajectory& motion,
                               const MultiVerifyOptions& options) const {
    VerifyOptions own{.jerk = options.jerk,
                      .at_rest = options.at_rest,
                      .max_deviation = options.max_deviation,
                      .gap_tolerance = options.gap_tolerance};
    if (const auto start = options.starts.find(robot); start != options.starts.end()) own.start = start->second;
    const auto goal = options.goals.find(robot);
    if (goal == options.goals.end()) return own;
    goal->second.validate();
    if (goal->second.type == GoalType::hold) {
      if (own.start)
        own.goals = {GoalConstraint::joints(*own.start)};
      else if (motion.positions.rows() > 0)  // one that cannot be read has other faults
        own.goals = {GoalConstraint::joints(motion.positions.row(0).transpose())};
      return own;
    }
    if (!goal->second.targets.empty()) own.goals = {goal->second};
    if (!own.goals.empty()) require_request(scene, robot, own.start.value_or(scene.robot(robot).q), own.goals);
    return own;
  }

  /// The robots of a request for many: those that move, or those that are stationary.
  std::vector<RobotProblem> robots_of(const MultiPlanRequest& request, bool stationary) const {
    std::vector<RobotProblem> found;
    for (const auto& [name, start] : request.starts) {
      const auto goal = request.goals.find(name);
      const GoalConstraint& own = goal == request.goals.end() ? GoalConstraint::hold() : goal->second;
      if ((own.type == GoalType::hold) == stationary) found.push_back(robot_problem(name, start, {own}));
    }
    return found;
  }

  /// Throws as place_constraints.
  void require_constraints(const MultiPlanRequest& request) const {
    const std::vector<std::string> moving = moving_robots(request);
    for (const auto& [name, own] : request.constraints) place_constraints(scene, name, own, moving);
  }

  /// In a scene where robots that hold stand at their starts.
  static void place_all(const MultiPlanRequest& request, const Scene& now, std::vector<RobotProblem>& robots) {
    const std::vector<std::string> moving = moving_robots(request);
    for (RobotProblem& robot : robots)
      if (const auto own = request.constraints.find(robot.robot); own != request.constraints.end())
        robot.constraints = place_constraints(now, robot.robot, own->second, moving);
  }

  /// Of robots that are verified together, by name; robots whose motions do not move stand where these are.
  std::map<std::string, std::shared_ptr<const PlacedConstraints>> place_all(
      const MultiVerifyOptions& options, const std::map<std::string, Trajectory>& motions) const {
    std::map<std::string, std::shared_ptr<const PlacedConstraints>> placed;
    if (options.constraints.empty()) return placed;
    Scene now = scene;
    std::vector<std::string> moving;
    for (const auto& [name, motion] : motions) {
      const RowMatrix& rows = motion.positions;
      const RobotModel& model = this->model(name);
      const bool readable =
          rows.rows() > 0 && rows.allFinite() && rows.cols() == static_cast<Eigen::Index>(model.joint_names().size());
      if (!readable || (rows.rowwise() - rows.row(0)).cwiseAbs().maxCoeff() > 0.0 ||
          model.limit_violation(rows.row(0).transpose()))
        moving.push_back(name);
      else
        now.set_qpos(name, rows.row(0).transpose());
    }
    for (const auto& [name, own] : options.constraints) placed[name] = place_constraints(now, name, own, moving);
    return placed;
  }

  /// The result of a request in a scene where robots with obstacles stand at their ends; fills the statistics.
  MultiTrajectory solve(const MultiPlanRequest& request, Scene& now, const PlannerOptions& options,
                        const Deadline& deadline) {
    std::vector<RobotProblem> stationary = robots_of(request, true), moving = robots_of(request, false);
    stand_at_starts(now, stationary);
    place_all(request, now, stationary);
    place_all(request, now, moving);
    std::vector<std::string> names;
    for (const RobotProblem& robot : moving) names.push_back(robot.robot);
    const auto threads = static_cast<std::size_t>(num_threads(options));
    const auto group = make_checkers(
        deadline, [&] { return checkers.of(scene, now, names, common_options(options).clearance, threads, deadline); });
    const PlanProblem problem{now, std::move(moving),     *group,           options, heuristics,
                              {},  std::move(stationary), request.obstacles};
    return run_pipeline(problem, deadline, statistics);
  }
};

}  // namespace srmp
