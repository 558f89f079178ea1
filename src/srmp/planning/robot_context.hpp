#pragma once

#include "srmp/planning/motion_checks.hpp"
#include "srmp/planning/problem.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

/// What the parts of one robot's search share: what it is to do among what stands still for its checker, how long that
/// may take, and the checks and statistics of the search. References outlive this.
struct RobotContext {
  const PlanProblem& problem;
  const RobotProblem& task;
  const PlannerOptions& options;  ///< of this robot's search; need not be the problem's
  const CommonOptions& common;    ///< of `options`
  const RobotModel& robot;
  const Deadline& deadline;
  PlanStatistics& statistics;
  MotionChecks checks;

  RobotContext(const PlanProblem& problem, const RobotProblem& task, const PlannerOptions& options,
               const Checker& checker, const Deadline& deadline, PlanStatistics& statistics);

  /// Throws PlanningError when the plan was cancelled or its time limit has passed.
  void stop_if_late(const std::string& phase) const;
  /// Why a search that is not solved has no path. `no_path` begins the sentence for an exhausted search, as in "the
  /// lattice holds no".
  std::string no_path_sentence(const search::Result& result, const std::string& no_path,
                               const std::string& expanded = "states expanded") const;
  /// Adds to the statistics.
  void count(const search::Statistics& work);
  /// Joint-space length [rad, prismatic joints m].
  double length(const std::vector<Eigen::VectorXd>& path) const;
};

}  // namespace srmp
