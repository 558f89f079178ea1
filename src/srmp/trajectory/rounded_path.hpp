#pragma once

#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/trajectory/parameterize.hpp"

// Paths with parabolas for corners, between waypoints and timing.
namespace srmp::detail {

/// q(s) = start + s way + s^2 bend / 2, for s in [0, length].
struct PathPiece {
  double length{};
  Eigen::VectorXd start, way, bend;  // bend is zero on straight pieces
  bool rounded{};

  Eigen::VectorXd position(double s) const { return start + s * (way + 0.5 * s * bend); }
  Eigen::VectorXd tangent(double s) const { return way + s * bend; }
};

/// Pieces whose tangents agree where they meet, so that the path may be run through without a stop.
using SmoothPath = std::vector<PathPiece>;

/// The waypoints as smooth paths from stop to stop; s is the time [s] that it takes at full speed. Corners are rounded
/// as `options` say; a corner that cannot be is a stop. Waypoints that follow each other are not equal.
std::vector<SmoothPath> round_corners(const RowMatrix& waypoints, const MotionLimits& limits,
                                      const TimingOptions& options);

}  // namespace srmp::detail
