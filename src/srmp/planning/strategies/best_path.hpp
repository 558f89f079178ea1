#pragma once

#include <string>

#include "srmp/planning/robot_context.hpp"
#include "srmp/planning/smoothing/preferred_clearance.hpp"
#include "srmp/planning/strategies/strategy.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

/// A first path is needed soon: a tenth of the checks save most of what can be saved.
inline const ShortcutOptions quick_shortcut{
    .min_gain = 1e-2, .max_rounds = 2, .halvings = 3, .pull_gain = 2e-2, .cut_gain = 1.0, .continuous = {}};

/// The shortest path of one robot so far and what is proven about it. Writes both into the plan's statistics and tells
/// the user.
class BestPath {
 public:
  explicit BestPath(RobotContext& context)
      : context_(context), preferred_(context.problem.checkers, context.common, context.deadline) {}

  bool empty() const { return waypoints_.rows() == 0; }
  const RowMatrix& waypoints() const { return waypoints_; }

  /// No path of `graph` costs less than `lower`.
  void bound(double lower, const std::string& graph);
  /// Shortens a path, as the options say and no longer than `until`, and keeps it when it is the shortest so far.
  /// False: the user wants no better one.
  bool take(FoundPath found, const Deadline& until, const ShortcutOptions& options = {});
  /// The same once there is a path, but one that a quick shortcut leaves longer than `ratio` times the shortest so far
  /// is dropped.
  bool take_if_promising(FoundPath found, const Deadline& until, double ratio, const ShortcutOptions& options);
  /// As `bound`, once there is a path: tells the user if its bound is better now. False: the user wants no better one.
  bool prove(double lower, const std::string& graph);
  /// No better one is needed: it is as short as `direct`, the straight line, or `final_weight` is above 1 and proven.
  bool good_enough(double final_weight, double direct) const;

 private:
  RowMatrix shortened(const RowMatrix& path, const Deadline& until, ShortcutOptions options);

  RobotContext& context_;
  PreferredClearance preferred_;
  RowMatrix waypoints_;
  double lower_{0.0};  // no path of statistics.bound_graph costs less
};

}  // namespace srmp
