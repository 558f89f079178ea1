// PlannerInterface::stop and replan.
#include "srmp/core/error.hpp"
#include "srmp/facade/planner_impl.hpp"
#include "srmp/facade/start_in_motion.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/trajectory/near_row.hpp"
#include "srmp/trajectory/stop.hpp"

namespace srmp {

namespace {

/// The trajectory must be one of the robot's, with velocities, at which the instant t is.
void require_instant(const Trajectory& motion, double t, const RobotModel& robot) {
  motion.validate();
  if (motion.joint_names != robot.joint_names())
    throw InvalidArgument("the trajectory has the joints " + quoted_list(motion.joint_names) + "; robot '" +
                          robot.name() + "' has " + quoted_list(robot.joint_names()));
  if (!motion.timed()) throw InvalidArgument("the trajectory has no times: a path without time has no instants");
  if (motion.velocities.rows() == 0 && motion.size() > 1)
    throw InvalidArgument("the trajectory has no velocities, which a motion that goes on needs");
  const double first = motion.times[0], last = motion.times[motion.times.size() - 1];
  if (!(t >= first && t <= last))
    throw InvalidArgument("t is " + to_text(t) + " s; the motion lasts from " + to_text(first) + " to " +
                          to_text(last) + " s");
}

/// The same motion, with times from 0 on.
Trajectory from_time_0(Trajectory motion) {
  motion.times.array() -= motion.times[0];
  return motion;
}

}  // namespace

Trajectory PlannerInterface::stop(const std::string& robot, const Trajectory& motion, double t,
                                  const Interrupt& interrupt) const {
  require_instant(motion, t, impl_->model(robot));
  t = detail::time_of_near_row(motion.times, t);
  const CommonOptions& options = common_options(planner_options({robot}));
  require_no_sample_rate(options, "a stop");
  const Deadline deadline(options.time_limit, interrupt);
  TimingOptions timing = timing_options(options, 0.0);
  timing.method = timing_in_motion(options);
  timing.deadline = &deadline;
  const MotionLimits limits = scaled(impl_->limits_of(robot), options);
  Trajectory result = stop_on_path(motion, t, limits, timing);
  const MotionState at = motion.state(t);
  const bool ruckig = timing.method == TimingMethod::ruckig;
  const Certificate certificate = verify(robot, result,
                                         {.start = at.position,
                                          .limits = limits,
                                          .jerk = ruckig,
                                          .start_velocity = at.velocity,
                                          .start_acceleration = ruckig ? at.acceleration : Eigen::VectorXd()});
  if (!certificate.holds())
    throw PlanningError(Status::exhausted,
                        "the stop from " + to_text(t) + " s on is not valid: " + certificate.faults.front().text);
  result.certificate = std::make_shared<const Certificate>(certificate);
  return result;
}

Trajectory PlannerInterface::stop(const Trajectory& motion, double t, const Interrupt& interrupt) const {
  return stop(only_robot(), motion, t, interrupt);
}

Trajectory PlannerInterface::replan(const Trajectory& motion, double t, PlanRequest request,
                                    const Interrupt& interrupt) {
  require_instant(motion, t, impl_->model(request.robot));
  t = detail::time_of_near_row(motion.times, t);
  if (request.options) validate(*request.options);
  const CommonOptions options = common_options(request.options ? *request.options : planner_options({request.robot}));
  require_no_sample_rate(options, "a motion that leaves another one");
  const bool ruckig = timing_in_motion(options) == TimingMethod::ruckig;
  std::vector<double> instants{t};  // at which the motion may be left
  for (const double row : motion.times)
    if (row > t && request.constraints.empty()) instants.push_back(row);
  for (const double instant : instants) {
    const MotionState at = motion.state(instant);
    request.start = at.position;
    request.start_velocity = at.velocity;
    request.start_acceleration = ruckig ? at.acceleration : Eigen::VectorXd();
    try {
      Trajectory next = plan(request, interrupt);
      if (instant == t) return next;
      Trajectory whole = from_time_0(motion.slice(t, instant).followed_by(next));
      const MotionState begin = motion.state(t);
      const Certificate certificate = verify(request.robot, whole,
                                             {.start = begin.position,
                                              .goals = request.goals,
                                              .limits = scaled(impl_->limits_of(request.robot), options),
                                              .jerk = ruckig,
                                              .start_velocity = begin.velocity,
                                              .start_acceleration = ruckig ? begin.acceleration : Eigen::VectorXd()});
      if (!certificate.holds())
        throw PlanningError(Status::start_invalid,
                            "the motion cannot be left before " + to_text(instant) +
                                " s, and until then it is not valid: " + certificate.faults.front().text);
      whole.certificate = std::make_shared<const Certificate>(certificate);
      return whole;
    } catch (const PlanningError& error) {
      if (error.status() != Status::start_invalid || instant == instants.back()) throw;
    }
  }
  throw Error("internal error: no instant was tried. Please report this");
}

Trajectory PlannerInterface::replan(const std::string& robot, const Trajectory& motion, double t, const Goal& to_reach,
                                    const Interrupt& interrupt) {
  require_instant(motion, t, impl_->model(robot));
  return replan(motion, t, {.robot = robot, .goals = {goal(robot, to_reach, motion.sample(t))}}, interrupt);
}

Trajectory PlannerInterface::replan(const Trajectory& motion, double t, const Goal& goal, const Interrupt& interrupt) {
  return replan(only_robot(), motion, t, goal, interrupt);
}

}  // namespace srmp
