#include "srmp/lattice/primitives.hpp"

#include "srmp/core/error.hpp"

namespace srmp {

PrimitiveSet default_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step) {
  const auto dof = static_cast<Eigen::Index>(joints.size());
  PrimitiveFamily far{"long", PrimitiveUse::far, {}}, always{"short", PrimitiveUse::always, {}};
  for (Eigen::Index j = 0; j < dof; ++j) {
    require_positive(step[j], "lattice resolution of joint '" + joints[static_cast<std::size_t>(j)].name + "'");
    for (const double sign : {1.0, -1.0}) {
      always.moves.push_back(Eigen::VectorXd::Unit(dof, j) * sign * step[j]);
      far.moves.push_back(Eigen::VectorXd::Unit(dof, j) * sign * 2.0 * step[j]);
    }
  }
  return {{std::move(far), std::move(always)}};
}

}  // namespace srmp
