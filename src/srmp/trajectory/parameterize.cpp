#include "srmp/trajectory/parameterize.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/timing.hpp"

namespace srmp {

namespace {

using detail::EndSpeeds;
using detail::Knots;
using detail::limit_use;
using detail::PathSegment;
using detail::SmoothPath;
using detail::stop_if_late;
using detail::to_rows;

constexpr double same_waypoint = 1e-7;    // [rad or m]
constexpr double min_duration = 1e-3;     // [s] of a motion between stops: keeps second differences above rounding
constexpr double rounding_margin = 1e-9;  // relative: the numbers reported must not exceed a limit by their last bit
constexpr int attempts = 6;               // to bring cubics with given end speeds within the limits
constexpr int torque_attempts = 40;       // to slow a motion down until it keeps the torque limits
constexpr std::size_t parts_per_deadline_check = 16;
constexpr double far_beyond_reach = 10.0;  // times what a joint can reach: velocity limits above it are lowered to it

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

void stretch_time(Knots& knots, double factor) {
  for (double& time : knots.times) time *= factor;
  for (Eigen::VectorXd& velocity : knots.velocities) velocity /= factor;
}

LinkSpeeds::Motion motion_of(const Knots& knots) {
  const auto cubics = [&knots](std::size_t i, std::vector<detail::Cubic>& joints) {
    joints.resize(static_cast<std::size_t>(knots.positions[i].size()));
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto joint = static_cast<Eigen::Index>(j);
      joints[j] = detail::hermite(knots.positions[i][joint], knots.velocities[i][joint], knots.positions[i + 1][joint],
                                  knots.velocities[i + 1][joint], knots.times[i + 1] - knots.times[i]);
    }
    return knots.times[i];
  };
  return {.segments = knots.times.size() - 1, .cubics = cubics};
}

/// The timing of a path between two stops, or from or to a given speed at an end of the whole motion.
class SmoothPathTiming {
 public:
  SmoothPathTiming(const SmoothPath& path, const MotionLimits& limits, TimingMethod method, const EndSpeeds& ends,
                   RobotBounds& bounds)
      : path_(path),
        limits_(limits),
        method_(method),
        ends_(ends),
        speeds_(bounds.links.empty() ? nullptr : &bounds.links),
        torques_(bounds.torques) {}

  Knots time() const {
    if (!ends_.at_rest()) return time_between_speeds();
    Knots knots = solve(limits_, 1.0);
    for (Eigen::VectorXd* at_rest : {&knots.velocities.front(), &knots.velocities.back()}) at_rest->setZero();
    if (const double use = limit_use(knots, limits_, jerk_limited()) * (1.0 + rounding_margin); use > 1.0)
      stretch_time(knots, use);
    if (const double use = use_of_links(knots); use > 1.0) stretch_time(knots, use);
    keep_torques(knots);
    if (knots.times.back() < min_duration) stretch_time(knots, min_duration / knots.times.back());
    return knots;
  }

 private:
  bool jerk_limited() const { return method_ == TimingMethod::ruckig; }

  /// With a margin: rows between the knots divide the proof otherwise.
  double use_of_links(const Knots& knots) const {
    if (!speeds_) return 0.0;
    const double use = speeds_->use(motion_of(knots)) * (1.0 + LinkSpeeds::fineness);
    if (!std::isfinite(use)) throw Error("the speed of a link has no bound");
    return use;
  }

  void keep_torques(Knots& knots) const {
    for (int i = 0; i < torque_attempts; ++i) {
      const double factor = torques_.slowdown(motion_of(knots));
      if (factor == 1.0) return;
      stretch_time(knots, factor);
    }
    throw Overload("the motion needs too much torque at every speed that was tried");
  }

  Knots solve(const MotionLimits& limits, double link_fraction) const {
    return jerk_limited() ? time_with_ruckig(path_.front(), slower_for_links(limits, link_fraction), ends_)
                          : time_with_toppra(path_, limits, ends_.start, ends_.end, {speeds_, link_fraction});
  }

  /// With which no link is too fast anywhere on the straight segment.
  MotionLimits slower_for_links(MotionLimits limits, double fraction) const {
    if (!speeds_) return limits;
    const PathSegment& segment = path_.front();
    const Eigen::VectorXd displacement = segment.direction * segment.length;
    const double use = speeds_->straight_use(segment.start, segment.start + displacement) / fraction;
    double rate = std::numeric_limits<double>::infinity();
    for (Eigen::Index j = 0; j < displacement.size(); ++j)
      if (displacement[j] != 0.0) rate = std::min(rate, limits.velocity[j] / std::abs(displacement[j]));
    if (use * (1.0 + LinkSpeeds::fineness) * rate > 1.0) limits.velocity /= use * (1.0 + LinkSpeeds::fineness) * rate;
    return limits;
  }

  /// Time cannot be stretched without changing the speeds at the ends, so the limits are tightened.
  Knots time_between_speeds() const {
    MotionLimits limits = limits_;
    double link_fraction = 1.0;
    for (int i = 0; i < attempts; ++i) {
      Knots knots = solve(limits, link_fraction);
      const double use = limit_use(knots, limits_, jerk_limited()),
                   of_links = speeds_ ? speeds_->use(motion_of(knots)) : 0.0;
      const double of_torques = torques_.slowdown(motion_of(knots));
      if (std::max(use, of_links) <= 1.0 + rounding_margin && of_torques == 1.0) return knots;
      if (of_torques > 1.0) limits.acceleration /= of_torques * of_torques;
      if (of_links > 1.0) link_fraction /= of_links * (1.0 + LinkSpeeds::fineness);
      if (use <= 1.0 + rounding_margin) continue;
      limits.acceleration /= use * use * (1.0 + 1e-6);
      limits.jerk /= use * use * use * (1.0 + 1e-6);
    }
    throw Error("no timing keeps the limits");
  }

  const SmoothPath& path_;
  const MotionLimits& limits_;
  TimingMethod method_;
  const EndSpeeds ends_;
  LinkSpeeds* const speeds_;  // null, or with limits
  JointTorques& torques_;
};

/// Throws InvalidArgument unless there are none, or as many as joints, all finite.
void require_entries(const Eigen::VectorXd& values, Eigen::Index dof, const std::vector<std::string>& joint_names,
                     const std::string& what) {
  if (values.size() == 0) return;
  if (values.size() != dof)
    throw InvalidArgument(what + " has " + std::to_string(values.size()) + " entries, but there are " +
                          std::to_string(dof) + " joints");
  require_finite({values.data(), static_cast<std::size_t>(values.size())}, what, joint_names);
}

/// The derivative of s for this one of the configuration, which has the path's direction.
double rate_along(const Eigen::VectorXd& derivative, const Eigen::VectorXd& direction, const std::string& what,
                  bool may_point_back) {
  if (derivative.size() == 0) return 0.0;
  const double rate = derivative.dot(direction) / direction.squaredNorm();
  if ((rate < 0.0 && !may_point_back) || (derivative - rate * direction).norm() > 1e-6 * (1e-3 + derivative.norm()))
    throw InvalidArgument(what + " does not point along the path's " + (what.starts_with("start") ? "first" : "last") +
                          " segment");
  return rate;
}

/// ds/dt at an end of the path for this velocity.
double speed_along(const Eigen::VectorXd& velocity, const Eigen::VectorXd& direction, const MotionLimits& limits,
                   const std::vector<std::string>& joint_names, const std::string& what) {
  require_entries(velocity, direction.size(), joint_names, what);
  for (Eigen::Index j = 0; j < velocity.size(); ++j)
    if (std::abs(velocity[j]) > limits.velocity[j] * (1.0 + 1e-9))
      throw InvalidArgument(joint_names[static_cast<std::size_t>(j)] + ": the " + what + " " + to_text(velocity[j]) +
                            " is above the limit " + to_text(limits.velocity[j]));
  return rate_along(velocity, direction, what, false);
}

Knots time_all(const std::vector<SmoothPath>& paths, const MotionLimits& limits, const TimingOptions& options,
               const std::vector<std::string>& names, RobotBounds& bounds) {
  const PathSegment &first = paths.front().front(), &last = paths.back().back();
  require_entries(options.start_acceleration, first.direction.size(), names, "start acceleration");
  const EndSpeeds ends{speed_along(options.start_velocity, first.direction, limits, names, "start velocity"),
                       speed_along(options.end_velocity, last.direction, limits, names, "end velocity"),
                       options.method == TimingMethod::ruckig
                           ? rate_along(options.start_acceleration, first.direction, "start acceleration", true)
                           : 0.0};
  Knots all;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if ((i + 1) % parts_per_deadline_check == 0) stop_if_late(options);
    const EndSpeeds own{i == 0 ? ends.start : 0.0, i + 1 == paths.size() ? ends.end : 0.0,
                        i == 0 ? ends.start_acceleration : 0.0};
    Knots part;
    try {
      part = SmoothPathTiming(paths[i], limits, options.method, own, bounds).time();
    } catch (const Overload&) {
      throw;
    } catch (const PlanningError&) {  // it is time to stop
      throw;
    } catch (const Error& error) {
      const std::string where = "part " + std::to_string(i + 1) + " of " + std::to_string(paths.size());
      if (own.at_rest()) throw Error("time parameterisation failed on " + where + ": " + error.what());
      throw InvalidArgument("the limits do not allow to " + std::string(own.end == 0.0 ? "start" : "end") +
                            " at the given velocity on this path (" + where + ": " + error.what() + ")");
    }
    const double begin = all.times.empty() ? 0.0 : all.times.back();
    for (std::size_t k = all.times.empty() ? 0 : 1; k < part.times.size(); ++k)
      all.add(begin + part.times[k], std::move(part.positions[k]), std::move(part.velocities[k]));
  }
  return all;
}

/// The same limits for a motion along the path. A velocity limit that is far above what the joint's acceleration limit
/// allows it to reach there is lowered: nothing is lost, and the solver need not compare numbers of all sizes.
MotionLimits within_reach(MotionLimits limits, const RowMatrix& path, const TimingOptions& options) {
  for (Eigen::Index j = 0; j < path.cols(); ++j) {
    double squared = 0.0;
    for (Eigen::Index i = 1; i < path.rows(); ++i)
      squared += 2.0 * limits.acceleration[j] * std::abs(path(i, j) - path(i - 1, j));
    for (const Eigen::VectorXd* given : {&options.start_velocity, &options.end_velocity})
      if (given->size() == path.cols()) squared += (*given)[j] * (*given)[j];  // others are refused later
    if (squared > 0.0) limits.velocity[j] = std::min(limits.velocity[j], far_beyond_reach * std::sqrt(squared));
  }
  return limits;
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
  RobotBounds bounds;
  if (need_robot(limits)) {
    const std::string what = limits.link_speeds.empty() ? "torques" : "link speeds";
    if (!options.robot || !options.robot->model)
      throw InvalidArgument("the limits have " + what + ", which need the robot whose joints these are; give it too");
    if (options.robot->model->joint_names() != joint_names)
      throw InvalidArgument("the joints are " + quoted_list(joint_names) + ", but those of robot '" +
                            options.robot->model->name() + "', whose " + what + " are limited, are " +
                            quoted_list(options.robot->model->joint_names()));
    require_limits(limits, joint_names);
    bounds.add(*options.robot, limits);
  }
  return detail::time_parameterize(waypoints, joint_names, limits, options, bounds);
}

Trajectory detail::time_parameterize(ConstRows waypoints, const std::vector<std::string>& joint_names,
                                     const MotionLimits& limits, const TimingOptions& options, RobotBounds& bounds) {
  require_waypoints(waypoints, joint_names);
  require_limits(limits, joint_names);
  require_short_way(waypoints, limits.continuous, joint_names);
  require_options(options, waypoints.cols());

  const RowMatrix path = without_tiny_steps(without_redundant_waypoints(waypoints));
  Knots knots;
  if (path.rows() == 1) {
    for (const Eigen::VectorXd* velocity :
         {&options.start_velocity, &options.end_velocity, &options.start_acceleration})
      if (velocity->size() && !velocity->isZero(0.0))
        throw InvalidArgument("the path is a single point: it cannot start or end with a velocity");
    knots.add(0.0, path.row(0).transpose(), Eigen::VectorXd::Zero(path.cols()));
  } else {
    TimingOptions rounding = options;
    if (options.method == TimingMethod::ruckig) rounding.blend_deviation = 0.0;
    const MotionLimits reached = within_reach(limits, path, options);
    knots = time_all(detail::round_corners(path, reached, rounding), reached, options, joint_names, bounds);
    // Rounding of sums must not move the ends.
    knots.positions.front() = waypoints.row(0).transpose();
    knots.positions.back() = waypoints.bottomRows(1).transpose();
    if (options.start_velocity.size()) knots.velocities.front() = options.start_velocity;
    if (options.end_velocity.size())
      knots.velocities.back() = options.end_velocity;
    else if (options.start_velocity.size())
      knots.velocities.back().setZero();
  }
  if (!(knots.times.back() / options.sample_period < static_cast<double>(options.max_rows)))
    throw InvalidArgument("a sample period of " + to_text(options.sample_period) + " s would give more than " +
                          std::to_string(options.max_rows) + " rows of this " + to_text(knots.times.back()) +
                          " s motion; use a longer one");
  return to_rows(knots, joint_names, waypoints, options);
}

}  // namespace srmp
