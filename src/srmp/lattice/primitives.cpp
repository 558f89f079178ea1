#include "srmp/lattice/primitives.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

double grid_unit(const Joint& joint) {
  return joint.kind == JointKind::prismatic ? 1e-6 : 1e-4 * std::numbers::pi / 180.0;
}

Eigen::VectorXd lattice_step(const std::vector<Joint>& joints, double turn, double slide) {
  Eigen::VectorXd step(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j)
    step[static_cast<Eigen::Index>(j)] = joints[j].kind == JointKind::prismatic ? slide : turn;
  return step;
}

PrimitiveSet axis_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step) {
  const auto dof = static_cast<Eigen::Index>(joints.size());
  PrimitiveFamily whole{"whole", PrimitiveUse::always, {}}, third{"third", PrimitiveUse::near, {}};
  for (Eigen::Index j = 0; j < dof; ++j) {
    const Joint& joint = joints[static_cast<std::size_t>(j)];
    require_positive(step[j], "lattice resolution of joint '" + joint.name + "'");
    // Three thirds must end exactly where a whole step does, or the lattice would fill with near twins.
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
  std::vector<Eigen::Vector3d> axes(robot.dof(), Eigen::Vector3d::Zero());  // of joints that turn
  for (std::size_t k = robot.actuated_joints().size(); k-- > 0;)
    if (const ActuatedJoint& drive = robot.actuated_joints()[k]; !drive.prismatic)
      axes[drive.joint] = robot.actuated_joint_axis(*data, k).second;
  std::vector<JointPair> pairs;
  for (Eigen::Index j = 0; j < dof; ++j)
    for (Eigen::Index k = j + 1; k < std::min(j + 3, dof); ++k)
      if (std::abs(axes[static_cast<std::size_t>(j)].dot(axes[static_cast<std::size_t>(k)])) > 0.99)
        pairs.emplace_back(j, k);
  return pairs;
}

PrimitiveSet rich_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                             const std::vector<JointPair>& pairs) {
  PrimitiveFamily alone = axis_primitives(joints, step).families.front();
  Eigen::VectorXd all = Eigen::VectorXd::Zero(step.size());
  for (const Eigen::VectorXd& move : alone.moves) all += move.cwiseMax(0.0);
  PrimitiveFamily towards{"towards", PrimitiveUse::towards, {all}}, together{"pairs", PrimitiveUse::always, {}};
  for (const auto& [j, k] : pairs)
    for (const double first : {-1.0, 1.0})
      for (const double second : {-1.0, 1.0}) {
        Eigen::VectorXd& move = together.moves.emplace_back(Eigen::VectorXd::Zero(step.size()));
        move[j] = first * all[j];
        move[k] = second * all[k];
      }
  return {{std::move(towards), std::move(alone), std::move(together)}};
}

PrimitiveSet default_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                                const std::vector<JointPair>& pairs) {
  PrimitiveSet set = rich_primitives(joints, step, pairs);
  set.families.push_back(axis_primitives(joints, step).families.back());
  set.near_distance = step.maxCoeff() / 2;
  return set;
}

}  // namespace srmp
