#pragma once

#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/timing_options.hpp"
#include "srmp/trajectory/trajectory.hpp"

// Paths with parabolas for corners, between waypoints and timing.
namespace srmp::detail {

/// q(s) = start + s direction + s^2 curvature / 2, for s in [0, length]: a straight segment or a parabola.
struct PathSegment {
  double length{};
  Eigen::VectorXd start, direction, curvature;  // the curvature of a straight segment is zero
  bool rounded{};

  Eigen::VectorXd position(double s) const { return start + s * (direction + 0.5 * s * curvature); }
  Eigen::VectorXd tangent(double s) const { return direction + s * curvature; }
};

/// Segments with equal tangents where one follows the other, so that the path can be followed without a stop.
using SmoothPath = std::vector<PathSegment>;

/// Divides the path along the waypoints into smooth paths from stop to stop; s is the time [s] that the motion takes at
/// full speed. Corners are rounded as `options` say; one that cannot be rounded is a stop. Consecutive waypoints
/// differ.
std::vector<SmoothPath> round_corners(const RowMatrix& waypoints, const MotionLimits& limits,
                                      const TimingOptions& options);

}  // namespace srmp::detail
