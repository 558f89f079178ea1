#pragma once

#include <cstdint>
#include <vector>

#include "srmp/core/status.hpp"
#include "srmp/planning/strategies/composite_space.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

struct CompositeOptions {
  double weight{50.0};                         ///< of each search, as Auto::weight
  std::uint64_t max_expansions{};              ///< of each search
  std::vector<double> scales{3.0, 1.5, 0.75};  ///< of the lattices' steps, as multiples of the world's resolution
  std::uint64_t fine_from{1024};  ///< with fewer expansions, lattices finer than the world's resolution are left out
};

struct CompositeResult {
  Status status{Status::exhausted};  ///< solved, exhausted, timed_out (also for max_expansions) or cancelled
  JointPath path;
  search::Statistics statistics;
};

/// Robots as one robot with all their joints: lattices at several resolutions, searched side by side from both ends
/// (lattice_portfolio.hpp), also by heuristics that move one robot before the others. Finds paths on which robots must
/// move jointly; gets harder with every robot. Robots that may end anywhere end where they start.
CompositeResult composite_search(const CompositeSpace& space, const CompositeOptions& options,
                                 const Deadline& deadline);

}  // namespace srmp
