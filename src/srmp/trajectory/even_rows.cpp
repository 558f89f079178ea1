#include "srmp/trajectory/even_rows.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/knots.hpp"
#include "srmp/trajectory/limit_check.hpp"

namespace srmp {

namespace {

constexpr int slowdowns = 20;  // before limits are found to be out of reach
constexpr double relative_rounding = 1e-9;
constexpr Eigen::Index rows_per_interruption = 1024;

/// The rows of the spline; the motion is slower by the factor.
Trajectory spline(const Trajectory& motion, double rate, double slower, const TimingOptions& options) {
  const double step = 1.0 / (rate * slower);  // of the motion's time between rows
  const double steps = motion.duration() / step;
  if (!(steps + 3.0 < static_cast<double>(options.max_rows)))
    throw InvalidArgument("a sample rate of " + to_text(rate) + " Hz would give more than " +
                          std::to_string(options.max_rows) + " rows of this " + to_text(motion.duration()) +
                          " s motion; use a lower one");
  const Eigen::Index last = static_cast<Eigen::Index>(std::ceil(steps * (1.0 - relative_rounding))) + 2;
  const Eigen::Index dof = motion.positions.cols();
  RowMatrix points(last + 3, dof);  // control point i counts at rows i - 2, i - 1 and i
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if ((i + 1) % rows_per_interruption == 0) detail::stop_if_late(options);
    const double time = static_cast<double>(i - 2) * step;
    if (time <= 0.0)
      points.row(i) = motion.positions.row(0);
    else if (time >= motion.duration())
      points.row(i) = motion.positions.bottomRows(1);
    else
      points.row(i) = motion.sample(motion.times[0] + time).transpose();
  }
  const auto before = points.topRows(last + 1), at = points.middleRows(1, last + 1),
             after = points.bottomRows(last + 1);
  Trajectory even = motion;
  even.certificate = nullptr;
  even.times = Eigen::VectorXd::NullaryExpr(last + 1, [&](Eigen::Index k) { return static_cast<double>(k) / rate; });
  even.positions = (before + 4.0 * at + after) / 6.0;
  even.velocities = (after - before) * (0.5 * rate);
  even.accelerations = (before - 2.0 * at + after) * (rate * rate);
  even.positions.row(0) = motion.positions.row(0);
  even.positions.row(last) = motion.positions.bottomRows(1);
  return even;
}

}  // namespace

Trajectory with_even_rows(const Trajectory& motion, double rate, const MotionLimits& limits, RobotBounds& bounds,
                          const TimingOptions& options) {
  if (motion.size() < 2) return motion;
  const bool jerk = options.method == TimingMethod::ruckig;
  double slower = 1.0;
  for (int i = 0; i < slowdowns; ++i) {
    Trajectory even = spline(motion, rate, slower, options);
    Certificate use;
    check_limits(even, limits, {.limits = false}, use);
    const double excess = std::max({use.velocity.fraction, std::sqrt(use.acceleration.fraction),
                                    jerk ? std::cbrt(use.jerk.fraction) : 0.0, bounds.slowdown(even)});
    if (excess <= 1.0 + relative_rounding) return even;
    slower *= excess * (1.0 + 1e-6);
  }
  throw InvalidArgument("no motion with a sample rate of " + to_text(rate) +
                        " Hz was found that keeps the limits; use another rate");
}

}  // namespace srmp
