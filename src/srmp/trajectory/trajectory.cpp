#include "srmp/trajectory/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

double Trajectory::length() const { return path_length(positions); }

Eigen::VectorXd Trajectory::sample(double t) const {
  if (std::isnan(t)) throw InvalidArgument("trajectory: the time to sample is NaN; it must be a number of seconds");
  if (positions.rows() == 0) throw InvalidArgument("trajectory: it has no samples");
  const double* begin = times.data();
  const double* end = begin + times.size();
  const auto after = static_cast<Eigen::Index>(std::upper_bound(begin, end, t) - begin);
  if (after == 0) return positions.row(0).transpose();
  if (after == times.size()) return positions.row(after - 1).transpose();
  const double fraction = (t - times[after - 1]) / (times[after] - times[after - 1]);
  return ((1.0 - fraction) * positions.row(after - 1) + fraction * positions.row(after)).transpose();
}

}  // namespace srmp
