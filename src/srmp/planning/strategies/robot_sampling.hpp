#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/search/rrt_connect.hpp"

namespace srmp {

struct RobotSamplingOptions {
  double max_step{
      0.7};  ///< over all joints [rad, prismatic joints m]: longer steps need fewer checks, and fail more often
  /// Samples are in the box around the straight motions to the goals, made wider on each side by a margin [rad,
  /// prismatic joints m] that grows from `first_margin` to `near_margin` over the first `growing_samples`: with a
  /// smaller margin short paths take fewer samples, and detours more.
  double first_margin{M_PI / 2}, near_margin{M_PI / 2};
  std::size_t growing_samples{512};
  /// This fraction of the samples is in a box made wider by `far_margin`, for large detours.
  double far_fraction{0.2}, far_margin{2 * M_PI};
  /// The first `direct_samples` are moved towards a straight motion to a goal, to `direct_distance` of the distance
  /// from it (a fraction): the path is shorter, and found with fewer samples. More of them delay detours.
  std::size_t direct_samples{0};
  double direct_distance{0.35};
  /// A path through a sample may be no longer than this (Gammell, Srinivasa, Barfoot 2014, "Informed RRT*"); after
  /// `informed_draws` the last one drawn is taken as it is.
  double max_length{std::numeric_limits<double>::infinity()};
  int informed_draws{64};
};

/// A robot's joints, for two trees to grow in from `start` and `goals`. Samples are within the joint limits.
/// is_motion_free is left to the caller. The model outlives this.
search::RrtSpace rrt_space(const RobotModel& robot, const Eigen::VectorXd& start, std::vector<Eigen::VectorXd> goals,
                           const RobotSamplingOptions& options = {});

/// Gives the space of a robot's joints directions, in which a tool leaves a narrow place: each of the robot's end links
/// moves straight, by `step` [m], forwards or backwards along an axis of its frame, and does not turn, as far as the
/// joints can do that. The joints that are not planned are at `other_positions`. The model outlives this.
void add_tool_directions(search::RrtSpace& space, const RobotModel& robot, ConstVector other_positions,
                         double step = 0.05);

}  // namespace srmp
