#include "srmp/trajectory/knots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/core/interruption.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/trajectory/cubic.hpp"

namespace srmp::detail {

namespace {

constexpr double min_row_spacing = 5e-4;  // [s] between a row of the sample period and a knot
constexpr std::size_t rows_per_deadline_check = 1024;

}  // namespace

void stop_if_late(const TimingOptions& options) {
  rare_interruption_point();
  if (options.deadline)
    stop_if_late(*options.deadline,
                 "the path was timed with a sample period of " + to_text(options.sample_period) + " s");
}

double limit_use(const Knots& knots, const MotionLimits& limits, bool with_jerk) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < knots.times.size(); ++i) {
    interruption_point();
    for (Eigen::Index j = 0; j < limits.velocity.size(); ++j) {
      const double h = knots.times[i + 1] - knots.times[i], q = knots.positions[i][j];
      const double rounding = std::numeric_limits<double>::epsilon() * (1.0 + std::abs(q));
      const Cubic segment =
          hermite(q, knots.velocities[i][j], knots.positions[i + 1][j], knots.velocities[i + 1][j], h);
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
  }
  return largest;
}

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
      const Cubic segment = hermite(knots.positions[a][j], knots.velocities[a][j], knots.positions[b][j],
                                    knots.velocities[b][j], knots.times[b] - knots.times[a]);
      const double u = time - knots.times[a];
      result.positions(row, j) = knot ? knots.positions[i][j] : segment.position(u);
      result.velocities(row, j) = knot ? knots.velocities[i][j] : segment.velocity(u);
      result.accelerations(row, j) = segment.acceleration(u);
    }
  }
  return result;
}

}  // namespace srmp::detail
