#pragma once

#include "srmp/planning/motion_checks.hpp"
#include "srmp/planning/single_robot.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

/// What the parts of one plan share: the question, how long it may take, and the checks and statistics of the answer.
struct PlanContext {
  const SingleRobotProblem& problem;
  const CommonOptions& common;
  const RobotModel& robot;
  const Deadline& deadline;
  PlanStatistics& statistics;
  MotionChecks checks;

  /// All of them outlive it.
  PlanContext(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics);

  /// Throws PlanningError when the plan was cancelled or its time is over.
  void stop_if_late(const std::string& phase) const;
  /// Throws PlanningError unless solved. `no_path` begins the sentence for an exhausted search, as in "the lattice
  /// holds no".
  void require_solved(const search::Result& result, const std::string& no_path) const;
  /// Into the statistics.
  void count(const search::Statistics& work);
  /// In joint space [rad, prismatic joints m].
  double length(const std::vector<Eigen::VectorXd>& path) const;
};

}  // namespace srmp
