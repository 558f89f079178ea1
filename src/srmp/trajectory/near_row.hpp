#pragma once

#include <Eigen/Core>

namespace srmp::detail {

/// The time of the row that is within 1 µs of t [s], else t. Parts of motions, stops and new motions begin and end
/// there: in a segment that is shorter, rounding of positions becomes a large acceleration.
inline double time_of_near_row(const Eigen::VectorXd& times, double t) {
  constexpr double same_time = 1e-6;
  Eigen::Index nearest{};
  const double off = (times.array() - t).abs().minCoeff(&nearest);
  return off <= same_time ? times[nearest] : t;
}

}  // namespace srmp::detail
