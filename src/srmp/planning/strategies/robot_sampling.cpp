#include "srmp/planning/strategies/robot_sampling.hpp"

#include <algorithm>
#include <cmath>

namespace srmp {

namespace {

/// Where samples are taken from: the box around the straight motions to the goals, made wider by `margin` on each side,
/// within the limits.
struct Region {
  Eigen::VectorXd lower, upper;

  Region(const RobotModel& robot, const search::RrtSpace& space, double margin) {
    const Eigen::VectorXd& start = space.starts.front();
    lower = upper = start;
    for (const Eigen::VectorXd& goal : space.goals) {
      const Eigen::VectorXd motion = robot.difference(start, goal);
      for (Eigen::Index k = 0; k < motion.size(); ++k) {
        const double end = space.wraps[static_cast<std::size_t>(k)] ? start[k] + motion[k] : goal[k];
        lower[k] = std::min(lower[k], end);
        upper[k] = std::max(upper[k], end);
      }
    }
    for (std::size_t i = 0; i < robot.dof(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      lower[k] = std::max(robot.joints()[i].lower, lower[k] - margin);
      upper[k] = std::min(robot.joints()[i].upper, upper[k] + margin);
    }
  }

  Eigen::VectorXd sample(search::RandomSequence& random) const {
    Eigen::VectorXd q = lower;
    for (Eigen::Index k = 0; k < q.size(); ++k) q[k] += (upper[k] - lower[k]) * random.next();
    return q;
  }
};

}  // namespace

search::RrtSpace rrt_space(const RobotModel& robot, const Eigen::VectorXd& start, std::vector<Eigen::VectorXd> goals,
                           const RobotSamplingOptions& options) {
  search::RrtSpace space;
  space.starts = {start};
  space.goals = std::move(goals);
  space.max_step = options.max_step;
  for (const Joint& joint : robot.joints()) space.wraps.push_back(joint.kind == JointKind::continuous);
  space.sample = [near = Region(robot, space, options.near_margin), far = Region(robot, space, options.far_margin),
                  far_fraction = options.far_fraction](search::RandomSequence& random) {
    return (random.next() < far_fraction ? far : near).sample(random);
  };
  return space;
}

}  // namespace srmp
