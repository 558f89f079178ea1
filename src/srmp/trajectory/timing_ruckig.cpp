#include <algorithm>
#include <cmath>
#include <limits>
#include <ruckig/ruckig.hpp>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/timing.hpp"

namespace srmp::detail {

namespace {

constexpr double min_phase = 1e-3;   // of the duration,
constexpr double sure_phase = 1e-4;  // [s] but no more than this: the acceleration would jump

double smallest_ratio(const Eigen::VectorXd& limit, const Eigen::VectorXd& displacement) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < displacement.size(); ++j)
    if (displacement[j] != 0.0) smallest = std::min(smallest, limit[j] / std::abs(displacement[j]));
  return smallest;
}

/// The limits along a displacement, in units that make the tightest of them 1: Ruckig works with absolute tolerances.
/// Limits far above that change nothing and are cut to where its numbers stay good.
struct ScaledLimits {
  double velocity, acceleration, jerk;  // along the displacement [1/s, 1/s^2, 1/s^3]
  double scale;                         // [s] of a unit of time

  ScaledLimits(const MotionLimits& limits, const Eigen::VectorXd& displacement)
      : velocity(smallest_ratio(limits.velocity, displacement)),
        acceleration(smallest_ratio(limits.acceleration, displacement)),
        jerk(smallest_ratio(limits.jerk, displacement)),
        scale(std::max({1.0 / velocity, std::sqrt(1.0 / acceleration), std::cbrt(1.0 / jerk)})) {}

  void set(ruckig::InputParameter<1>& input) const {
    input.max_velocity = {std::min(velocity * scale, 1e2)};
    input.max_acceleration = {std::min(acceleration * scale * scale, 1e4)};
    input.max_jerk = {std::min(jerk * scale * scale * scale, 1e6)};
  }

  ruckig::Trajectory<1> solve(const ruckig::InputParameter<1>& input, const Eigen::VectorXd& displacement) const {
    ruckig::Ruckig<1> solver;
    ruckig::Trajectory<1> profile;
    const ruckig::Result result = solver.calculate(input, profile);
    if (result != ruckig::Result::Working && result != ruckig::Result::Finished)
      throw Error("Ruckig found no timing (error " + std::to_string(static_cast<int>(result)) + "): length " +
                  to_text(displacement.norm()) + ", limits along it " + to_text(velocity) + "/s, " +
                  to_text(acceleration) + "/s^2, " + to_text(jerk) + "/s^3");
    return profile;
  }
};

/// The profile along start + s * displacement. Its jerk is constant between some times: a cubic each. The shortest
/// phases go into those before them; times are sums, so their length would be lost in rounding.
Knots knots_of(const ruckig::Trajectory<1>& profile, double scale, const Eigen::VectorXd& start,
               const Eigen::VectorXd& displacement, double farthest) {
  const ruckig::Profile phases = profile.get_profiles()[0][0];
  const double duration = profile.get_duration(), shortest = std::min(min_phase * duration, sure_phase / scale);
  std::vector<double> ends{0.0};
  double end = 0.0;
  const auto add = [&](double phase) {
    end += phase;
    if (end > ends.back() + shortest) ends.push_back(end);
  };
  if (phases.brake.duration > 0.0)
    for (double t : phases.brake.t) add(t);
  for (double t : phases.t) add(t);
  ends.back() = duration;
  Knots knots;
  for (const double t : ends) {
    double s{}, speed{}, unused{};
    profile.at_time(t, s, speed, unused);
    knots.add(t * scale, start + std::clamp(s, 0.0, farthest) * displacement, displacement * (speed / scale));
  }
  return knots;
}

}  // namespace

Knots time_with_ruckig(const PathSegment& segment, const MotionLimits& limits, const EndSpeeds& ends) {
  const Eigen::VectorXd displacement = segment.direction * segment.length;
  const ScaledLimits scaled(limits, displacement);
  const double scale = scaled.scale;
  ruckig::InputParameter<1> input;
  input.current_position = {0.0};
  input.target_position = {1.0};
  input.current_velocity = {ends.start / segment.length * scale};
  input.target_velocity = {ends.end / segment.length * scale};
  input.current_acceleration = {ends.start_acceleration / segment.length * scale * scale};
  scaled.set(input);
  return knots_of(scaled.solve(input, displacement), scale, segment.start, displacement, 1.0);
}

Knots stop_with_ruckig(const Eigen::VectorXd& start, const Eigen::VectorXd& direction, double speed,
                       double acceleration, const MotionLimits& limits) {
  const ScaledLimits scaled(limits, direction);
  const double scale = scaled.scale;
  ruckig::InputParameter<1> input;
  input.control_interface = ruckig::ControlInterface::Velocity;
  input.current_position = {0.0};
  input.current_velocity = {speed * scale};
  input.current_acceleration = {acceleration * scale * scale};
  input.target_velocity = {0.0};
  scaled.set(input);
  return knots_of(scaled.solve(input, direction), scale, start, direction, std::numeric_limits<double>::infinity());
}

}  // namespace srmp::detail
