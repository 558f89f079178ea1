#include "srmp/planning/stationary_robots.hpp"

#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/certificates/verify_together.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/validity.hpp"
#include "srmp/trajectory/prove_constraints.hpp"

namespace srmp {

namespace {

Trajectory stationary(const RobotProblem& robot, bool timed) {
  const Eigen::Index rows = timed ? 1 : 0;
  const RowMatrix row = robot.start.transpose(), zero = RowMatrix::Zero(rows, robot.start.size());
  Trajectory trajectory{robot.placed->model->joint_names(), row, zero, zero, Eigen::VectorXd::Zero(rows), row};
  trajectory.robot = robot.placed;
  return trajectory;
}

}  // namespace

void stand_at_starts(Scene& scene, std::vector<RobotProblem>& stationary) {
  for (RobotProblem& robot : stationary) {
    const RobotModel& model = *robot.placed->model;
    robot.start = model.clamped(robot.start, limit_tolerance);
    if (!model.limit_violation(robot.start)) scene.set_qpos(robot.robot, robot.start);
  }
}

void require_stationary_starts(const PlanProblem& problem) {
  const auto require = [&](const RobotProblem& robot, const std::string& why) {
    if (why.empty()) return;
    throw PlanningError(Status::start_invalid, "robot '" + robot.robot + "': the start is invalid: " + why);
  };
  std::vector<std::string> moving;
  for (const RobotProblem& robot : problem.robots) moving.push_back(robot.robot);
  for (const auto& [name, motion] : problem.obstacles) moving.push_back(name);
  for (const RobotProblem& robot : problem.stationary)
    require(robot, robot.placed->model->limit_violation(robot.start).value_or(""));
  for (const RobotProblem& robot : problem.stationary) {
    const auto checker = make_checker(problem.scene, robot.robot, {.mode = CheckMode::coal, .excluded_robots = moving});
    require(robot, invalidity(*checker, robot.start, *checker->make_workspace()));
    if (robot.constraints) require(robot, ConstraintChecker(*robot.constraints).violation(robot.start));
  }
}

void add_stationary_robots(const PlanProblem& problem, MultiTrajectory& motions, const Deadline& deadline,
                           PlanStatistics& statistics) {
  if (problem.stationary.empty()) return;
  const CommonOptions& options = common_options(problem.options);
  const bool timed = options.timing != "none";
  std::map<std::string, Trajectory> others = problem.obstacles;
  for (const auto& [name, motion] : motions.robots) others.emplace(name, with_times(motion));
  const PhaseTimer timer(deadline, statistics.verification_time_s);
  const Deadline until = with_grace_period(deadline);
  for (const RobotProblem& robot : problem.stationary) {
    Trajectory motion = stationary(robot, timed);
    if (options.certify) {
      Certificate certificate = certify_among(problem.scene, robot.robot, with_times(motion), others,
                                              scaled(robot.limits, options), {.limits = timed, .deadline = &until});
      if (robot.constraints) add_constraints(certificate, with_times(motion), *robot.constraints, until);
      attach_certificate(motion, std::move(certificate), robot.robot, statistics);
    }
    motions.robots.emplace(robot.robot, std::move(motion));
  }
}

}  // namespace srmp
