#pragma once

#include <string>
#include <vector>

#include "srmp/planning/plan_context.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

/// A path as a search found it, from start to goal.
struct FoundPath {
  std::vector<Eigen::VectorXd> waypoints;
  int goal_index{};
  double cost{};
  double lower{};     ///< no path of `graph` costs less
  std::string graph;  ///< as Solution::graph
};

/// The shortest path so far and what is proven of it; writes both into the plan's statistics and tells the user.
class BestPath {
 public:
  explicit BestPath(PlanContext& context) : context_(context) {}

  bool empty() const { return waypoints_.empty(); }
  const std::vector<Eigen::VectorXd>& waypoints() const { return waypoints_; }

  /// No path of `graph` costs less than `lower`.
  void bound(double lower, const std::string& graph);
  /// Shortens a path, as the options say and no longer than `until`, and keeps it when it is the shortest so far.
  /// False: the user wants no better one.
  bool take(FoundPath found, const Deadline& until, const ShortcutOptions& effort = {});
  /// `bound` of a path that there is: tells of it if it or its bound is news. False: the user wants no better one.
  bool prove(double lower, const std::string& graph);

 private:
  std::vector<Eigen::VectorXd> shortened(const std::vector<Eigen::VectorXd>& path, const Deadline& until,
                                         ShortcutOptions options);

  PlanContext& context_;
  std::vector<Eigen::VectorXd> waypoints_;
  double lower_{0.0};  // no path of statistics.bound_graph costs less
};

}  // namespace srmp
