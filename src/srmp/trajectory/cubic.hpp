#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "srmp/core/matrix.hpp"

// The motion of one joint between two rows of a trajectory.
namespace srmp::detail {

/// q(u) = c[0] + c[1] u + c[2] u^2 + c[3] u^3 for u in [0, h].
struct Cubic {
  std::array<double, 4> c{};
  double h{};

  double position(double u) const { return c[0] + u * (c[1] + u * (c[2] + u * c[3])); }
  double velocity(double u) const { return c[1] + u * (2.0 * c[2] + u * 3.0 * c[3]); }
  double acceleration(double u) const { return 2.0 * c[2] + u * 6.0 * c[3]; }
  double jerk() const { return 6.0 * c[3]; }

  /// Where the velocity is largest or smallest within the segment, besides its ends; h when nowhere.
  double velocity_extremum() const {
    const double u = -c[2] / (3.0 * c[3]);
    return u > 0.0 && u < h ? u : h;  // NaN and infinity, of straight lines and parabolas, too
  }
  /// The same for the position: up to two places.
  std::array<double, 2> position_extrema() const {
    const double root = std::sqrt(std::max(0.0, c[2] * c[2] - 3.0 * c[1] * c[3]));
    const double q = -(c[2] + std::copysign(root, c[2]));
    const auto inside = [this](double u) { return u > 0.0 && u < h ? u : h; };
    return {inside(q / (3.0 * c[3])), inside(c[1] / q)};
  }
};

inline Cubic hermite(double q0, double v0, double q1, double v1, double h) {
  const double mean = (q1 - q0) / h;
  return {{q0, v0, (3.0 * mean - 2.0 * v0 - v1) / h, (v0 + v1 - 2.0 * mean) / (h * h)}, h};
}

inline Cubic line(double q0, double q1, double h) { return {{q0, (q1 - q0) / h, 0.0, 0.0}, h}; }

/// From a row to the next, which there must be.
template <class Motion>
Cubic segment_of(const Motion& t, Eigen::Index row, Eigen::Index joint) {
  const double q0 = t.positions(row, joint), q1 = t.positions(row + 1, joint), h = t.times[row + 1] - t.times[row];
  if (t.velocities.rows() == 0) return line(q0, q1, h);
  return hermite(q0, t.velocities(row, joint), q1, t.velocities(row + 1, joint), h);
}

}  // namespace srmp::detail
