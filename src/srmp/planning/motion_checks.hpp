#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"
#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

struct PlanStatistics;

/// How much of the tolerance of path constraints a search uses; the rest is for what comes after it.
struct ConstraintFractions {
  double configurations{0.6};  ///< to which configurations are projected
  double motions{0.85};        ///< that motions between them keep; the rounding of corners has the rest
};
inline constexpr ConstraintFractions constraint_fractions;

/// The checks of one plan: scratch memory for each of its workers, and a count of the results. Throws
/// MotionCheckStopped as Checker::stop_at says, unless there are several workers, which must not throw.
class MotionChecks {
 public:
  /// Checker, deadline and constraints outlive it; null: there are no constraints. `limits`: whose torques the robot
  /// can keep at rest.
  MotionChecks(const Checker& checker, const Deadline& deadline, std::size_t workers,
               const PlacedConstraints* constraints, const MotionLimits& limits);

  const Checker& checker() const { return checker_; }
  std::size_t workers() const { return workers_.size(); }
  Checker::Workspace& workspace(std::size_t worker = 0) { return *workers_[worker].workspace; }

  /// Path constraints, for the calling thread alone; null: there are none.
  ConstraintChecker* constraints() { return workers_.front().constraints.get(); }

  /// Why the robot cannot be at q, of what checkers do not know: the path constraint that it breaks, or the joint that
  /// cannot hold it there, as the end of a sentence; "": it can.
  std::string violation(const Eigen::VectorXd& q);

  /// Of what checkers do not know: with torque limits, whether the joints can hold the robot all along; with path
  /// constraints, whether the motion is proved to keep them, to the fraction that searches may use.
  bool keeps_rules(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker = 0);
  /// That, and whether the motion is free. `a` is known to be free.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker = 0);
  /// Are there rules (keeps_rules)? What breaks them is not counted as a check.
  bool has_rules() const { return workers_.front().constraints || workers_.front().torques; }
  /// Which rows of q (n x dof), the ends of motions, are seen to be in contact with little work. By the first worker.
  void find_colliding(ConstRows q, std::span<bool> colliding) {
    checker_.find_colliding(q, colliding, *workers_.front().workspace);
  }
  /// Counts a motion to one of these, which needs no check.
  void count_colliding() { ++colliding_; }
  /// Motions that the first worker checked.
  std::uint64_t motions() const { return checker_.statistics(*workers_.front().workspace).motions + colliding_; }
  /// Throws MotionCheckStopped if any of several workers was stopped.
  void require_not_stopped() const;
  /// Into the fields that count edge checks.
  void write(PlanStatistics& statistics) const;

 private:
  struct Worker {
    Checker::WorkspacePtr workspace;
    std::unique_ptr<ConstraintChecker> constraints{};
    std::unique_ptr<JointTorques> torques{};  // null: none is limited
    std::uint64_t free{};                     // motions
    std::uint64_t free_by_spheres{};
    bool stopped{};  // a check, by the deadline
  };

  const Checker& checker_;
  std::vector<Worker> workers_;
  std::uint64_t colliding_{};  // motions, by their ends
};

}  // namespace srmp
