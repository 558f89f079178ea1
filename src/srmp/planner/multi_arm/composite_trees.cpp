#include "srmp/planner/multi_arm/composite_trees.hpp"

#include <algorithm>
#include <cmath>

namespace srmp {

namespace {

constexpr double stays = 0.1;  // share of the samples in which an arm is at its start; as many, at its goal

Eigen::VectorXd sample(const CompositeSpace& space, search::RandomSequence& random) {
  Eigen::VectorXd q = space.start();
  for (std::size_t i = 0; i < space.size(); ++i) {
    const double choice = random.next();
    if (choice < stays) continue;
    auto part = space.part(q, i);
    if (choice < 2 * stays && !space.task(i).anywhere) {
      part = space.task(i).targets.front();
      continue;
    }
    for (Eigen::Index k = 0; k < part.size(); ++k) {
      const Joint& joint = space.joints()[static_cast<std::size_t>(space.first(i) + k)];
      const double lower = std::max(joint.lower, -M_PI), upper = std::min(joint.upper, M_PI);
      part[k] = lower + (upper - lower) * random.next();
    }
  }
  return q;
}

}  // namespace

search::TreeSpace tree_space(const CompositeSpace& space) {
  search::TreeSpace trees;
  trees.starts = {space.start()};
  trees.goals = space.targets();
  trees.longest_step = 1.0;  // over all joints [rad, prismatic joints m]
  trees.sample = [&space](search::RandomSequence& random) { return sample(space, random); };
  trees.is_motion_free = [&space](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return space.is_motion_free(a, b);
  };
  return trees;
}

}  // namespace srmp
