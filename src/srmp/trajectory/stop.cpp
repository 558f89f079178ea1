#include "srmp/trajectory/stop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/near_row.hpp"
#include "srmp/trajectory/timing.hpp"

namespace srmp {

namespace {

using detail::Cubic;
using detail::Knots;

constexpr double rest_rate = 1e-9;                           // [rad/s or m/s, and their derivatives]
constexpr double longest_step = 2e-3, shortest_step = 1e-4;  // [s] between knots
constexpr int steps_of_stop = 50;                            // of a short stop, about
constexpr double stop_tolerance = 5e-7;  // relative: what certificates allow, and half of it for rounding
constexpr double end_rate = 1e-6;        // [rad/s or m/s] of a motion that ends at rest
constexpr double off_line = 1e-9;        // [rad or m]
constexpr int stop_attempts = 12;        // to bring the cubics within the limits

double smallest_rate(const Eigen::VectorXd& limit, const Eigen::VectorXd& direction) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < direction.size(); ++j)
    if (direction[j] != 0.0) smallest = std::min(smallest, limit[j] / std::abs(direction[j]));
  return smallest;
}

/// Velocity and acceleration along the line of the velocity, or of the acceleration where the motion begins.
struct Line {
  Eigen::VectorXd direction;  // length 1; zero: at rest
  double speed{}, acceleration{};

  Line(const Eigen::VectorXd& velocity, const Eigen::VectorXd& a) : direction(Eigen::VectorXd::Zero(velocity.size())) {
    if (velocity.norm() > rest_rate)
      direction = velocity.normalized();
    else if (a.size() && a.norm() > rest_rate)
      direction = a.normalized();
    speed = velocity.dot(direction);
    acceleration = a.size() ? a.dot(direction) : 0.0;
  }
};

/// Brakes along the motion's own cubics. Its time s becomes a function of the new time: the squared rate x = (ds/dt)^2
/// falls linearly in s within each step, as fast as the limits allow at both of its ends. A rate of 1 or less keeps all
/// limits without braking, because the motion keeps them: so there is no state from which no step is allowed.
class BrakingOnPath {
 public:
  BrakingOnPath(const Trajectory& motion, double t, const Eigen::VectorXd& max_acceleration)
      : motion_(motion), start_(t), limit_(max_acceleration) {}

  Knots run() {
    double time = 0.0, s = start_, x = 1.0;
    const double step_time =
        std::clamp(1.0 / smallest_rate(limit_, motion_.state(s).velocity) / steps_of_stop, shortest_step, longest_step);
    const Eigen::Index last = motion_.times.size() - 1;
    Eigen::Index row = std::upper_bound(motion_.times.begin(), motion_.times.end(), s) - motion_.times.begin() - 1;
    place(std::clamp(row, Eigen::Index{0}, last - 1));
    add(time, s, x);
    while (true) {
      if (s >= motion_.times[row_ + 1]) {
        if (row_ + 1 == last) return std::move(knots_);
        place(row_ + 1);
      }
      if (velocity(s).cwiseAbs().maxCoeff() * std::sqrt(x) <= rest_rate) return at_rest_now();
      double end = s + step_time * std::sqrt(x);
      if (end > motion_.times[row_ + 1] - 0.1 * (end - s)) end = motion_.times[row_ + 1];
      const double step = end - s, braking = strongest(s, end, x), left = x + 2.0 * braking * step;
      const bool stops = !(left > 0.0);
      const double to = stops ? s + x / (-2.0 * braking) : end, x_to = stops ? 0.0 : left;
      if (!(to > s)) return at_rest_now();
      time += 2.0 * (to - s) / (std::sqrt(x) + std::sqrt(x_to));
      add(time, to, x_to);
      if (stops) return std::move(knots_);
      s = to, x = x_to;
    }
  }

 private:
  void place(Eigen::Index row) {
    row_ = row;
    cubics_.clear();
    for (Eigen::Index j = 0; j < motion_.positions.cols(); ++j) cubics_.push_back(detail::segment_of(motion_, row, j));
  }
  template <class Value>
  Eigen::VectorXd of_joints(double s, Value&& value) const {
    const double u = s - motion_.times[row_];
    return Eigen::VectorXd::NullaryExpr(static_cast<Eigen::Index>(cubics_.size()),
                                        [&](Eigen::Index j) { return value(cubics_[static_cast<std::size_t>(j)], u); });
  }
  Eigen::VectorXd velocity(double s) const {
    return of_joints(s, [](const Cubic& c, double u) { return c.velocity(u); });
  }
  Eigen::VectorXd acceleration(double s) const {
    return of_joints(s, [](const Cubic& c, double u) { return c.acceleration(u); });
  }
  void add(double time, double s, double x) {
    knots_.add(time, of_joints(s, [](const Cubic& c, double u) { return c.position(u); }), velocity(s) * std::sqrt(x));
  }
  Knots at_rest_now() {
    knots_.velocities.back().setZero();
    return std::move(knots_);
  }

  /// The smallest d^2s/dt^2 <= 0 that keeps the limits at both ends of the step, if it is constant there.
  double strongest(double from, double to, double x) const {
    const Eigen::VectorXd v0 = velocity(from), a0 = acceleration(from), v1 = velocity(to), a1 = acceleration(to);
    double lowest = -std::numeric_limits<double>::infinity();
    const auto keep = [&](double curved, double factor, double limit) {  // |curved + factor * braking| <= limit
      if (factor > 0.0) lowest = std::max(lowest, (-limit - curved) / factor);
      if (factor < 0.0) lowest = std::max(lowest, (limit - curved) / factor);
    };
    for (Eigen::Index j = 0; j < limit_.size(); ++j) {
      keep(a0[j] * x, v0[j], limit_[j]);
      keep(a1[j] * x, v1[j] + 2.0 * (to - from) * a1[j], limit_[j]);
    }
    return std::min(0.0, lowest);
  }

  const Trajectory& motion_;
  const double start_;
  const Eigen::VectorXd limit_;
  Eigen::Index row_{};
  std::vector<Cubic> cubics_;  // of the joints, from this row to the next
  Knots knots_;
};

Knots brake(const Trajectory& motion, double t, const MotionLimits& limits) {
  Eigen::VectorXd acceleration = limits.acceleration;
  for (int i = 0; i < stop_attempts; ++i) {
    Knots knots = BrakingOnPath(motion, t, acceleration).run();
    const double use = detail::limit_use(knots, limits, false);
    if (use <= 1.0 + stop_tolerance) return knots;
    acceleration /= 1.0 + 2.0 * (use * use - 1.0);  // how much of the limits is used changes with it gradually
  }
  throw Error("no stop was found that keeps the limits");
}

/// Is the motion on the line until it has gone this far along it?
void require_straight(const Trajectory& motion, double t, const MotionState& at, const Line& line, double distance) {
  const auto check = [&](const Eigen::VectorXd& q) {
    const Eigen::VectorXd moved = q - at.position;
    const double along = moved.dot(line.direction);
    if ((moved - along * line.direction).norm() > off_line * (1.0 + moved.norm()))
      throw NotSupported("the path is not straight where the robot stops, " + to_text(along) + " rad (m) after " +
                         to_text(t) + " s: stops with jerk limits are planned on straight segments");
    return along >= distance - off_line;
  };
  for (Eigen::Index row = 0; row < motion.times.size(); ++row) {
    if (motion.times[row] <= t) continue;
    const double before = std::max(t, row > 0 ? motion.times[row - 1] : t), span = motion.times[row] - before;
    for (const double part : {1.0 / 3.0, 2.0 / 3.0, 1.0})
      if (check(motion.sample(before + part * span))) return;
  }
  throw InvalidArgument("the motion ends before the robot can stop: it has a velocity at its end");
}

void require_motion(const Trajectory& motion, double t, const MotionLimits& limits) {
  motion.validate();
  if (!motion.timed()) throw InvalidArgument("the trajectory has no times: a path without time has no instants");
  if (motion.velocities.rows() == 0 && motion.size() > 1)
    throw InvalidArgument("the trajectory has no velocities; a stop needs them");
  const double first = motion.times[0], last = motion.times[motion.times.size() - 1];
  if (!(t >= first && t <= last))
    throw InvalidArgument("t is " + to_text(t) + " s; the motion lasts from " + to_text(first) + " to " +
                          to_text(last) + " s");
  require_limits(limits, motion.joint_names);
}

}  // namespace

Eigen::VectorXd straight_stop(const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration,
                              const MotionLimits& limits, TimingMethod method) {
  const Line line(velocity, acceleration);
  if (line.direction.isZero(0.0)) return line.direction;
  if (method == TimingMethod::ruckig)
    return detail::stop_with_ruckig(Eigen::VectorXd::Zero(velocity.size()), line.direction, line.speed,
                                    line.acceleration, limits)
        .positions.back();
  return line.direction * (line.speed * line.speed / (2.0 * smallest_rate(limits.acceleration, line.direction)));
}

Trajectory stop_on_path(const Trajectory& motion, double t, const MotionLimits& limits, const TimingOptions& options) {
  require_motion(motion, t, limits);
  t = detail::time_of_near_row(motion.times, t);
  const MotionState at = motion.state(t);
  for (Eigen::Index j = 0; j < at.velocity.size(); ++j)
    if (std::abs(at.velocity[j]) > limits.velocity[j] * (1.0 + 1e-6))
      throw InvalidArgument(motion.joint_names[static_cast<std::size_t>(j)] + ": the velocity at " + to_text(t) +
                            " s is " + to_text(at.velocity[j]) + "; its limit is " + to_text(limits.velocity[j]));
  const bool has_ended = t == motion.times.tail<1>()[0] && at.velocity.cwiseAbs().maxCoeff() <= end_rate;
  const Line line(at.velocity, options.method == TimingMethod::ruckig ? at.acceleration : Eigen::VectorXd());
  Knots knots;
  if (has_ended || line.direction.isZero(0.0)) {
    knots.add(0.0, at.position, Eigen::VectorXd::Zero(at.position.size()));
  } else if (options.method == TimingMethod::ruckig) {
    knots = detail::stop_with_ruckig(at.position, line.direction, line.speed, line.acceleration, limits);
    require_straight(motion, t, at, line, (knots.positions.back() - at.position).norm());
  } else {
    knots = brake(motion, t, limits);
    const Eigen::Index last = motion.times.size() - 1;
    if (knots.velocities.back().cwiseAbs().maxCoeff() > end_rate &&
        knots.positions.back() == motion.positions.row(last).transpose())
      throw InvalidArgument("the motion ends before the robot can stop: it has a velocity at its end");
  }
  knots.positions.front() = at.position;  // rounding of sums must not move them
  if (knots.times.size() > 1) knots.velocities.front() = at.velocity;
  knots.velocities.back().setZero();
  RowMatrix waypoints(static_cast<Eigen::Index>(knots.positions.size()), at.position.size());
  for (std::size_t i = 0; i < knots.positions.size(); ++i)
    waypoints.row(static_cast<Eigen::Index>(i)) = knots.positions[i].transpose();
  Trajectory result = detail::to_rows(knots, motion.joint_names, waypoints, options);
  result.robot = motion.robot;
  return result;
}

}  // namespace srmp
