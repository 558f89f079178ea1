#include "srmp/trajectory/limit_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/trajectory/cubic.hpp"

namespace srmp {

namespace {

constexpr double limit_tolerance = 1e-6;   // of a limit
constexpr double min_half_range = 1e-9;    // [rad or m] of a joint whose two limits are the same
constexpr double jump_tolerance = 1e-3;    // of the acceleration limit: smaller jumps of the acceleration are none,
constexpr double jump_time = 4e-4;         // [s] nor are those that the jerk limit allows in this time
constexpr double stated_tolerance = 1e-4;  // of the acceleration limit: what rows say may have been rounded before
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Where a joint uses the largest fraction of a limit, and the value there.
struct Worst {
  double fraction{}, value{}, time{};
  Eigen::Index row{};
  void update(double new_fraction, double new_value, double new_time, Eigen::Index new_row) {
    if (new_fraction > fraction) *this = {new_fraction, new_value, new_time, new_row};
  }
};

class LimitCheck {
 public:
  LimitCheck(const Trajectory& trajectory, const MotionLimits& limits, const LimitCheckOptions& options,
             Certificate& result)
      : t_(trajectory), limits_(limits), options_(options), result_(result) {}

  void run() {
    for (Eigen::Index j = 0; j < t_.positions.cols(); ++j) check_limits_of(j);
  }

 private:
  void fault(FaultKind kind, const std::string& text, double time) { result_.faults.push_back({kind, text, time}); }

  /// Of one joint, over the whole motion.
  struct Use {
    Worst position, velocity, acceleration, jerk;
  };

  void check_limits_of(Eigen::Index j) {
    const std::string& joint = t_.joint_names[static_cast<std::size_t>(j)];
    Use use;
    segments_.clear();
    for (Eigen::Index row = 0; row + 1 < t_.positions.rows(); ++row) {
      interruption_point();
      segments_.push_back(detail::segment_of(t_, row, j));
    }
    if (options_.joints) check_position((*options_.joints)[static_cast<std::size_t>(j)], j, use.position);
    for (Eigen::Index row = 0; row + 1 < t_.positions.rows(); ++row) update_derivatives(j, row, use);
    if (t_.velocities.rows() == 0)
      check_jumps(j, use);
    else
      check_acceleration_jumps(j, use.jerk);
    check_stated_accelerations(j, use.acceleration);
    note(result_.velocity, use.velocity, joint);
    note(result_.acceleration, use.acceleration, joint);
    note(result_.jerk, use.jerk, joint);
    if (!options_.limits) return;
    check_limit(FaultKind::velocity_limit, "velocity", joint, use.velocity, limits_.velocity[j]);
    check_limit(FaultKind::acceleration_limit, "acceleration", joint, use.acceleration, limits_.acceleration[j]);
    if (options_.jerk && std::isinf(use.jerk.fraction))
      fault(FaultKind::jerk_limit,
            joint + ": the " + (t_.velocities.rows() > 0 ? "acceleration" : "velocity") + " jumps at " +
                time_text(use.jerk.time, use.jerk.row) + ", where the jerk is unbounded; its limit is " +
                to_text(limits_.jerk[j]),
            use.jerk.time);
    else if (options_.jerk)
      check_limit(FaultKind::jerk_limit, "jerk", joint, use.jerk, limits_.jerk[j]);
  }

  void check_position(const Joint& joint, Eigen::Index j, Worst& worst) {
    const double middle = (joint.lower + joint.upper) / 2.0;
    const double half = std::max((joint.upper - joint.lower) / 2.0, min_half_range);
    if (!std::isfinite(half)) return;
    const auto may_be_worst = [&](double q) { return std::abs(q - middle) > max_not_worse(worst, half); };
    const auto at = [&](double q, double time, Eigen::Index row) {
      if (may_be_worst(q)) worst.update(std::abs(q - middle) / half, q, time, row);
    };
    for (Eigen::Index row = 0; row < t_.positions.rows(); ++row) at(t_.positions(row, j), t_.times[row], row);
    for (Eigen::Index row = 0; row + 1 < t_.positions.rows() && t_.velocities.rows() > 0; ++row) {
      const detail::Cubic& p = segment(row);
      const double third = p.h / 3.0, end = p.position(p.h);
      // The inner Bernstein coefficients and the rows bound the position.
      if (!may_be_worst(p.c[0] + third * p.c[1]) && !may_be_worst(end - third * p.velocity(p.h))) continue;
      for (const double u : p.position_extrema()) at(p.position(u), t_.times[row] + u, row);
    }
    note(result_.position, worst, joint.name);
    if (worst.fraction > 1.0 + std::max(limit_tolerance, limit_tolerance / half))
      fault(FaultKind::position_limit,
            joint.name + ": the position is " + to_text(worst.value) + " at " + time_text(worst.time, worst.row) +
                "; its limits are [" + to_text(joint.lower) + ", " + to_text(joint.upper) + "]",
            worst.time);
  }

  /// What is no more than this does not use a larger fraction of the limit: divisions are slow.
  static double max_not_worse(const Worst& worst, double limit) { return worst.fraction * limit * (1.0 - 1e-12); }

  /// Positions and times are rounded, so a difference of order k is known to about this over h^k.
  static double rounding_of(const detail::Cubic& p, double end) {
    return std::numeric_limits<double>::epsilon() * (1.0 + std::abs(p.c[0]) + std::abs(p.c[1]) * std::abs(end));
  }
  /// Of the polynomial from the row to the next.
  double acceleration_rounding_after(Eigen::Index row) const {
    const detail::Cubic& p = segment(row);
    return 12 * rounding_of(p, t_.times[row + 1]) / p.h / p.h;
  }

  void update_derivatives(Eigen::Index j, Eigen::Index row, Use& use) const {
    const detail::Cubic& p = segment(row);
    const double begin = t_.times[row], h = p.h, rounding = rounding_of(p, t_.times[row + 1]);
    const auto update = [&](Worst& worst, double value, double u, double limit, const auto& unknown) {
      if (std::abs(value) <= max_not_worse(worst, limit)) return;
      worst.update(std::max(0.0, std::abs(value) - unknown()) / limit, value, begin + u, row);
    };
    const auto velocity_at = [&](double u) {
      update(use.velocity, p.velocity(u), u, limits_.velocity[j], [&] { return 2 * rounding / h; });
    };
    velocity_at(0.0);
    // The Bernstein coefficient between those of the ends bounds the velocity there.
    if (std::abs(p.c[1] + h * p.c[2]) > max_not_worse(use.velocity, limits_.velocity[j]))
      velocity_at(p.velocity_extremum());
    velocity_at(h);
    if (t_.velocities.rows() == 0) return;  // straight segments: jumps of the velocity are no accelerations
    for (const double u : {0.0, h})
      update(use.acceleration, p.acceleration(u), u, limits_.acceleration[j], [&] { return 12 * rounding / h / h; });
    update(use.jerk, p.jerk(), 0.0, limits_.jerk[j], [&] { return 36 * rounding / h / h / h; });
  }

  /// Without velocities the motion is straight between rows: the velocity jumps there, as if within half of the time to
  /// the rows on both sides. The jerk has no bound there.
  void check_jumps(Eigen::Index j, Use& use) const {
    for (Eigen::Index row = 1; row + 1 < t_.positions.rows(); ++row) {
      const detail::Cubic &before = segment(row - 1), &after = segment(row);
      const double jump = (after.c[1] - before.c[1]) / (0.5 * (before.h + after.h));
      use.acceleration.update(std::abs(jump) / limits_.acceleration[j], jump, t_.times[row], row);
      if (std::abs(jump) > allowed_jump(j)) use.jerk.update(infinity, jump, t_.times[row], row);
    }
  }

  /// What rows say need not be what the polynomials beside them do.
  void check_stated_accelerations(Eigen::Index j, Worst& worst) const {
    const Eigen::Index last = t_.accelerations.rows() - 1;
    for (Eigen::Index row = 0; row <= last; ++row) {
      const double value = t_.accelerations(row, j), limit = limits_.acceleration[j];
      if (std::abs(value) <= max_not_worse(worst, limit)) continue;
      const double before = row > 0 ? acceleration_rounding_after(row - 1) : 0.0;
      const double rounding = std::max(before, row < last ? acceleration_rounding_after(row) : 0.0);
      worst.update(std::max(0.0, std::abs(value) - rounding - stated_tolerance * limit) / limit, value, t_.times[row],
                   row);
    }
  }

  double allowed_jump(Eigen::Index j) const {
    return std::max(jump_tolerance * limits_.acceleration[j], jump_time * limits_.jerk[j]);
  }

  /// Where the acceleration jumps, the jerk has no bound. It jumps between rows' polynomials, and at the ends if the
  /// robot is at rest before and after.
  void check_acceleration_jumps(Eigen::Index j, Worst& jerk) const {
    const Eigen::VectorXd* at_start = options_.start_acceleration;
    double before = at_start && at_start->size() ? (*at_start)[j] : 0.0;
    const Eigen::Index last = t_.positions.rows() - 1;
    const double allowed = allowed_jump(j);
    const auto unknown_at = [&](Eigen::Index row) {
      return acceleration_rounding_after(std::min(row, last - 1)) +
             (row > 0 ? acceleration_rounding_after(row - 1) : 0.0);
    };
    for (Eigen::Index row = 0; row <= last && last > 0; ++row) {
      const double after = row < last ? segment(row).acceleration(0.0) : 0.0, jump = std::abs(after - before);
      const bool inside = row > 0 && row < last;
      if ((inside || options_.at_rest) && jump > allowed && jump - unknown_at(row) > allowed)
        jerk.update(infinity, after - before, t_.times[row], row);
      if (row < last) before = segment(row).acceleration(segment(row).h);
    }
  }

  static void note(LimitUse& use, const Worst& worst, const std::string& joint) {
    if (worst.fraction > use.fraction) use = {worst.fraction, joint, worst.time};
  }

  std::string time_text(double time, Eigen::Index row) const {
    const std::string at = to_text(time) + " s (";
    if (row + 1 == t_.positions.rows()) return at + "row " + std::to_string(row) + ", the last)";
    return at + "between rows " + std::to_string(row) + " and " + std::to_string(row + 1) + ")";
  }

  void check_limit(FaultKind kind, const char* what, const std::string& joint, const Worst& worst, double limit) {
    if (worst.fraction <= 1.0 + limit_tolerance) return;
    fault(kind,
          joint + ": the " + what + " reaches " + to_text(worst.value) + " at " + time_text(worst.time, worst.row) +
              "; its limit is " + to_text(limit),
          worst.time);
  }

  const detail::Cubic& segment(Eigen::Index row) const { return segments_[static_cast<std::size_t>(row)]; }

  const Trajectory& t_;
  const MotionLimits& limits_;
  const LimitCheckOptions& options_;
  Certificate& result_;
  std::vector<detail::Cubic> segments_;  // of one joint
};

}  // namespace

void check_limits(const Trajectory& trajectory, const MotionLimits& limits, const LimitCheckOptions& options,
                  Certificate& result) {
  LimitCheck(trajectory, limits, options, result).run();
}

}  // namespace srmp
