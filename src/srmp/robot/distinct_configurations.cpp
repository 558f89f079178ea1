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
  const auto distance = [&](const Eigen::VectorXd& q) { return robot_.difference(reference, q).norm(); };
  std::stable_sort(found_.begin(), found_.end(),
                   [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return distance(a) < distance(b); });
  return std::exchange(found_, {});
}

}  // namespace srmp
