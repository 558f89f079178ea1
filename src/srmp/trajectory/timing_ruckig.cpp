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

}  // namespace

/// Ruckig works with absolute tolerances, so it is given a problem of size 1: unit displacement, and a unit of time
/// such that the tightest limit is 1. Limits far above that change nothing and are cut to where its numbers stay good.
Knots time_with_ruckig(const PathSegment& segment, const MotionLimits& limits, double start_speed, double end_speed) {
  const Eigen::VectorXd displacement = segment.direction * segment.length;
  const double velocity = smallest_ratio(limits.velocity, displacement);
  const double acceleration = smallest_ratio(limits.acceleration, displacement);
  const double jerk = smallest_ratio(limits.jerk, displacement);
  const double scale = std::max({1.0 / velocity, std::sqrt(1.0 / acceleration), std::cbrt(1.0 / jerk)});

  ruckig::InputParameter<1> input;
  input.current_position = {0.0};
  input.target_position = {1.0};
  input.current_velocity = {start_speed / segment.length * scale};
  input.target_velocity = {end_speed / segment.length * scale};
  input.max_velocity = {std::min(velocity * scale, 1e2)};
  input.max_acceleration = {std::min(acceleration * scale * scale, 1e4)};
  input.max_jerk = {std::min(jerk * scale * scale * scale, 1e6)};
  ruckig::Ruckig<1> solver;
  ruckig::Trajectory<1> profile;
  const ruckig::Result result = solver.calculate(input, profile);
  if (result != ruckig::Result::Working && result != ruckig::Result::Finished)
    throw Error("Ruckig found no timing (error " + std::to_string(static_cast<int>(result)) + "): length " +
                to_text(displacement.norm()) + ", limits along it " + to_text(velocity) + "/s, " +
                to_text(acceleration) + "/s^2, " + to_text(jerk) + "/s^3");

  // The jerk is constant between these times: a cubic each. The shortest phases go into those before them; times are
  // sums, so their length would be lost in rounding.
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
    knots.add(t * scale, segment.start + std::clamp(s, 0.0, 1.0) * displacement, displacement * (speed / scale));
  }
  return knots;
}

}  // namespace srmp::detail
