#include "srmp/trajectory/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

constexpr double max_rows = 1e7;
constexpr double same_position = 1e-9;  // [rad or m] where one motion ends and the next begins
constexpr double same_velocity = 1e-6;  // [rad/s or m/s]

void require_motion(const Trajectory& t) {
  if (t.positions.rows() == 0) throw InvalidArgument("trajectory: it has no rows");
  if (t.times.size() != t.positions.rows())
    throw InvalidArgument("trajectory: it has " + std::to_string(t.positions.rows()) + " rows, but " +
                          std::to_string(t.times.size()) + " times" +
                          (t.times.size() == 0 ? " (it was planned without timing)" : ""));
}

double require_time(double t, const char* what) {
  if (std::isnan(t))
    throw InvalidArgument(std::string("trajectory: ") + what + " is NaN; it must be a number of seconds");
  return t;
}

/// The row whose polynomial holds at time t, which is within the motion: never the last, unless there is only one.
Eigen::Index piece_at(const Trajectory& trajectory, double t) {
  const double* begin = trajectory.times.data();
  const auto after = static_cast<Eigen::Index>(std::upper_bound(begin, begin + trajectory.times.size(), t) - begin);
  return std::clamp<Eigen::Index>(after - 1, 0, std::max<Eigen::Index>(trajectory.times.size() - 2, 0));
}

detail::Cubic piece_of(const Trajectory& t, Eigen::Index row, Eigen::Index joint) {
  const double q0 = t.positions(row, joint);
  if (row + 1 == t.positions.rows()) return {{q0, t.velocities.rows() ? t.velocities(row, joint) : 0.0, 0.0, 0.0}, 0.0};
  const double q1 = t.positions(row + 1, joint), h = t.times[row + 1] - t.times[row];
  if (t.velocities.rows() == 0) return detail::line(q0, q1, h);
  return detail::hermite(q0, t.velocities(row, joint), q1, t.velocities(row + 1, joint), h);
}

/// Row by row, at the times given.
Trajectory rows_at(const Trajectory& trajectory, const std::vector<double>& times) {
  const auto n = static_cast<Eigen::Index>(times.size()), dof = trajectory.positions.cols();
  Trajectory result{trajectory.joint_names,
                    RowMatrix(n, dof),
                    RowMatrix(n, dof),
                    RowMatrix(n, dof),
                    Eigen::Map<const Eigen::VectorXd>(times.data(), n),
                    trajectory.waypoints};
  for (Eigen::Index i = 0; i < n; ++i) {
    const MotionState state = trajectory.state(times[static_cast<std::size_t>(i)]);
    result.positions.row(i) = state.position.transpose();
    result.velocities.row(i) = state.velocity.transpose();
    result.accelerations.row(i) = state.acceleration.transpose();
  }
  if (trajectory.velocities.rows() == 0) result.velocities.resize(0, dof), result.accelerations.resize(0, dof);
  return result;
}

RowMatrix stacked(const RowMatrix& above, const RowMatrix& below) {
  RowMatrix both(above.rows() + below.rows(), above.cols());
  both << above, below;
  return both;
}

}  // namespace

double Trajectory::length() const { return path_length(positions); }

Eigen::VectorXd Trajectory::sample(double t) const { return state(t).position; }

MotionState Trajectory::state(double t) const {
  require_motion(*this);
  t = std::clamp(require_time(t, "the time to sample"), times[0], times[times.size() - 1]);
  const Eigen::Index row = piece_at(*this, t), dof = positions.cols();
  MotionState state{Eigen::VectorXd(dof), Eigen::VectorXd(dof), Eigen::VectorXd(dof), Eigen::VectorXd(dof)};
  for (Eigen::Index j = 0; j < dof; ++j) {
    const detail::Cubic piece = piece_of(*this, row, j);
    const double u = t - times[row];
    state.position[j] = piece.position(u);
    state.velocity[j] = piece.velocity(u);
    state.acceleration[j] = piece.acceleration(u);
    state.jerk[j] = piece.jerk();
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
      result(i, j) = piece_of(*this, std::min(i, std::max<Eigen::Index>(result.rows() - 2, 0)), j).jerk();
  return result;
}

Trajectory Trajectory::resample(double dt) const {
  require_motion(*this);
  if (!(dt > 0.0)) throw InvalidArgument("trajectory: dt is " + to_text(dt) + "; it must be above 0 s");
  if (!(duration() / dt < max_rows))
    throw InvalidArgument("trajectory: a dt of " + to_text(dt) + " s would give more than ten million rows of this " +
                          to_text(duration()) + " s motion; use a longer one");
  const double begin = times[0], end = times[times.size() - 1];
  std::vector<double> ticks;
  for (double k = 0.0; begin + k * dt < end - 1e-6 * dt; k += 1.0) ticks.push_back(begin + k * dt);
  ticks.push_back(end);
  return rows_at(*this, ticks);
}

Trajectory Trajectory::slice(double from, double to) const {
  require_motion(*this);
  require_time(from, "the begin of the slice");
  require_time(to, "the end of the slice");
  const double begin = std::max(from, times[0]), end = std::min(to, times[times.size() - 1]);
  if (!(from < to) || !(begin <= end))
    throw InvalidArgument("trajectory: a slice from " + to_text(from) + " s to " + to_text(to) +
                          " s holds nothing of a motion from " + to_text(times[0]) + " s to " +
                          to_text(times[times.size() - 1]) + " s");
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
    throw InvalidArgument("trajectory: the next one moves " + quoted_list(next.joint_names) + ", this one " +
                          quoted_list(joint_names));
  if ((velocities.rows() == 0) != (next.velocities.rows() == 0))
    throw InvalidArgument("trajectory: one of the two has velocities, the other has none");
  const Eigen::Index last = positions.rows() - 1;
  const auto gap = [&](const RowMatrix& a, const RowMatrix& b) {
    return a.rows() == 0 ? 0.0 : (a.row(last) - b.row(0)).cwiseAbs().maxCoeff();
  };
  if (const double jump = gap(positions, next.positions); !(jump <= same_position))
    throw InvalidArgument("trajectory: the next one starts " + to_text(jump) + " rad (m) from where this one ends");
  if (const double jump = gap(velocities, next.velocities); !(jump <= same_velocity))
    throw InvalidArgument("trajectory: the next one starts with a velocity " + to_text(jump) +
                          " rad/s (m/s) from that at the end of this one");
  const Eigen::Index more = next.positions.rows() - 1;
  Trajectory result = *this;
  result.certificate = nullptr;
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
  result.waypoints =
      stacked(waypoints,
              next.waypoints.rows() ? RowMatrix(next.waypoints.bottomRows(next.waypoints.rows() - 1)) : next.waypoints);
  return result;
}

}  // namespace srmp
