#include "srmp/trajectory/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/trajectory_checks.hpp"

namespace srmp {

namespace {

std::string shape_of(const RowMatrix& matrix) {
  std::string text = "(";
  text.append(std::to_string(matrix.rows())).append(", ").append(std::to_string(matrix.cols())).append(")");
  return text;
}

}  // namespace

namespace detail {

void refuse(const std::string& why) { throw InvalidArgument("trajectory: " + why); }

void require_shapes(const Trajectory& t) {
  const Eigen::Index n = t.positions.rows(), dof = static_cast<Eigen::Index>(t.joint_names.size());
  if (n == 0) refuse("it has no rows");
  if (dof == 0) refuse("it has no joints");
  if (t.positions.cols() != dof)
    refuse("positions have the shape " + shape_of(t.positions) + ", but there are " + std::to_string(dof) +
           " joint names");
  const auto require_like_positions = [&](const RowMatrix& matrix, const std::string& what) {
    if (matrix.rows() != 0 && (matrix.rows() != n || matrix.cols() != dof))
      refuse(what + " have the shape " + shape_of(matrix) + ", but positions " + shape_of(t.positions));
  };
  require_like_positions(t.velocities, "velocities");
  require_like_positions(t.accelerations, "accelerations");
  if (t.times.size() != 0 && t.times.size() != n)
    refuse("it has " + std::to_string(n) + " rows, but " + std::to_string(t.times.size()) + " times");
  if (t.waypoints.rows() != 0 && t.waypoints.cols() != dof)
    refuse("waypoints have the shape " + shape_of(t.waypoints) + ", but there are " + std::to_string(dof) +
           " joint names");
}

void require_motion(const Trajectory& t) {
  require_shapes(t);
  if (!t.timed()) refuse("it has no times: a path cannot say where it is when");
}

void require_times(const Eigen::VectorXd& times) {
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]))
      refuse("the time of row " + std::to_string(i) + " is " + to_text(times[i]) + "; only finite numbers are allowed");
    if (i > 0 && !(times[i] > times[i - 1]))
      refuse("times must increase, but row " + std::to_string(i) + " is at " + to_text(times[i]) + " s, after " +
             to_text(times[i - 1]) + " s");
  }
}

double require_time(double t, const char* what) {
  if (std::isnan(t)) refuse(std::string(what) + " is NaN; it must be a number of seconds");
  return t;
}

}  // namespace detail

using detail::refuse;
using detail::require_motion;
using detail::require_shapes;
using detail::require_time;
using detail::require_times;

namespace {

void require_names(const std::vector<std::string>& names) {
  std::set<std::string> known;
  for (const std::string& name : names) {
    if (name.empty()) refuse("a joint name is empty");
    if (!known.insert(name).second) refuse("joint '" + name + "' is named twice");
  }
}

void require_finite_rows(const RowMatrix& rows, const std::string& what, const std::vector<std::string>& names) {
  if (rows.allFinite()) return;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    require_finite({rows.data() + i * rows.cols(), names.size()}, "trajectory: " + what + ", row " + std::to_string(i),
                   names);
}

/// The row whose polynomial holds at time t, which is within the motion: never the last, unless there is only one.
Eigen::Index segment_at(const Trajectory& trajectory, double t) {
  const double* begin = trajectory.times.data();
  const auto after = static_cast<Eigen::Index>(std::upper_bound(begin, begin + trajectory.times.size(), t) - begin);
  return std::clamp<Eigen::Index>(after - 1, 0, std::max<Eigen::Index>(trajectory.times.size() - 2, 0));
}

/// The same where there may be one row only: the motion is then that point.
detail::Cubic segment_or_point(const Trajectory& t, Eigen::Index row, Eigen::Index joint) {
  if (row + 1 < t.positions.rows()) return detail::segment_of(t, row, joint);
  const double q0 = t.positions(row, joint);
  return {{q0, t.velocities.rows() ? t.velocities(row, joint) : 0.0, 0.0, 0.0}, 0.0};
}

void require_finite_segments(const Trajectory& t) {
  for (Eigen::Index i = 0; i + 1 < t.times.size(); ++i)
    for (Eigen::Index j = 0; j < t.positions.cols(); ++j)
      for (const double c : detail::segment_of(t, i, j).c)
        if (!std::isfinite(c))
          refuse("rows " + std::to_string(i) + " and " + std::to_string(i + 1) + " are " +
                 to_text(t.times[i + 1] - t.times[i]) + " s apart, too little for the motion of " +
                 t.joint_names[static_cast<std::size_t>(j)] + " between them");
}

}  // namespace

bool PlacedRobot::operator==(const PlacedRobot& other) const {
  return model == other.model && base.to_list() == other.base.to_list() &&
         other_positions.size() == other.other_positions.size() && other_positions == other.other_positions;
}

void Trajectory::validate() const {
  require_shapes(*this);
  require_names(joint_names);
  if (velocities.rows() && !timed()) refuse("it has velocities, but no times");
  if (accelerations.rows() && !velocities.rows()) refuse("it has accelerations, but no velocities");
  require_finite_rows(positions, "positions", joint_names);
  require_finite_rows(velocities, "velocities", joint_names);
  require_finite_rows(accelerations, "accelerations", joint_names);
  require_finite_rows(waypoints, "waypoints", joint_names);
  require_times(times);
  require_finite_segments(*this);
}

double Trajectory::length() const { return path_length(positions); }

Eigen::VectorXd Trajectory::sample(double t) const { return state(t).position; }

MotionState Trajectory::state(double t) const {
  require_motion(*this);
  t = std::clamp(require_time(t, "the time to sample"), times[0], times[times.size() - 1]);
  const Eigen::Index row = segment_at(*this, t), dof = positions.cols();
  MotionState state{Eigen::VectorXd(dof), Eigen::VectorXd(dof), Eigen::VectorXd(dof), Eigen::VectorXd(dof)};
  for (Eigen::Index j = 0; j < dof; ++j) {
    const detail::Cubic segment = segment_or_point(*this, row, j);
    const double u = t - times[row];
    state.position[j] = segment.position(u);
    state.velocity[j] = segment.velocity(u);
    state.acceleration[j] = segment.acceleration(u);
    state.jerk[j] = segment.jerk();
  }
  // What a row says is meant to the last bit.
  for (const Eigen::Index at : {row, std::min(row + 1, positions.rows() - 1)})
    if (t == times[at]) {
      state.position = positions.row(at).transpose();
      if (velocities.rows()) state.velocity = velocities.row(at).transpose();
      if (accelerations.rows()) state.acceleration = accelerations.row(at).transpose();
    }
  return state;
}

RowMatrix Trajectory::jerks() const {
  require_motion(*this);
  RowMatrix result(positions.rows(), positions.cols());
  for (Eigen::Index i = 0; i < result.rows(); ++i)
    for (Eigen::Index j = 0; j < result.cols(); ++j)
      result(i, j) = segment_or_point(*this, std::min(i, std::max<Eigen::Index>(result.rows() - 2, 0)), j).jerk();
  return result;
}

}  // namespace srmp
