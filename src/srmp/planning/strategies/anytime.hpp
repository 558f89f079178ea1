#pragma once

#include "srmp/planning/strategies/best_path.hpp"
#include "srmp/planning/strategies/robot_lattices.hpp"

namespace srmp {

struct AnytimeOptions {
  bool trees{true};  ///< false: lattices alone
  /// Of what the best path is longer than the straight line, each round asks for paths that save so much: 1 - fraction.
  /// Small fractions find much better paths or exhaust their lattices, which proves a bound; 1 takes whatever is
  /// better.
  std::vector<double> fractions{0.5, 0.75, 0.9, 1.0};
  std::uint64_t first_expansions{64};                    ///< of one search in the first round
  std::uint64_t growth{4};                               ///< of that number, from one round to the next
  std::uint64_t max_expansions{std::uint64_t{1} << 40};  ///< and of tree checks
  double refinement{0.87};                ///< lattice steps of a round, as a multiple of those of the round before
  double min_scale{0.01};                 ///< lattices are refined down to this multiple of those of the first path
  std::uint64_t first_tree_checks{8192};  ///< motions checked for trees and to shorten their paths, in the first round
  std::uint64_t tree_growth{2};           ///< of that number, from one round to the next
  std::uint64_t checks_of_a_tree{512};    ///< > 0; then other samples are tried
  std::uint64_t least_of_a_tree{128};     ///< counted for one that finds a path, and its shortening
  /// Samples of trees are where a path may pass that is no longer than this multiple of the best one: what trees find
  /// is still to be shortened.
  double sampled_length{1.3};
  double promising_length{1.15};  ///< as a multiple of the best path's: longer ones are not shortened carefully
};

/// Shorter and shorter paths than the first one, for as many rounds or as long as asked. A round begins with trees of
/// other samples, from where a path not much longer than the best one may pass (Gammell, Srinivasa, Barfoot 2014,
/// "Informed RRT*"): when shortened, their paths often pass obstacles on another side. Then it searches lattices, only
/// where a path could be shorter than the best by a good part of what it is longer than the straight line; a lattice
/// exhausted there proves that its optimum is longer. When a round finds nothing, the next ones have more expansions,
/// in finer lattices.
///
/// `endpoints`: of trees. `direct`: joint-space distance from the start to the nearest goal.
void improve_path(RobotContext& context, const SearchEndpoints& endpoints, RobotLattices& lattices, BestPath& best,
                  FoundPath first, double direct, const AnytimeOptions& options = {});

}  // namespace srmp
