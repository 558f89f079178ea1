#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/problem.hpp"

namespace srmp {

/// The straight beginning of the motion of a robot whose start is in motion: to RobotProblem::start, where it can stop,
/// and from where the path is searched. References outlive this.
class LeadOutOfMotion {
 public:
  /// Of the problem's only robot.
  LeadOutOfMotion(const PlanProblem& problem, const Deadline& deadline);

  /// Throws PlanningError with Status::start_invalid, and what is in the way, when the robot cannot stop straight
  /// ahead.
  void require_free();
  /// The whole path with this one, which begins at RobotProblem::start: a stop there, and, where that is free, turns
  /// that are farther ahead, which can be rounded at a higher speed.
  std::vector<RowMatrix> followed_by(const RowMatrix& waypoints);

 private:
  Eigen::VectorXd ahead(double lead) const { return begin_.position + lead * (task_.start - begin_.position); }
  std::string violation(const Eigen::VectorXd& q);
  bool is_motion_free(const Eigen::VectorXd& from, const Eigen::VectorXd& to);
  std::string reason();

  const RobotProblem& task_;
  const StartInMotion& begin_;
  const Checker& checker_;
  Checker::WorkspacePtr workspace_;
  std::optional<ConstraintChecker> constraints_;
};

}  // namespace srmp
