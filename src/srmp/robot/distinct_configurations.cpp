#include "srmp/robot/distinct_configurations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace srmp {

/// Joint by joint, up to the first that differs: most do in the first ones.
bool DistinctConfigurations::has_one_close_to(const Eigen::VectorXd& q) const {
  return std::any_of(found_.begin(), found_.end(), [&](const Eigen::VectorXd& other) {
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      double change = q[i] - other[i];
      if (robot_.joints()[static_cast<std::size_t>(i)].kind == JointKind::continuous)
        change = std::remainder(change, 2 * std::numbers::pi);
      if (!(std::abs(change) < distance_)) return false;
    }
    return true;
  });
}

std::vector<Eigen::VectorXd> DistinctConfigurations::take_nearest_first(ConstVector reference) {
  return nearest_first(robot_, reference, std::exchange(found_, {}));
}

std::vector<Eigen::VectorXd> nearest_first(const RobotModel& robot, ConstVector reference,
                                           std::vector<Eigen::VectorXd> configurations) {
  std::vector<std::pair<double, std::size_t>> order;
  for (const Eigen::VectorXd& q : configurations)
    order.emplace_back(robot.difference(reference, q).norm(), order.size());
  std::sort(order.begin(), order.end());
  std::vector<Eigen::VectorXd> sorted;
  for (const auto& [distance, i] : order) sorted.push_back(std::move(configurations[i]));
  return sorted;
}

}  // namespace srmp
