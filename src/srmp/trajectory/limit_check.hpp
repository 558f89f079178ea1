#pragma once

#include <vector>

#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

struct LimitCheckOptions {
  const std::vector<Joint>* joints{};           ///< whose position limits are checked; null: none
  bool limits{true};                            ///< exceeded velocity and acceleration limits are faults
  bool jerk{false};                             ///< exceeded jerk limits are faults
  bool at_rest{true};                           ///< the robot is at rest before and after the motion
  const Eigen::VectorXd* start_acceleration{};  ///< before the motion, with at_rest; null or empty: 0
};

/// Adds to the certificate which fractions of the limits the motion uses, at the extrema of its polynomials, and faults
/// where that is more than all. The trajectory has times and is valid (Trajectory::validate).
void check_limits(const Trajectory& trajectory, const MotionLimits& limits, const LimitCheckOptions& options,
                  Certificate& result);

/// What the certificate of a whole motion says of a part of it, or of both motions of a join says of the whole: what
/// was proved stays proved, the use of limits is found anew. Null where there is no certificate that holds, and where
/// the two motions were verified against different limits.
std::shared_ptr<const Certificate> certificate_of_part(const Trajectory& whole, const Trajectory& part);
std::shared_ptr<const Certificate> certificate_of_join(const Trajectory& first, const Trajectory& next,
                                                       const Trajectory& whole);
/// Of another motion near one that has a certificate: its use of the same limits, and faults where it exceeds them;
/// collisions are not checked. Null where there is no certificate.
std::shared_ptr<const Certificate> certificate_of_limits(const Trajectory& of, const Trajectory& motion);

}  // namespace srmp
