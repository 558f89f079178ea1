#include "srmp/planning/strategies/robot_sampling.hpp"

#include <algorithm>
#include <cmath>

namespace srmp {

namespace {

constexpr double step = 0.7;      // over all joints [rad, prismatic joints m]
constexpr double anywhere = 0.2;  // share of the samples

/// Where samples are taken from: `beyond` what the straight ways span, within the limits.
struct Region {
  Eigen::VectorXd lower, upper;

  Region(const RobotModel& robot, const search::RrtSpace& space, double beyond) {
    const Eigen::VectorXd& start = space.starts.front();
    lower = upper = start;
    for (const Eigen::VectorXd& goal : space.goals) {
      const Eigen::VectorXd way = robot.difference(start, goal);
      for (Eigen::Index k = 0; k < way.size(); ++k) {
        const double end = space.wraps[static_cast<std::size_t>(k)] ? start[k] + way[k] : goal[k];
        lower[k] = std::min(lower[k], end);
        upper[k] = std::max(upper[k], end);
      }
    }
    for (std::size_t i = 0; i < robot.dof(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      lower[k] = std::max(robot.joints()[i].lower, lower[k] - beyond);
      upper[k] = std::min(robot.joints()[i].upper, upper[k] + beyond);
    }
  }

  Eigen::VectorXd sample(search::RandomSequence& random) const {
    Eigen::VectorXd q = lower;
    for (Eigen::Index k = 0; k < q.size(); ++k) q[k] += (upper[k] - lower[k]) * random.next();
    return q;
  }
};

}  // namespace

search::RrtSpace rrt_space(const RobotModel& robot, const Eigen::VectorXd& start, std::vector<Eigen::VectorXd> goals) {
  search::RrtSpace space;
  space.starts = {start};
  space.goals = std::move(goals);
  space.max_step = step;
  for (const Joint& joint : robot.joints()) space.wraps.push_back(joint.kind == JointKind::continuous);
  space.sample = [near = Region(robot, space, M_PI / 2), far = Region(robot, space, 2 * M_PI)](
                     search::RandomSequence& random) { return (random.next() < anywhere ? far : near).sample(random); };
  return space;
}

}  // namespace srmp
