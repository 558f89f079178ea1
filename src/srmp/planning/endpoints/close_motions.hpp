#pragma once

#include <string>
#include <vector>

#include "srmp/planning/group_checkers.hpp"

namespace srmp {

/// Motions of one robot near an end that is closer to something than CommonOptions::clearance, where the clearance is
/// relaxed: on the way from there, no pair that is closer comes closer still, and none that keeps the clearance gives
/// it up (the rule of start_recovery.hpp). With the scratch memory of one thread.
class CloseMotions {
 public:
  /// Checkers that have a clearance, and the deadline, outlive this. Throws MotionCheckStopped as Checker::stop_at.
  CloseMotions(const ProblemCheckers& checkers, const Deadline& deadline);

  /// Whether the clearance is kept at q.
  bool is_clear(const Eigen::VectorXd& q) { return clearance_.is_free(q, *with_clearance_); }
  /// Whether nothing touches at q.
  bool is_free(const Eigen::VectorXd& q) { return contacts_.is_free(q, *of_contacts_); }
  /// Whether the straight joint-space motion keeps the rule on the way from a, at samples, and is proved free.
  bool withdraws(const Eigen::VectorXd& a, const Eigen::VectorXd& b);
  /// The pair that breaks the rule along a path from its first configuration on, as the end of a sentence; "": none.
  std::string approach(const std::vector<Eigen::VectorXd>& path);
  /// What touches or is too close at q, as the end of a sentence; "": nothing.
  std::string closeness(const Eigen::VectorXd& q);

 private:
  const Checker &clearance_, &contacts_;
  const Checker::WorkspacePtr with_clearance_, of_contacts_;
};

}  // namespace srmp
