#include "srmp/planning/holding.hpp"

#include <algorithm>

#include "srmp/planning/certificates/certify_together.hpp"
#include "srmp/planning/certificates/verify_together.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/post_process.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

Trajectory at_rest(const MultiRobotPart& part, bool timed) {
  const Eigen::Index rows = timed ? 1 : 0;
  const RowMatrix row = part.start.transpose(), zero = RowMatrix::Zero(rows, part.start.size());
  Trajectory trajectory{part.placed->model->joint_names(), row, zero, zero, Eigen::VectorXd::Zero(rows), row};
  trajectory.robot = part.placed;
  return trajectory;
}

}  // namespace

HoldingRobots::HoldingRobots(Scene& scene, std::vector<MultiRobotPart> robots, std::vector<std::string> moving)
    : scene_(scene), robots_(std::move(robots)), moving_(std::move(moving)) {
  for (MultiRobotPart& part : robots_) {
    const RobotModel& model = *part.placed->model;
    part.start = model.clamped(part.start, limit_tolerance);
    if (!model.limit_violation(part.start)) scene.set_qpos(part.robot, part.start);
  }
}

void HoldingRobots::require_starts(const Deadline& deadline, PlanStatistics& statistics) const {
  const auto require = [&](const MultiRobotPart& part, const std::string& why) {
    if (why.empty()) return;
    const PlanningError error(Status::start_invalid, "robot '" + part.robot + "': the start is invalid: " + why);
    note_failure(error, deadline, statistics);
    throw error;
  };
  for (const MultiRobotPart& part : robots_)
    require(part, part.placed->model->limit_violation(part.start).value_or(""));
  for (const MultiRobotPart& part : robots_) require(part, contact(part));
}

std::string HoldingRobots::contact(const MultiRobotPart& part) const {
  const auto checker = make_checker(scene_, part.robot, {.mode = CheckMode::coal, .excluded_robots = moving_});
  return invalidity(*checker, part.start, *checker->make_workspace());
}

void HoldingRobots::join(MultiTrajectory& motions, const CommittedMotions& committed, const CommonOptions& options,
                         const Deadline& deadline, PlanStatistics& statistics) const {
  const bool timed = options.timing != "none";
  std::map<std::string, Trajectory> others = committed;
  for (const auto& [name, motion] : motions.robots) others.emplace(name, numbered(motion));
  const PhaseTimer timer(deadline, statistics.verification_time_s);
  const Deadline until(std::max(deadline.remaining(), 0.0) + post::grace_period, [&] { return deadline.cancelled(); });
  for (const MultiRobotPart& part : robots_) {
    Trajectory rest = at_rest(part, timed);
    if (options.certify) {
      Certificate certificate = certify_among(scene_, part.robot, numbered(rest), others, scaled(part.limits, options),
                                              {.limits = timed, .deadline = &until});
      seal(rest, std::move(certificate), part.robot, statistics);
    }
    motions.robots.emplace(part.robot, std::move(rest));
  }
  statistics.total_time_s = deadline.elapsed();
}

}  // namespace srmp
