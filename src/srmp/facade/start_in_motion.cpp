#include "srmp/facade/start_in_motion.hpp"

#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/trajectory/link_speeds.hpp"
#include "srmp/trajectory/stop.hpp"

namespace srmp {

namespace {

constexpr double stop_margin = 1.02;      // of the distance in which the robot stops
constexpr double shortest_lead = 1e-4;    // [rad or m]
constexpr double along_tolerance = 1e-6;  // relative: of an acceleration beside the velocity
constexpr double speed_tolerance = 1e-6;  // relative: by which a velocity may exceed its limit

bool is_zero(const Eigen::VectorXd& values) { return values.size() == 0 || values.isZero(0.0); }

Eigen::VectorXd or_zero(const Eigen::VectorXd& values, Eigen::Index size) {
  return values.size() ? values : Eigen::VectorXd::Zero(size);
}

/// At the start, to which no motion could be slow enough otherwise.
void require_link_speeds(const PlanRequest& request, const PlacedRobot& robot, const MotionLimits& limits) {
  if (request.start_velocity.size() == 0) return;
  for (const LinkSpeedLimit& limit : limits.link_speeds) {
    LinkSpeeds speeds;
    speeds.add(*robot.model, robot.other_positions, {limit});
    const double use = speeds.use(request.start, request.start_velocity);
    if (use > 1.0 + speed_tolerance)
      throw InvalidArgument("the start velocity moves " +
                            (limit.link.empty() ? "the end effector" : "link '" + limit.link + "'") + " at " +
                            to_text(use) + " times its speed limit");
  }
}

}  // namespace

TimingMethod timing_in_motion(const CommonOptions& options) {
  if (options.timing == "none")
    throw InvalidArgument("timing is 'none', but a motion that begins in motion needs 'toppra' or 'ruckig'");
  return timing_options(options, 0.0).method;
}

void require_no_sample_rate(const CommonOptions& options, const std::string& what) {
  if (options.sample_rate > 0.0)
    throw NotSupported("option 'sample_rate' is " + to_text(options.sample_rate) + " Hz, but " + what +
                       " has no even rows; leave the option out");
}

void require_start_in_motion(const PlanRequest& request, const PlacedRobot& placed, const MotionLimits& limits,
                             const CommonOptions& options) {
  const RobotModel& robot = *placed.model;
  const Eigen::VectorXd &velocity = request.start_velocity, &acceleration = request.start_acceleration;
  if (velocity.size()) robot.require_configuration(velocity, "start_velocity of '" + request.robot + "'");
  if (acceleration.size()) robot.require_configuration(acceleration, "start_acceleration of '" + request.robot + "'");
  if (is_zero(velocity) && is_zero(acceleration)) return;
  const bool ruckig = timing_in_motion(options) == TimingMethod::ruckig;
  require_no_sample_rate(options, "a motion that begins in motion");
  const auto require_limit = [&](const Eigen::VectorXd& values, const Eigen::VectorXd& limit, const char* what) {
    for (Eigen::Index j = 0; j < values.size(); ++j)
      if (std::abs(values[j]) > limit[j] * (1.0 + speed_tolerance))
        throw InvalidArgument(robot.joint_names()[static_cast<std::size_t>(j)] + ": the start " + what + " is " +
                              to_text(values[j]) + "; its limit is " + to_text(limit[j]));
  };
  require_limit(velocity, limits.velocity, "velocity");
  require_link_speeds(request, placed, limits);
  if (!ruckig || is_zero(acceleration)) return;
  require_limit(acceleration, limits.acceleration, "acceleration");
  if (is_zero(velocity)) return;
  const Eigen::VectorXd direction = velocity.normalized();
  if ((acceleration - acceleration.dot(direction) * direction).norm() > along_tolerance * (1.0 + acceleration.norm()))
    throw InvalidArgument(
        "start_acceleration does not have the direction of start_velocity: with limits of the jerk (timing 'ruckig') "
        "a motion goes on straight ahead");
}

void begin_in_motion(RobotProblem& robot, const PlanRequest& request, const CommonOptions& options) {
  if (is_zero(request.start_velocity) && is_zero(request.start_acceleration)) return;
  const TimingMethod method = timing_in_motion(options);
  const Eigen::Index dof = robot.start.size();
  StartInMotion begin{request.start, or_zero(request.start_velocity, dof), Eigen::VectorXd::Zero(dof)};
  if (method == TimingMethod::ruckig) begin.acceleration = or_zero(request.start_acceleration, dof);
  if (is_zero(begin.velocity) && is_zero(begin.acceleration)) return;
  Eigen::VectorXd lead =
      stop_margin * straight_stop(begin.velocity, begin.acceleration, scaled(robot.limits, options), method);
  if (lead.norm() < shortest_lead)
    lead = shortest_lead * (is_zero(begin.velocity) ? begin.acceleration : begin.velocity).normalized();
  robot.start += lead;
  robot.start_in_motion = std::move(begin);
}

}  // namespace srmp
