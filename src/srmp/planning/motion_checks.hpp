#pragma once

#include <cstdint>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

struct PlanStatistics;

/// The checks of one plan: scratch memory for each of its workers, and a count of the results. Throws
/// MotionCheckStopped as Checker::stop_at says, unless there are several workers, which must not throw.
class MotionChecks {
 public:
  /// Checker and deadline outlive it.
  MotionChecks(const Checker& checker, const Deadline& deadline, std::size_t workers);

  const Checker& checker() const { return checker_; }
  std::size_t workers() const { return workers_.size(); }
  Checker::Workspace& workspace(std::size_t worker = 0) { return *workers_[worker].workspace; }

  /// `a` is known to be free.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker = 0);
  /// Motions that the first worker checked.
  std::uint64_t motions() const { return checker_.statistics(*workers_.front().workspace).motions; }
  /// Throws MotionCheckStopped if any of several workers was stopped.
  void require_not_stopped() const;
  /// Into the fields that count edge checks.
  void write(PlanStatistics& statistics) const;

 private:
  struct Worker {
    Checker::WorkspacePtr workspace;
    std::uint64_t free{};  // motions
    std::uint64_t free_by_spheres{};
    bool stopped{};  // a check, by the deadline
  };

  const Checker& checker_;
  std::vector<Worker> workers_;
};

}  // namespace srmp
