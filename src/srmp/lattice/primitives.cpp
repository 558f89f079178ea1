#include "srmp/lattice/primitives.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr double min_parallel = 0.99;  // cosine of the angle between two axes that count as parallel

}  // namespace

double grid_unit(const Joint& joint) {
  return joint.kind == JointKind::prismatic ? 1e-6 : 1e-4 * std::numbers::pi / 180.0;
}

Eigen::VectorXd lattice_step(const std::vector<Joint>& joints, double revolute, double prismatic) {
  Eigen::VectorXd step(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j)
    step[static_cast<Eigen::Index>(j)] = joints[j].kind == JointKind::prismatic ? prismatic : revolute;
  return step;
}

PrimitiveSet axis_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step) {
  const auto dof = static_cast<Eigen::Index>(joints.size());
  PrimitiveFamily whole{"whole", PrimitiveUse::always, {}}, third{"third", PrimitiveUse::near, {}};
  for (Eigen::Index j = 0; j < dof; ++j) {
    const Joint& joint = joints[static_cast<std::size_t>(j)];
    require_positive(step[j], "lattice resolution of joint '" + joint.name + "'");
    // Three thirds must end exactly where a whole step does, or the lattice would fill with near duplicates.
    const double a_third = grid_unit(joint) * std::max(1.0, std::round(step[j] / 3.0 / grid_unit(joint)));
    for (const double sign : {1.0, -1.0}) {
      whole.moves.push_back(Eigen::VectorXd::Unit(dof, j) * sign * 3.0 * a_third);
      third.moves.push_back(Eigen::VectorXd::Unit(dof, j) * sign * a_third);
    }
  }
  return {{std::move(whole), std::move(third)}};
}

std::vector<JointPair> parallel_pairs(const RobotModel& robot) {
  const auto dof = static_cast<Eigen::Index>(robot.dof());
  const RobotDataPtr data = robot.make_data();
  robot.forward(*data, Eigen::VectorXd::Zero(dof));
  std::vector<Eigen::Vector3d> axes(robot.dof(), Eigen::Vector3d::Zero());  // zero for prismatic joints
  for (std::size_t k = robot.actuated_joints().size(); k-- > 0;)
    if (const ActuatedJoint& actuated = robot.actuated_joints()[k]; !actuated.prismatic)
      axes[actuated.joint] = robot.actuated_joint_axis(*data, k).second;
  std::vector<JointPair> pairs;
  for (Eigen::Index j = 0; j < dof; ++j)
    for (Eigen::Index k = j + 1; k < std::min(j + 3, dof); ++k)
      if (std::abs(axes[static_cast<std::size_t>(j)].dot(axes[static_cast<std::size_t>(k)])) > min_parallel)
        pairs.emplace_back(j, k);
  return pairs;
}

PrimitiveSet rich_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                             const std::vector<JointPair>& pairs) {
  PrimitiveFamily alone = axis_primitives(joints, step).families.front();
  Eigen::VectorXd all = Eigen::VectorXd::Zero(step.size());
  for (const Eigen::VectorXd& move : alone.moves) all += move.cwiseMax(0.0);
  PrimitiveFamily to_targets{"to targets", PrimitiveUse::to_targets, {all}}, both{"pairs", PrimitiveUse::always, {}};
  for (const auto& [j, k] : pairs)
    for (const double first : {-1.0, 1.0})
      for (const double second : {-1.0, 1.0}) {
        Eigen::VectorXd& move = both.moves.emplace_back(Eigen::VectorXd::Zero(step.size()));
        move[j] = first * all[j];
        move[k] = second * all[k];
      }
  return {{std::move(to_targets), std::move(alone), std::move(both)}};
}

PrimitiveSet default_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                                const std::vector<JointPair>& pairs) {
  PrimitiveSet set = rich_primitives(joints, step, pairs);
  set.families.push_back(axis_primitives(joints, step).families.back());
  set.near_distance = step.maxCoeff() / 2;
  return set;
}

}  // namespace srmp
