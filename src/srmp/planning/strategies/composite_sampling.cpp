#include "srmp/planning/strategies/composite_sampling.hpp"

#include "srmp/planning/strategies/robot_sampling.hpp"

namespace srmp {

namespace {

using Sampler = std::function<Eigen::VectorXd(search::RandomSequence&)>;

/// Of each robot as if it were alone.
std::vector<Sampler> samplers(const CompositeSpace& space) {
  std::vector<Sampler> found;
  for (std::size_t i = 0; i < space.size(); ++i) {
    std::vector<Eigen::VectorXd> targets;
    for (const Eigen::VectorXd& target : space.targets()) targets.push_back(space.part(target, i));
    found.push_back(rrt_space(space.model(i), space.part(space.start(), i), std::move(targets)).sample);
  }
  return found;
}

Eigen::VectorXd sample(const CompositeSpace& space, const std::vector<Sampler>& alone, double stay_fraction,
                       search::RandomSequence& random) {
  Eigen::VectorXd q = space.start();
  for (std::size_t i = 0; i < space.size(); ++i) {
    const double choice = random.next();
    if (choice < stay_fraction) continue;
    if (choice < 2 * stay_fraction && !space.targets().empty())
      space.part(q, i) = space.part(space.targets().front(), i);
    else
      space.part(q, i) = alone[i](random);
  }
  return q;
}

}  // namespace

search::RrtSpace rrt_space(const CompositeSpace& space, const CompositeSamplingOptions& options) {
  search::RrtSpace trees;
  trees.starts = {space.start()};
  trees.goals = space.targets();
  trees.max_step = options.max_step;
  for (const Joint& joint : space.joints()) trees.wraps.push_back(joint.kind == JointKind::continuous);
  trees.sample = [&space, alone = samplers(space), stay_fraction = options.stay_fraction](
                     search::RandomSequence& random) { return sample(space, alone, stay_fraction, random); };
  trees.is_motion_free = [&space](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return space.is_motion_free(a, b);
  };
  return trees;
}

}  // namespace srmp
