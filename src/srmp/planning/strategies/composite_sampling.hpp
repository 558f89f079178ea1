#pragma once

#include "srmp/planning/strategies/composite_space.hpp"
#include "srmp/search/rrt_connect.hpp"

namespace srmp {

/// The joints of all robots, for two trees to grow in: quick where robots are in each other's way from start to goal,
/// of which no lattice of so many joints holds a way that is found soon. Robots are often told to stay at an end of
/// their way, for they get by each other where only some of them move; else they are where robot_sampling.hpp has them.
/// The space outlives this.
search::RrtSpace rrt_space(const CompositeSpace& space);

}  // namespace srmp
