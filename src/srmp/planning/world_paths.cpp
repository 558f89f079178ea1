#include "srmp/planning/world_paths.hpp"

#include <algorithm>

#include "srmp/trajectory/path.hpp"

namespace srmp {

JointPath joint_path(const MultiRobotWorld& world, std::size_t robot, const std::vector<Eigen::VectorXd>& waypoints) {
  JointPath path{{robot}, {0.0}, {stack_waypoints(waypoints)}};
  for (std::size_t k = 1; k < waypoints.size(); ++k)
    path.steps.push_back(path.steps.back() + world.duration(robot, waypoints[k - 1], waypoints[k]));
  return path;
}

JointPath joint_path(const MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                     const std::vector<std::vector<Eigen::VectorXd>>& paths) {
  JointPath path{robots, {0.0}, {}};
  for (std::size_t i = 0; i < robots.size(); ++i)
    path.positions.push_back(world.unwrapped(robots[i], stack_waypoints(paths[i])));
  for (std::size_t k = 1; k < paths.front().size(); ++k) {
    int longest = 1;
    for (std::size_t i = 0; i < robots.size(); ++i)
      longest = std::max(longest, world.duration(robots[i], paths[i][k - 1], paths[i][k]));
    path.steps.push_back(path.steps.back() + longest);
  }
  return path;
}

JointPath joint_path(const MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                     const std::vector<multi::TimedPath>& paths) {
  JointPath coupled{robots, {}, {}};
  std::vector<int> steps{0};
  for (const multi::TimedPath& path : paths)
    for (const multi::Move& move : path.moves) steps.push_back(move.start);
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  coupled.steps.assign(steps.begin(), steps.end());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    RowMatrix q(std::ssize(steps), static_cast<Eigen::Index>(world.model(robots[i]).dof()));
    auto move = paths[i].moves.begin();
    for (Eigen::Index row = 0; row < q.rows(); ++row) {
      const int step = steps[static_cast<std::size_t>(row)];
      while (move->end <= step) ++move;
      q.row(row) = world.at(robots[i], *move, step).transpose();
    }
    coupled.positions.push_back(world.unwrapped(robots[i], q));
  }
  return coupled;
}

bool in_conflict(MultiRobotWorld& world, const JointPath& a, const JointPath& b) {
  std::vector<double> steps;  // none until they are needed: most groups are far from each other
  for (std::size_t i = 0; i < a.robots.size(); ++i)
    for (std::size_t j = 0; j < b.robots.size(); ++j) {
      if (!world.may_conflict(a.robots[i], b.robots[j])) continue;
      if (steps.empty()) steps = all_steps({&a, &b});
      for (std::size_t row = 0; row < std::max<std::size_t>(steps.size() - 1, 1); ++row) {
        const double from = steps[row], to = steps[std::min(row + 1, steps.size() - 1)];
        if (!world.are_collision_free(a.robots[i], position_at(a, i, from), position_at(a, i, to), b.robots[j],
                                      position_at(b, j, from), position_at(b, j, to), {.start_is_free = row > 0}))
          return true;
      }
    }
  return false;
}

}  // namespace srmp
