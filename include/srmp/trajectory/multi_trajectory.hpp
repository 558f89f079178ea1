#pragma once

#include <map>
#include <string>

#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Motions of many robots on one clock: all begin at time 0, and a robot whose own motion is over stays where it ended.
struct MultiTrajectory {
  std::map<std::string, Trajectory> robots;  ///< by name

  double duration() const;  ///< of the longest [s]
  /// Throws InvalidArgument with the nearest name.
  const Trajectory& at(const std::string& robot) const;
  /// All robots as one: joints "robot/joint", in the order of the robots' names; rows where any robot has one. The
  /// motion is that of the robots; there is no certificate. Throws InvalidArgument when there is no robot, or when some
  /// have times (or velocities) and others have not.
  Trajectory merged() const;
};

}  // namespace srmp
