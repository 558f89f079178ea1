#include "srmp/planning/endpoints/start_in_motion.hpp"

#include <array>

#include "srmp/core/error.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

/// What LeadOutOfMotion tries.
struct LeadOptions {
  /// As multiples of the distance to RobotProblem::start: more of them find faster motions and take longer.
  std::array<double, 3> farther{1.25, 1.5, 2.0};
  int samples_of_reason{64};  ///< of the motion ahead: the first that is invalid says why the robot cannot stop
};
const LeadOptions tuning;

}  // namespace

LeadOutOfMotion::LeadOutOfMotion(const PlanProblem& problem, const Deadline& deadline)
    : task_(problem.robots.front()),
      begin_(*task_.start_in_motion),
      checker_(problem.checkers.planning.alone(0)),
      workspace_(checker_.make_workspace()) {
  checker_.stop_at(deadline, *workspace_);
  if (task_.constraints) constraints_.emplace(*task_.constraints);
}

void LeadOutOfMotion::require_free() {
  try {
    const std::string why = violation(begin_.position);
    if (!why.empty()) throw PlanningError(Status::start_invalid, "the start is invalid: " + why);
    if (violation(task_.start).empty() && is_motion_free(begin_.position, task_.start)) return;
    throw PlanningError(Status::start_invalid,
                        "the robot cannot stop straight ahead of its start velocity: " + reason());
  } catch (const MotionCheckStopped&) {
    throw PlanningError(Status::timed_out, "the time limit passed while the stop from the start velocity was checked");
  }
}

std::vector<RowMatrix> LeadOutOfMotion::followed_by(const RowMatrix& waypoints) {
  RowMatrix whole(waypoints.rows() + 1, waypoints.cols());
  whole << begin_.position.transpose(), waypoints;
  std::vector<RowMatrix> paths{whole};
  if (waypoints.rows() < 2) return paths;
  const Eigen::VectorXd next = waypoints.row(1).transpose();
  try {
    for (const double lead : tuning.farther) {
      const Eigen::VectorXd turn = ahead(lead);
      if (!violation(turn).empty() || !is_motion_free(task_.start, turn)) break;
      if (!is_motion_free(turn, next)) continue;
      whole.row(1) = turn.transpose();
      paths.push_back(whole);
    }
  } catch (const MotionCheckStopped&) {  // what was found by then will do
  }
  return paths;
}

std::string LeadOutOfMotion::violation(const Eigen::VectorXd& q) {
  const std::string broken = constraints_ ? constraints_->violation(q) : "";
  return broken.empty() ? invalidity(checker_, q, *workspace_) : broken;
}

bool LeadOutOfMotion::is_motion_free(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  if (constraints_ && !constraints_->keeps(from, to, 1.0)) return false;
  return checker_.is_motion_free(from, to, *workspace_);
}

std::string LeadOutOfMotion::reason() {
  for (int i = 1; i <= tuning.samples_of_reason; ++i) {
    const std::string why = violation(ahead(static_cast<double>(i) / tuning.samples_of_reason));
    if (!why.empty()) return why;
  }
  return "it would pass something too closely";
}

}  // namespace srmp
