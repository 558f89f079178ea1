#pragma once

#include "srmp/planning/strategies/composite_space.hpp"
#include "srmp/search/rrt_connect.hpp"

namespace srmp {

struct CompositeSamplingOptions {
  double max_step{
      1.0};  ///< over all joints [rad, prismatic joints m]: longer steps need fewer checks, and fail more often
  /// Fraction of the samples in which a robot is at its start; in as many it is at its goal. More lets robots pass each
  /// other where only some of them move; less explores more of the space where all must move at once.
  double stay_fraction{0.1};
};

/// The joints of all robots, for two trees to grow in: quick where robots block each other from start to goal, where
/// no lattice of so many joints holds a path that is found soon. Robots that are not at an end of their path are where
/// robot_sampling.hpp has them. The space outlives this.
search::RrtSpace rrt_space(const CompositeSpace& space, const CompositeSamplingOptions& options = {});

}  // namespace srmp
