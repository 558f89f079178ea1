#pragma once

#include <cstdint>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planning/multi_robot_world.hpp"

namespace srmp {

struct FreeGoalsOptions {
  std::uint64_t steps{2'048};     ///< of the choice: goals of a robot that are compared with those chosen before it
  std::uint64_t attempts{1'024};  ///< of RRT-Connect to another goal
  int paths{16};                  ///< to other goals that are looked for, at most
};

struct FreeGoals {
  /// One a robot, as if it were alone; empty: it has none.
  std::vector<std::vector<Eigen::VectorXd>> paths;
  std::uint64_t attempts{};  ///< of RRT-Connect
};

/// Paths of robots to goals that are free of each other. Each robot's own path leads to the goal that is best for it
/// alone, where another robot's may end too, though both may have further goals, as for poses. Where the ends of their
/// own paths are free, these are the paths; otherwise some robots go to other goals, the last ones first, each to the
/// nearest that is free. Where that is not found, the paths are the robots' own. `robots`: numbers in the world.
FreeGoals paths_to_free_goals(MultiRobotWorld& world, const std::vector<std::size_t>& robots, const Deadline& deadline,
                              const FreeGoalsOptions& options = {});

}  // namespace srmp
