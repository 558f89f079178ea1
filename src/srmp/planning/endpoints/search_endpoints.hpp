#pragma once

#include <optional>
#include <vector>

#include "srmp/planning/endpoints/endpoints.hpp"

namespace srmp {

/// Where a search begins and may end, which need not be where its path does. Similar problems are to have similar
/// paths, but what a search finds depends on where exactly it begins and ends. Between configurations on a grid, which
/// most similar problems share, it finds the same; straight motions lead from the path's own ends to these and back.
struct SearchEndpoints : RobotEndpoints {
  Eigen::VectorXd path_start;
  std::vector<Eigen::VectorXd> path_targets;  ///< one a target

  /// Number of a target; none: the search found its end by itself.
  std::optional<std::size_t> target_number(const Eigen::VectorXd& target) const;
  /// What a search found, from `start` to the target of this number, with the motions from and to the path's own ends.
  RowMatrix with_own_ends(const RowMatrix& rows, std::optional<std::size_t> target) const;
  /// Joint-space length of these motions.
  double length_of_ends(const RobotModel& robot, std::optional<std::size_t> target) const;
};

/// The search has the ends of the path.
SearchEndpoints exact_endpoints(const RobotEndpoints& endpoints);

/// What rounding may do.
struct RoundingOptions {
  /// Cells of the grid in revolute joints, in turn until a motion is free. A turn is a multiple of each.
  std::vector<double> cells{24.0, 12.0, 6.0, 3.0};  ///< [degrees]
  double metres_per_degree{1.0 / 300.0};            ///< of cells in prismatic joints
  int max_checks{128};                              ///< of motions, for all ends together
};

/// Every end is the nearest configuration of the coarsest grid to which a straight motion is free, of those that differ
/// from the nearest one of all in at most one joint. Ends without one stay as they are. Throws MotionCheckStopped.
SearchEndpoints rounded_endpoints(RobotContext& context, const RobotEndpoints& endpoints,
                                  const RoundingOptions& options = {});

}  // namespace srmp
