#include "srmp/trajectory/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

constexpr double max_rows = 1e7;
constexpr double same_position = 1e-9;  // [rad or m] where one motion ends and the next begins
constexpr double same_velocity = 1e-6;  // [rad/s or m/s]
constexpr double same_time =
    1e-6;  // [s] a cut as near as this to a row is made there: shorter segments magnify rounding
constexpr double short_tick = 0.01;  // of dt: a last segment shorter than this does the same

[[noreturn]] void refuse(const std::string& why) { throw InvalidArgument("trajectory: " + why); }

std::string shape_of(const RowMatrix& matrix) {
  std::string text = "(";
  text.append(std::to_string(matrix.rows())).append(", ").append(std::to_string(matrix.cols())).append(")");
  return text;
}

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

/// The time of a row that is near enough, else t.
double time_of_near_row(const Eigen::VectorXd& times, double t) {
  Eigen::Index nearest{};
  const double off = (times.array() - t).abs().minCoeff(&nearest);
  return off <= same_time ? times[nearest] : t;
}

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
  for (double k = 0.0; begin + k * dt < end - short_tick * dt; k += 1.0) ticks.push_back(begin + k * dt);
  ticks.push_back(end);
  Trajectory result = rows_at(*this, ticks);
  result.waypoints = waypoints;
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
  return rows_at(*this, kept);
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
  return result;
}

}  // namespace srmp
