#pragma once

#include <optional>

#include "srmp/collision/checker.hpp"

namespace srmp {

/// A value that a joint cannot pass: two bodies are in contact there wherever the other joints are.
struct JointBarrier {
  std::size_t joint{};
  double position{};  ///< [rad or m]
  Contact contact;    ///< there, with the other joints as at `from`
};

/// Looks for a barrier between the values of each joint at two configurations. The bodies in contact must be two whose
/// relative pose depends on that joint alone; then every path from the one to the other leads through it (intermediate
/// value theorem), so that there is none. Continuous joints, which can turn in the other direction, are left out. Finds
/// every barrier that is wider than the rounding of distances, but none that two or more joints make together.
///
/// The result depends on the arguments alone. None with a checker that is not the library's own (make_checker). Throws
/// MotionCheckStopped as Checker::stop_at says.
std::optional<JointBarrier> find_joint_barrier(const Checker& checker, ConstVector from, ConstVector to,
                                               Checker::Workspace& workspace);

}  // namespace srmp
