#include "srmp/lattice/primitives.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

double grid_unit(const Joint& joint) {
  return joint.kind == JointKind::prismatic ? 1e-6 : 1e-4 * std::numbers::pi / 180.0;
}

PrimitiveSet default_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step) {
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

PrimitiveSet rich_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step) {
  PrimitiveFamily alone = default_primitives(joints, step).families.front();
  Eigen::VectorXd all = Eigen::VectorXd::Zero(step.size());
  for (const Eigen::VectorXd& move : alone.moves) all += move.cwiseMax(0.0);
  PrimitiveFamily towards{"towards", PrimitiveUse::towards, {all}}, pairs{"pairs", PrimitiveUse::always, {}};
  for (const Eigen::Index gap : {1, 2})
    for (Eigen::Index j = 0; j + gap < step.size(); ++j)
      for (const double first : {-1.0, 1.0})
        for (const double second : {-1.0, 1.0}) {
          Eigen::VectorXd& move = pairs.moves.emplace_back(Eigen::VectorXd::Zero(step.size()));
          move[j] = first * all[j];
          move[j + gap] = second * all[j + gap];
        }
  return {{std::move(towards), std::move(alone), std::move(pairs)}};
}

}  // namespace srmp
