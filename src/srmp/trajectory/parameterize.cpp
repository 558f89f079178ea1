#include "srmp/trajectory/parameterize.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ruckig/ruckig.hpp>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

constexpr double max_samples = 1e7;
constexpr double min_duration = 1e-6;     // [s] of a segment: times must grow even where a path is very long
constexpr double rounding_margin = 1e-9;  // relative: the numbers reported must not exceed a limit by their last bit

using Ruckig = ruckig::Ruckig<1>;
using Profile = ruckig::Trajectory<1>;

/// One straight segment: the share s in [0, 1] of the way as a function of time.
struct Segment {
  Eigen::RowVectorXd from;
  Eigen::RowVectorXd way;
  double scale{};  // [s]: the profile's unit of time
  Profile profile;

  double duration() const { return profile.get_duration() * scale; }
};

double smallest_ratio(const Eigen::VectorXd& limit, const Eigen::RowVectorXd& way) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < way.size(); ++j)
    if (way[j] != 0.0) smallest = std::min(smallest, limit[j] / std::abs(way[j]));
  return smallest * (1.0 - rounding_margin);
}

/// Ruckig works with absolute tolerances, so it is given a problem of size 1: unit way, and a unit of time such that
/// the tightest limit is 1. Limits far above that change nothing and are cut to where its numbers stay good.
Segment make_segment(ConstRows waypoints, Eigen::Index from, Eigen::Index to, const MotionLimits& limits) {
  Segment segment{waypoints.row(from), waypoints.row(to) - waypoints.row(from), 0.0, {}};
  const double velocity = smallest_ratio(limits.velocity, segment.way);
  const double acceleration = smallest_ratio(limits.acceleration, segment.way);
  const double jerk = smallest_ratio(limits.jerk, segment.way);
  segment.scale = std::max({1.0 / velocity, std::sqrt(1.0 / acceleration), std::cbrt(1.0 / jerk), min_duration});

  ruckig::InputParameter<1> input;
  input.current_position = {0.0};
  input.target_position = {1.0};
  input.max_velocity = {std::min(velocity * segment.scale, 1e2)};
  input.max_acceleration = {std::min(acceleration * segment.scale * segment.scale, 1e4)};
  input.max_jerk = {std::min(jerk * segment.scale * segment.scale * segment.scale, 1e6)};
  Ruckig otg;
  const ruckig::Result result = otg.calculate(input, segment.profile);
  if (result != ruckig::Result::Working && result != ruckig::Result::Finished)
    throw Error("time parameterisation failed between waypoints " + std::to_string(from) + " and " +
                std::to_string(to) + " (Ruckig error " + std::to_string(static_cast<int>(result)) + "): length " +
                to_text(segment.way.norm()) + ", limits along it " + to_text(velocity) + "/s, " +
                to_text(acceleration) + "/s^2, " + to_text(jerk) + "/s^3");
  return segment;
}

std::vector<Segment> make_segments(ConstRows waypoints, const MotionLimits& limits) {
  std::vector<Segment> segments;
  for (Eigen::Index i = 1; i < waypoints.rows(); ++i)
    if (waypoints.row(i) != waypoints.row(i - 1)) segments.push_back(make_segment(waypoints, i - 1, i, limits));
  return segments;
}

/// Grows a trajectory sample by sample.
class Samples {
 public:
  Samples(std::size_t capacity, Eigen::Index dof) : dof_(dof) {
    times_.reserve(capacity);
    for (auto* rows : {&positions_, &velocities_, &accelerations_})
      rows->reserve(capacity * static_cast<std::size_t>(dof));
  }

  void add_moving(double time, const Segment& segment, double time_in_segment) {
    double s{}, velocity{}, acceleration{};
    segment.profile.at_time(time_in_segment / segment.scale, s, velocity, acceleration);
    s = std::clamp(s, 0.0, 1.0);
    add(time, segment.from + s * segment.way, segment.way * (velocity / segment.scale),
        segment.way * (acceleration / segment.scale / segment.scale));
  }
  void add_resting(double time, const Eigen::RowVectorXd& position) {
    const Eigen::RowVectorXd zero = Eigen::RowVectorXd::Zero(dof_);
    add(time, position, zero, zero);
  }

  Trajectory finish(const std::vector<std::string>& joint_names, ConstRows waypoints) const {
    const auto n = static_cast<Eigen::Index>(times_.size());
    const auto rows = [&](const std::vector<double>& v) { return Eigen::Map<const RowMatrix>(v.data(), n, dof_); };
    return {joint_names,
            rows(positions_),
            rows(velocities_),
            rows(accelerations_),
            Eigen::Map<const Eigen::VectorXd>(times_.data(), n),
            waypoints};
  }

 private:
  void add(double time, const Eigen::RowVectorXd& q, const Eigen::RowVectorXd& v, const Eigen::RowVectorXd& a) {
    times_.push_back(time);
    positions_.insert(positions_.end(), q.begin(), q.end());
    velocities_.insert(velocities_.end(), v.begin(), v.end());
    accelerations_.insert(accelerations_.end(), a.begin(), a.end());
  }

  Eigen::Index dof_;
  std::vector<double> times_, positions_, velocities_, accelerations_;
};

}  // namespace

Trajectory time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                             const MotionLimits& limits, double sample_period) {
  require_waypoints(waypoints, joint_names);
  require_limits(limits, joint_names);
  require_short_way(waypoints, limits.continuous, joint_names);
  require_positive(sample_period, "sample period");

  const std::vector<Segment> segments = make_segments(waypoints, limits);
  double duration = 0.0;
  for (const Segment& segment : segments) duration += segment.duration();
  if (!(duration / sample_period < max_samples))
    throw InvalidArgument("a sample period of " + to_text(sample_period) +
                          " s would give more than ten million samples of this " + to_text(duration) +
                          " s motion; use a longer one");

  Samples samples(static_cast<std::size_t>(duration / sample_period) + segments.size() + 2, waypoints.cols());
  samples.add_resting(0.0, waypoints.row(0));
  double begin = 0.0;
  double tick = 1.0;  // the next sample is at tick * sample_period: multiplied, not added up, so it does not drift
  const double gap = std::min(1e-3 * sample_period, 1e-3 * min_duration);  // keeps samples and ends apart
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double end = begin + segments[i].duration();
    for (; tick * sample_period < end - gap; tick += 1.0)
      if (tick * sample_period > begin + gap)
        samples.add_moving(tick * sample_period, segments[i], tick * sample_period - begin);
    samples.add_resting(end,
                        i + 1 < segments.size() ? segments[i + 1].from : Eigen::RowVectorXd(waypoints.bottomRows(1)));
    begin = end;
  }
  return samples.finish(joint_names, waypoints);
}

}  // namespace srmp
