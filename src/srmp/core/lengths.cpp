#include "srmp/core/lengths.hpp"

#include <cmath>

#include "srmp/core/error.hpp"

namespace srmp {

std::string length_rule() { return "; at most " + to_text(max_length) + " m are allowed (lengths are in metres)"; }

void require_length(double value, const std::string& what) {
  require_positive(value, what);
  if (value > max_length) throw InvalidArgument(what + " is " + to_text(value) + " m" + length_rule());
}

void require_position(const Eigen::Vector3d& point, const std::string& what) {
  require_finite({point.data(), 3}, what);
  for (const double x : point)
    if (!(std::abs(x) <= max_length))
      throw InvalidArgument(what + " is " + to_text(x) + " m from the origin" + length_rule());
}

Pose checked_pose(const Pose& pose, const std::string& owner) {
  constexpr double rounding = 1e-12;
  try {
    const Pose normalized = Pose::from_list(pose.to_list());
    require_position(pose.p, "pose position");
    return std::abs(pose.q.squaredNorm() - 1.0) <= rounding ? pose : normalized;
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(owner + ": " + error.what());
  }
}

}  // namespace srmp
