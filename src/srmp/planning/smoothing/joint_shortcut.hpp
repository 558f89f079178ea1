#pragma once

#include "srmp/core/deadline.hpp"
#include "srmp/planning/world_paths.hpp"

namespace srmp {

struct JointShortcutOptions {
  int max_rounds{3};      ///< >= 0, of all robots: more paths become a little shorter, for as many checks a round
  double min_gain{0.02};  ///< a round that saves less of the length is the last: less saves more, for more checks
  /// [rad, prismatic joints m] of a part's length that is worth tightening: less straightens smaller bends, for more
  /// checks.
  double min_detour{0.05};
};

/// Shorter, and free where `path` is: all robots at once go straight between rows where they can; then robot by robot,
/// while the others move as before (its own waits are removed too). No robot's path becomes longer. Stops at the
/// deadline with the best path so far. For paths of one robot, which need no times, see trajectory/shortcut.hpp.
JointPath shortened(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                    const JointShortcutOptions& options = {});
/// Nearer to straight where it cannot be straight, robot by robot: parts of paths bend no more than they must, from
/// whole paths to parts of two rows.
JointPath tightened(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                    const JointShortcutOptions& options = {});

}  // namespace srmp
