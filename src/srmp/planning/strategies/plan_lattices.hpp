#pragma once

#include <optional>
#include <string>

#include "srmp/lattice/lattice.hpp"
#include "srmp/planning/best_path.hpp"
#include "srmp/planning/endpoints/endpoints.hpp"

namespace srmp {

/// Makes the lattices of one plan, from the start or, backward, from the targets, and says what a search found in them.
class PlanLattices {
 public:
  /// Both outlive it and its lattices.
  PlanLattices(PlanContext& context, const Endpoints& ends);

  /// Has the user given motion primitives of his own? Then all lattices have these.
  bool own_primitives() const { return !context_.common.mprim_path.empty(); }
  Lattice plain(bool backward);               ///< with default_primitives
  Lattice rich(bool backward, double scale);  ///< with rich_primitives, `scale` times the resolution asked for

  /// For users: as Solution::graph.
  std::string describe(bool backward, double scale = 1.0) const;
  /// Of a solved search in one of the lattices. Its lower bound is the search's own.
  FoundPath path_of(const search::Result& result, const Lattice& lattice, bool backward, double scale = 1.0) const;

 private:
  Lattice make(bool backward, PrimitiveSet primitives);
  PrimitiveSet read_primitives() const;
  const std::vector<JointPair>& pairs();
  Eigen::VectorXd step(double scale = 1.0) const;
  double resolution(double scale) const;

  PlanContext& context_;
  const Endpoints& ends_;
  GoalConnection goal_connection_;
  std::optional<std::vector<JointPair>> pairs_;  // once asked for
};

}  // namespace srmp
