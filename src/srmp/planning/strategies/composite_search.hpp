#pragma once

#include <cstdint>
#include <vector>

#include "srmp/core/status.hpp"
#include "srmp/planning/strategies/composite_space.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

struct CompositeOptions {
  double weight{50.0};             ///< as Auto::weight
  std::uint64_t max_expansions{};  ///< of one search of the portfolio
};

struct CompositeResult {
  Status status{Status::exhausted};  ///< solved, exhausted, timed_out (also for max_expansions) or cancelled
  JointPath path;
  search::Statistics statistics;
};

/// Arms as one robot with all their joints: guided searches in turns from both ends, at several resolutions, as `auto`
/// makes them for one arm, also with guides that lead one arm before the others. Finds ways that arms can only go
/// together; gets harder with every arm. Arms whose goal is anywhere end where they start.
CompositeResult composite_search(const CompositeSpace& space, const CompositeOptions& options,
                                 const Deadline& deadline);

}  // namespace srmp
