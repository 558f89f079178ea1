#include "srmp/trajectory/parameterize.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/core/stopping.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/timing.hpp"

namespace srmp {

namespace {

using detail::Knots;
using detail::PathSegment;
using detail::SmoothPath;

constexpr double same_waypoint = 1e-7;    // [rad or m]
constexpr double min_duration = 1e-3;     // [s] of a motion between stops: keeps second differences above rounding
constexpr double min_row_spacing = 5e-4;  // [s] between a row of the sample period and a knot
constexpr double rounding_margin = 1e-9;  // relative: the numbers reported must not exceed a limit by their last bit
constexpr int attempts = 6;               // to bring cubics with given end speeds within the limits
constexpr std::size_t rows_per_deadline_check = 1024, parts_per_deadline_check = 16;

void stop_if_late(const TimingOptions& options) {
  if (options.deadline)
    stop_if_late(*options.deadline,
                 "the path was timed with a sample period of " + to_text(options.sample_period) + " s");
}

/// Without waypoints that are hardly apart from the one before. The ends stay.
RowMatrix without_tiny_steps(const RowMatrix& path) {
  std::vector<Eigen::Index> kept{0};
  const auto apart = [&](Eigen::Index a, Eigen::Index b) {
    return (path.row(a) - path.row(b)).cwiseAbs().maxCoeff() > same_waypoint;
  };
  for (Eigen::Index i = 1; i + 1 < path.rows(); ++i)
    if (apart(i, kept.back())) kept.push_back(i);
  const Eigen::Index last = path.rows() - 1;
  while (kept.size() > 1 && !apart(last, kept.back())) kept.pop_back();
  if (path.row(last) != path.row(kept.back())) kept.push_back(last);
  return path(kept, Eigen::all);
}

/// The largest fraction of a limit that the cubics use, as far as the rounding of positions allows to know it: the
/// factor by which time must be stretched.
double limit_use(const Knots& knots, const MotionLimits& limits, bool with_jerk) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < knots.times.size(); ++i)
    for (Eigen::Index j = 0; j < limits.velocity.size(); ++j) {
      const double h = knots.times[i + 1] - knots.times[i], q = knots.positions[i][j];
      const double rounding = std::numeric_limits<double>::epsilon() * (1.0 + std::abs(q));
      const detail::Cubic segment =
          detail::hermite(q, knots.velocities[i][j], knots.positions[i + 1][j], knots.velocities[i + 1][j], h);
      const auto fraction = [](double value, double unknown, double limit) {
        return std::max(0.0, std::abs(value) - unknown) / limit;
      };
      for (const double u : {0.0, segment.velocity_extremum(), h})
        largest = std::max(largest, fraction(segment.velocity(u), 2 * rounding / h, limits.velocity[j]));
      for (const double u : {0.0, h})
        largest = std::max(largest,
                           std::sqrt(fraction(segment.acceleration(u), 12 * rounding / h / h, limits.acceleration[j])));
      if (with_jerk)
        largest = std::max(largest, std::cbrt(fraction(segment.jerk(), 36 * rounding / h / h / h, limits.jerk[j])));
    }
  return largest;
}

void stretch_time(Knots& knots, double factor) {
  for (double& time : knots.times) time *= factor;
  for (Eigen::VectorXd& velocity : knots.velocities) velocity /= factor;
}

/// The timing of a path between two stops, or from or to a given speed at an end of the whole motion.
class SmoothPathTiming {
 public:
  SmoothPathTiming(const SmoothPath& path, const MotionLimits& limits, TimingMethod method, double start_speed,
                   double end_speed)
      : path_(path), limits_(limits), method_(method), start_speed_(start_speed), end_speed_(end_speed) {}

  Knots time() const {
    if (start_speed_ != 0.0 || end_speed_ != 0.0) return time_between_speeds();
    Knots knots = solve(limits_);
    if (const double use = limit_use(knots, limits_, jerk_limited()) * (1.0 + rounding_margin); use > 1.0)
      stretch_time(knots, use);
    if (knots.times.back() < min_duration) stretch_time(knots, min_duration / knots.times.back());
    return knots;
  }

 private:
  bool jerk_limited() const { return method_ == TimingMethod::ruckig; }

  Knots solve(const MotionLimits& limits) const {
    return jerk_limited() ? time_with_ruckig(path_.front(), limits, start_speed_, end_speed_)
                          : time_with_toppra(path_, limits, start_speed_, end_speed_);
  }

  /// Time cannot be stretched without changing the speeds at the ends, so the limits are tightened.
  Knots time_between_speeds() const {
    MotionLimits limits = limits_;
    for (int i = 0; i < attempts; ++i) {
      Knots knots = solve(limits);
      const double use = limit_use(knots, limits_, jerk_limited());
      if (use <= 1.0 + rounding_margin) return knots;
      limits.acceleration /= use * use * (1.0 + 1e-6);
      limits.jerk /= use * use * use * (1.0 + 1e-6);
    }
    throw Error("no timing keeps the limits");
  }

  const SmoothPath& path_;
  const MotionLimits& limits_;
  TimingMethod method_;
  double start_speed_, end_speed_;
};

/// ds/dt at an end of the path for this velocity.
double speed_along(const Eigen::VectorXd& velocity, const Eigen::VectorXd& direction, const MotionLimits& limits,
                   const std::vector<std::string>& joint_names, const std::string& what) {
  if (velocity.size() == 0) return 0.0;
  if (velocity.size() != direction.size())
    throw InvalidArgument(what + " has " + std::to_string(velocity.size()) + " entries, but there are " +
                          std::to_string(direction.size()) + " joints");
  require_finite({velocity.data(), static_cast<std::size_t>(velocity.size())}, what, joint_names);
  for (Eigen::Index j = 0; j < velocity.size(); ++j)
    if (std::abs(velocity[j]) > limits.velocity[j] * (1.0 + 1e-9))
      throw InvalidArgument(joint_names[static_cast<std::size_t>(j)] + ": the " + what + " " + to_text(velocity[j]) +
                            " is above the limit " + to_text(limits.velocity[j]));
  const double speed = velocity.dot(direction) / direction.squaredNorm();
  if (speed < 0.0 || (velocity - speed * direction).norm() > 1e-6 * (1e-3 + velocity.norm()))
    throw InvalidArgument(what + " does not point along the path's " + (what == "start velocity" ? "first" : "last") +
                          " segment");
  return speed;
}

Knots time_all(const std::vector<SmoothPath>& paths, const MotionLimits& limits, const TimingOptions& options,
               const std::vector<std::string>& names) {
  const PathSegment &first = paths.front().front(), &last = paths.back().back();
  const double start_speed = speed_along(options.start_velocity, first.direction, limits, names, "start velocity");
  const double end_speed = speed_along(options.end_velocity, last.direction, limits, names, "end velocity");
  Knots all;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if ((i + 1) % parts_per_deadline_check == 0) stop_if_late(options);
    const double from = i == 0 ? start_speed : 0.0, to = i + 1 == paths.size() ? end_speed : 0.0;
    Knots part;
    try {
      part = SmoothPathTiming(paths[i], limits, options.method, from, to).time();
    } catch (const Error& error) {
      const std::string where = "part " + std::to_string(i + 1) + " of " + std::to_string(paths.size());
      if (from == 0.0 && to == 0.0) throw Error("time parameterisation failed on " + where + ": " + error.what());
      throw InvalidArgument("the limits do not allow to " + std::string(from != 0.0 ? "start" : "end") +
                            " at the given velocity on this path (" + where + ": " + error.what() + ")");
    }
    const double begin = all.times.empty() ? 0.0 : all.times.back();
    for (std::size_t k = all.times.empty() ? 0 : 1; k < part.times.size(); ++k)
      all.add(begin + part.times[k], std::move(part.positions[k]), std::move(part.velocities[k]));
  }
  return all;
}

/// Rows at the knots and at the multiples of the sample period between them, all of the same cubics.
Trajectory to_rows(const Knots& knots, const std::vector<std::string>& joint_names, ConstRows waypoints,
                   const TimingOptions& options) {
  const double sample_period = options.sample_period;
  std::vector<std::pair<double, std::size_t>> rows;  // time, and the knot before
  double tick = 1.0;                                 // multiplied, not added up, so it does not drift
  for (std::size_t i = 0; i < knots.times.size(); ++i) {
    rows.emplace_back(knots.times[i], i);
    if (i + 1 == knots.times.size()) break;
    const double spacing = std::min(min_row_spacing, 0.1 * sample_period);
    for (; tick * sample_period < knots.times[i + 1] - spacing; tick += 1.0) {
      if (tick * sample_period > knots.times[i] + spacing) rows.emplace_back(tick * sample_period, i);
      if (rows.size() % rows_per_deadline_check == 0) stop_if_late(options);
    }
  }
  const auto n = static_cast<Eigen::Index>(rows.size()), dof = waypoints.cols();
  Trajectory result{joint_names, RowMatrix(n, dof), RowMatrix(n, dof), RowMatrix(n, dof), Eigen::VectorXd(n), waypoints,
                    nullptr};
  for (Eigen::Index row = 0; row < n; ++row) {
    const auto [time, i] = rows[static_cast<std::size_t>(row)];
    if ((static_cast<std::size_t>(row) + 1) % rows_per_deadline_check == 0) stop_if_late(options);
    result.times[row] = time;
    const bool knot = time == knots.times[i];
    const std::size_t a = i + 1 < knots.times.size() ? i : i - (i > 0), b = std::min(a + 1, knots.times.size() - 1);
    for (Eigen::Index j = 0; j < dof; ++j) {
      if (b == a) {
        result.positions(row, j) = knots.positions[a][j];
        result.velocities(row, j) = result.accelerations(row, j) = 0.0;
        continue;
      }
      const detail::Cubic segment =
          detail::hermite(knots.positions[a][j], knots.velocities[a][j], knots.positions[b][j], knots.velocities[b][j],
                          knots.times[b] - knots.times[a]);
      const double u = time - knots.times[a];
      result.positions(row, j) = knot ? knots.positions[i][j] : segment.position(u);
      result.velocities(row, j) = knot ? knots.velocities[i][j] : segment.velocity(u);
      result.accelerations(row, j) = segment.acceleration(u);
    }
  }
  return result;
}

void require_options(const TimingOptions& options, Eigen::Index dof) {
  require_positive(options.sample_period, "sample period");
  if (!(options.blend_deviation >= 0.0))
    throw InvalidArgument("blend deviation is " + to_text(options.blend_deviation) + "; it must be 0 m or above");
  if (options.reach.size() != 0 && options.reach.size() != dof)
    throw InvalidArgument("reach has " + std::to_string(options.reach.size()) + " entries, but there are " +
                          std::to_string(dof) + " joints");
  if (options.reach.size() != 0 && !(options.reach.minCoeff() >= 0.0 && options.reach.allFinite()))
    throw InvalidArgument("reach must be 0 m or above for every joint");
}

}  // namespace

Trajectory time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                             const MotionLimits& limits, const TimingOptions& options) {
  require_waypoints(waypoints, joint_names);
  require_limits(limits, joint_names);
  require_short_way(waypoints, limits.continuous, joint_names);
  require_options(options, waypoints.cols());

  const RowMatrix path = without_tiny_steps(without_redundant_waypoints(waypoints));
  Knots knots;
  if (path.rows() == 1) {
    for (const Eigen::VectorXd* velocity : {&options.start_velocity, &options.end_velocity})
      if (velocity->size() && !velocity->isZero(0.0))
        throw InvalidArgument("the path is a single point: it cannot start or end with a velocity");
    knots.add(0.0, path.row(0).transpose(), Eigen::VectorXd::Zero(path.cols()));
  } else {
    TimingOptions rounding = options;
    if (options.method == TimingMethod::ruckig) rounding.blend_deviation = 0.0;
    knots = time_all(detail::round_corners(path, limits, rounding), limits, options, joint_names);
    // Rounding of sums must not move the ends.
    knots.positions.front() = waypoints.row(0).transpose();
    knots.positions.back() = waypoints.bottomRows(1).transpose();
  }
  if (!(knots.times.back() / options.sample_period < static_cast<double>(options.max_rows)))
    throw InvalidArgument("a sample period of " + to_text(options.sample_period) + " s would give more than " +
                          std::to_string(options.max_rows) + " rows of this " + to_text(knots.times.back()) +
                          " s motion; use a longer one");
  return to_rows(knots, joint_names, waypoints, options);
}

}  // namespace srmp
