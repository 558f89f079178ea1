#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/limit_check.hpp"
#include "srmp/trajectory/near_row.hpp"
#include "srmp/trajectory/trajectory.hpp"
#include "srmp/trajectory/trajectory_checks.hpp"

// Other rows of a motion, parts of it, and what follows it.

namespace srmp {

using detail::refuse;
using detail::require_motion;
using detail::require_shapes;
using detail::require_time;
using detail::require_times;
using detail::time_of_near_row;

namespace {

constexpr double max_rows = 1e7;
constexpr double same_position = 1e-9;  // [rad or m] where one motion ends and the next begins
constexpr double same_velocity = 1e-6;  // [rad/s or m/s]
constexpr double short_tick = 0.01;     // of dt: a last segment shorter than this does the same

/// Row by row, at the times given. Its waypoints are its rows.
Trajectory rows_at(const Trajectory& trajectory, const std::vector<double>& times) {
  const auto n = static_cast<Eigen::Index>(times.size()), dof = trajectory.positions.cols();
  Trajectory result = {.joint_names = trajectory.joint_names,
                       .positions = RowMatrix(n, dof),
                       .velocities = RowMatrix(n, dof),
                       .accelerations = RowMatrix(n, dof),
                       .times = Eigen::Map<const Eigen::VectorXd>(times.data(), n),
                       .waypoints = {},
                       .robot = trajectory.robot};
  for (Eigen::Index i = 0; i < n; ++i) {
    const MotionState state = trajectory.state(times[static_cast<std::size_t>(i)]);
    result.positions.row(i) = state.position.transpose();
    result.velocities.row(i) = state.velocity.transpose();
    result.accelerations.row(i) = state.acceleration.transpose();
  }
  if (trajectory.velocities.rows() == 0) result.velocities.resize(0, dof);
  if (trajectory.accelerations.rows() == 0) result.accelerations.resize(0, dof);
  result.waypoints = result.positions;
  return result;
}

RowMatrix stacked(const RowMatrix& above, const RowMatrix& below) {
  RowMatrix both(above.rows() + below.rows(), above.cols());
  both.topRows(above.rows()) = above;
  both.bottomRows(below.rows()) = below;
  return both;
}

const RowMatrix& path_of(const Trajectory& t) { return t.waypoints.rows() ? t.waypoints : t.positions; }

/// One path and then the other; a common point in between appears once.
RowMatrix joined(const RowMatrix& first, const RowMatrix& second) {
  const bool common = (first.bottomRows(1) - second.topRows(1)).cwiseAbs().maxCoeff() <= same_position;
  return stacked(first, second.bottomRows(second.rows() - (common ? 1 : 0)));
}

/// Refuses a next motion that does not begin as this one ends.
void require_no_jump(const RowMatrix& end, const RowMatrix& begin, double allowed, const std::string& what,
                     const std::vector<std::string>& names) {
  for (Eigen::Index j = 0; j < begin.cols(); ++j)
    if (const double jump = begin(0, j) - end(end.rows() - 1, j); !(std::abs(jump) <= allowed))
      refuse("the next one starts with another " + what +
             " than this one ends with: " + names[static_cast<std::size_t>(j)] + " jumps by " + to_text(jump));
}

/// The limits that need a robot that is known.
RobotBounds bounds_of(const Trajectory& motion, const MotionLimits& limits) {
  RobotBounds bounds;
  if (!need_robot(limits)) return bounds;
  if (!motion.robot || !motion.robot->model)
    refuse("the limits have " + std::string(limits.link_speeds.empty() ? "torques" : "link speeds") +
           ", but the trajectory does not know its robot (only a plan does, until it is pickled or written)");
  bounds.add(*motion.robot, limits);
  return bounds;
}

/// By how much a motion uses the limits: where this is above 1, it must be slower by this factor to keep them.
double largest_use(const Trajectory& motion, const MotionLimits& limits, RobotBounds& bounds) {
  Certificate use;
  check_limits(motion, limits, {.limits = false}, use);
  return std::max({use.velocity.fraction, std::sqrt(use.acceleration.fraction), bounds.slowdown(motion)});
}

/// The motion at `steps` even parts of its duration, each of which then takes dt.
Trajectory in_even_steps(const Trajectory& motion, Eigen::Index steps, double dt) {
  const double begin = motion.times[0], part = motion.duration() / static_cast<double>(steps), slower = dt / part;
  std::vector<double> ticks;
  for (Eigen::Index k = 0; k < steps; ++k) ticks.push_back(begin + static_cast<double>(k) * part);
  ticks.push_back(motion.times[motion.times.size() - 1]);
  Trajectory even = rows_at(motion, ticks);
  for (Eigen::Index k = 0; k <= steps; ++k) even.times[k] = begin + static_cast<double>(k) * dt;
  even.velocities /= slower;
  even.accelerations /= slower * slower;
  return even;
}

}  // namespace

Trajectory Trajectory::resample(double dt, const MotionLimits& limits) const {
  require_limits(limits, joint_names);
  const Trajectory rough = resample(dt);
  RobotBounds bounds = bounds_of(*this, limits);
  if (duration() == 0.0) return rough;
  constexpr double rounding = 1e-9;
  auto steps = static_cast<Eigen::Index>(std::ceil(duration() / dt * (1.0 - rounding)));
  while (true) {
    Trajectory even = in_even_steps(*this, steps, dt);
    const double use = largest_use(even, limits, bounds);
    if (use <= 1.0 + rounding) {
      even.waypoints = waypoints;
      even.certificate = certificate_of_limits(*this, even);
      return even;
    }
    steps = std::max(steps + 1, static_cast<Eigen::Index>(std::ceil(static_cast<double>(steps) * std::sqrt(use))));
    if (!(static_cast<double>(steps) < max_rows))
      refuse("the limits are so low that it would have more than ten million rows");
  }
}

Trajectory Trajectory::resample(double dt) const {
  require_motion(*this);
  require_positive(dt, "trajectory: dt");
  if (!(duration() / dt < max_rows))
    refuse("a dt of " + to_text(dt) + " s would give more than ten million rows of this " + to_text(duration()) +
           " s motion; use a longer one");
  const double begin = times[0], end = times[times.size() - 1];
  if (begin + 0.25 * dt == begin || end + 0.25 * dt == end)
    refuse("a dt of " + to_text(dt) + " s is lost beside times of " + to_text(end) + " s; use a longer one");
  std::vector<double> ticks;
  for (double k = 0.0; begin + k * dt < end - short_tick * std::min(dt, duration()); k += 1.0)
    ticks.push_back(begin + k * dt);
  ticks.push_back(end);
  Trajectory result = rows_at(*this, ticks);
  result.waypoints = waypoints;
  result.certificate = certificate_of_limits(*this, result);
  return result;
}

Trajectory Trajectory::slice(double from, double to) const {
  require_motion(*this);
  require_time(from, "the begin of the slice");
  require_time(to, "the end of the slice");
  const double first = times[0], last = times[times.size() - 1];
  if (!(from < to) || from > last || to < first)
    refuse("a slice from " + to_text(from) + " s to " + to_text(to) + " s holds nothing of a motion from " +
           to_text(first) + " s to " + to_text(last) + " s");
  const double begin = time_of_near_row(times, std::clamp(from, first, last)),
               end = time_of_near_row(times, std::clamp(to, first, last));
  if (begin == first && end == last) return *this;
  std::vector<double> kept{begin};
  for (const double time : times)
    if (time > begin && time < end) kept.push_back(time);
  if (end > begin) kept.push_back(end);
  Trajectory part = rows_at(*this, kept);
  part.certificate = certificate_of_part(*this, part);
  return part;
}

Trajectory Trajectory::followed_by(const Trajectory& next) const {
  require_motion(*this);
  require_motion(next);
  if (joint_names != next.joint_names)
    refuse("the next one moves " + quoted_list(next.joint_names) + ", this one " + quoted_list(joint_names));
  if ((velocities.rows() == 0) != (next.velocities.rows() == 0))
    refuse("one of the two has velocities, the other has none");
  require_no_jump(positions, next.positions, same_position, "position", joint_names);
  if (velocities.rows()) require_no_jump(velocities, next.velocities, same_velocity, "velocity", joint_names);

  const Eigen::Index last = positions.rows() - 1, more = next.positions.rows() - 1;
  Trajectory result = *this;
  result.certificate = nullptr;
  if (robot && next.robot && !(*robot == *next.robot)) result.robot = nullptr;
  result.positions = stacked(positions, next.positions.bottomRows(more));
  if (velocities.rows()) result.velocities = stacked(velocities, next.velocities.bottomRows(more));
  if (accelerations.rows() && next.accelerations.rows()) {
    result.accelerations = stacked(accelerations, next.accelerations.bottomRows(more));
    if (more > 0) result.accelerations.row(last) = next.accelerations.row(0);
  } else {
    result.accelerations.resize(0, positions.cols());
  }
  result.times.resize(last + 1 + more);
  result.times << times, (next.times.tail(more).array() - next.times[0] + times[last]).matrix();
  require_times(result.times);  // far from 0 a short step may be lost
  result.waypoints = joined(path_of(*this), path_of(next));
  result.certificate = certificate_of_join(*this, next, result);
  return result;
}

Trajectory Trajectory::rows(std::size_t first, std::size_t last) const {
  require_shapes(*this);
  if (first >= last || last > size())
    refuse("rows " + std::to_string(first) + " to " + std::to_string(last) + " hold nothing, or more than its " +
           std::to_string(size()) + " rows");
  if (first == 0 && last == size()) return *this;
  const auto from = static_cast<Eigen::Index>(first), count = static_cast<Eigen::Index>(last - first);
  const auto part = [&](const RowMatrix& all) {
    return all.rows() ? RowMatrix(all.middleRows(from, count)) : RowMatrix(0, positions.cols());
  };
  Trajectory result = {.joint_names = joint_names,
                       .positions = part(positions),
                       .velocities = part(velocities),
                       .accelerations = part(accelerations),
                       .times = {},
                       .waypoints = part(positions),
                       .robot = robot};
  if (timed()) result.times = times.segment(from, count);
  result.certificate = certificate_of_part(*this, result);
  return result;
}

Trajectory Trajectory::of_joints(const std::vector<std::string>& joints, const std::vector<std::string>& names) const {
  require_shapes(*this);
  if (!names.empty() && names.size() != joints.size())
    refuse("of_joints: there are " + std::to_string(names.size()) + " names for " + std::to_string(joints.size()) +
           " joints");
  if (joints.empty()) refuse("of_joints: no joint is named");
  std::vector<Eigen::Index> columns;
  for (const std::string& joint : joints) {
    const auto it = std::find(joint_names.begin(), joint_names.end(), joint);
    if (it == joint_names.end())
      refuse("of_joints: it has no joint '" + joint + "'" + did_you_mean(joint, joint_names));
    columns.push_back(it - joint_names.begin());
    if (std::count(joints.begin(), joints.end(), joint) > 1) refuse("of_joints: joint '" + joint + "' is named twice");
  }
  const auto part = [&](const RowMatrix& all) { return RowMatrix(all(Eigen::all, columns)); };
  return {.joint_names = names.empty() ? joints : names,
          .positions = part(positions),
          .velocities = part(velocities),
          .accelerations = part(accelerations),
          .times = times,
          .waypoints = part(waypoints)};
}

}  // namespace srmp
