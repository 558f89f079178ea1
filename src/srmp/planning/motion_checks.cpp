#include "srmp/planning/motion_checks.hpp"

#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"

namespace srmp {

MotionChecks::MotionChecks(const Checker& checker, const Deadline& deadline, std::size_t workers,
                           const PlacedConstraints* constraints, const MotionLimits& limits)
    : checker_(checker) {
  for (std::size_t i = 0; i < workers; ++i) {
    workers_.push_back({checker.make_workspace()});
    if (constraints) workers_.back().constraints = std::make_unique<ConstraintChecker>(*constraints);
    if (limits.torque.size() == 0) continue;
    workers_.back().torques = std::make_unique<JointTorques>();
    workers_.back().torques->add(checker.robot(), checker.base(), checker.other_positions(), limits);
  }
  for (const Worker& worker : workers_) checker.stop_at(deadline, *worker.workspace);
}

std::string MotionChecks::violation(const Eigen::VectorXd& q) {
  Worker& w = workers_.front();
  const std::string broken = w.constraints ? w.constraints->violation(q) : "";
  return broken.empty() && w.torques ? w.torques->overload(q) : broken;
}

bool MotionChecks::keeps_rules(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker) {
  Worker& w = workers_[worker];
  if (w.constraints && !w.constraints->keeps(a, b, constraint_fractions.motions)) return false;
  return !w.torques || w.torques->can_hold(a, b);
}

bool MotionChecks::is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker) {
  if (!keeps_rules(a, b, worker)) return false;
  Worker& w = workers_[worker];
  const CheckStatistics& checks = checker_.statistics(*w.workspace);
  const std::uint64_t by_spheres = checks.motions_by_spheres;
  try {
    if (!checker_.is_motion_free(a, b, *w.workspace, {.start_is_free = true})) return false;
  } catch (const MotionCheckStopped&) {
    if (workers_.size() == 1) throw;
    w.stopped = true;  // threads must not throw
    return false;
  }
  ++w.free;
  w.free_by_spheres += checks.motions_by_spheres - by_spheres;
  return true;
}

void MotionChecks::require_not_stopped() const {
  for (const Worker& worker : workers_)
    if (worker.stopped) throw MotionCheckStopped();
}

void MotionChecks::write(PlanStatistics& statistics) const {
  statistics.configurations = statistics.narrow_phase = 0;
  statistics.edge_checks = statistics.edges_colliding_by_spheres = colliding_;
  statistics.edges_free_by_spheres = statistics.edges_free_by_coal = statistics.edges_colliding_by_coal = 0;
  for (const Worker& worker : workers_) {
    const CheckStatistics& checks = checker_.statistics(*worker.workspace);
    const std::uint64_t colliding_by_spheres = checks.motions_by_spheres - worker.free_by_spheres;
    statistics.edge_checks += checks.motions;
    statistics.edges_free_by_spheres += worker.free_by_spheres;
    statistics.edges_colliding_by_spheres += colliding_by_spheres;
    statistics.edges_free_by_coal += worker.free - worker.free_by_spheres;
    statistics.edges_colliding_by_coal += checks.motions - worker.free - colliding_by_spheres;
    statistics.configurations += checks.configurations;
    statistics.narrow_phase += checks.narrow_phase;
  }
}

}  // namespace srmp
