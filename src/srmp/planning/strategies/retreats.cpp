#include "srmp/planning/strategies/retreats.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace srmp {

std::vector<Eigen::VectorXd> retreat_candidates(const RobotModel& robot, const Eigen::VectorXd& start,
                                                const Eigen::VectorXd& goal,
                                                const std::vector<Eigen::VectorXd>& branch_points,
                                                const RetreatOffsets& offsets) {
  const auto dof = static_cast<Eigen::Index>(robot.dof());
  std::vector<Eigen::VectorXd> candidates;
  const auto add = [&](Eigen::VectorXd q) {
    if (!robot.limit_violation(q)) candidates.push_back(std::move(q));
  };
  for (const Eigen::VectorXd& branch_point : branch_points)
    for (Eigen::Index j = 0; j < dof; ++j)
      for (const double offset : offsets.joint) {
        Eigen::VectorXd q = branch_point;
        q[j] += offset;
        add(q);
        for (Eigen::Index k = j + 1; k < dof; ++k)
          for (const double second_offset : offsets.second_joint) {
            Eigen::VectorXd both = q;
            both[k] += second_offset;
            add(both);
          }
      }
  const auto detour = [&](const Eigen::VectorXd& q) {
    return robot.difference(start, q).norm() + robot.difference(q, goal).norm();
  };
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < candidates.size(); ++i) order.emplace_back(detour(candidates[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<Eigen::VectorXd> sorted;
  for (const auto& [cost, i] : order) sorted.push_back(candidates[i]);
  return sorted;
}

double collision_free_fraction(MultiRobotWorld& world, std::size_t robot, const Eigen::VectorXd& q,
                               const std::vector<std::vector<Eigen::VectorXd>>& paths) {
  std::ptrdiff_t all = 0, free = 0;
  for (std::size_t other = 0; other < paths.size(); ++other) {
    if (other == robot || !world.may_conflict(robot, other)) continue;
    const std::vector<char> found = world.collision_free_with(robot, q, other, paths[other]);
    all += std::ssize(found);
    free += std::count(found.begin(), found.end(), 1);
  }
  return all ? static_cast<double>(free) / static_cast<double>(all) : 1.0;
}

}  // namespace srmp
