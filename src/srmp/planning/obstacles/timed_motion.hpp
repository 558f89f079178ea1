#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/prove_collision_free.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// [s] Steps of searches among moving robots, and between the samples of their collision checks: longer steps make
/// searches quicker and leave more collisions for the proof to find.
inline constexpr double time_step = 0.05;

/// Time from which on the robot is stationary [s]; 0 for a path without times.
double arrival_time(const Trajectory& trajectory);

/// A stationary robot: rows, which are all the same, evenly spread from time 0 to `duration` [s].
Trajectory stationary(const std::vector<std::string>& joints, const RowMatrix& rows, double duration);

/// The motion with a delayed start: stationary for `delay` [s] >= 0, then the motion.
Trajectory delayed(const Trajectory& motion, double delay);

/// Another robot whose motion is known; it is stationary before and after. Pointers outlive their users.
struct MovingRobot {
  const Checker* checker;        ///< of the planned robot and this one, and of nothing else: the quick one
  const Checker* exact_checker;  ///< the same pair by exact geometry (Coal) alone
  bool joints_first;             ///< does this robot stand before the planned one in the pair's configurations?
  const Trajectory* motion;      ///< begins at time 0
};

/// When the planned robot collides with another, or cannot be proved not to.
struct CollisionInterval {
  double from{}, to{};         ///< [s]; of a contact an instant, until CollisionMonitor::extended
  std::size_t other{};         ///< index of the other robot
  std::string body_a, body_b;  ///< as the exact checker names them
  bool contact{};              ///< false: no contact was found, but freedom could not be proved either
};

/// Verifies motions of the planned robot against those of the other robots. It counts its checks, so that a search with
/// a budget stops at the same place each time. Once the deadline has passed, nothing is proved.
class CollisionMonitor {
 public:
  /// How many checks a proof counts for: about as long as they take.
  static constexpr std::uint64_t checks_per_proof = 500;

  /// References outlive this.
  CollisionMonitor(const std::vector<MovingRobot>& other_robots, const Deadline& deadline);

  /// The first contact at samples of [from, to] [s], `time_step` apart: finds most collisions more quickly than a
  /// proof.
  std::optional<CollisionInterval> find_collision_at_samples(const Trajectory& motion, double from, double to);
  /// None: the motion is proved collision-free at all times, by exact geometry.
  std::optional<CollisionInterval> prove(const Trajectory& motion);
  /// Samples until all robots are stationary, and proves where no contact was found. None: proved collision-free.
  std::optional<CollisionInterval> find(const Trajectory& motion);
  /// The contact's whole duration around its instant, in steps of time_step / 4.
  CollisionInterval extended(const Trajectory& motion, CollisionInterval contact);

  std::uint64_t checks() const { return checks_; }  ///< of configurations, proofs included

 private:
  bool is_free(const Trajectory& motion, std::size_t other, double time);
  std::vector<Contact> contacts(const Trajectory& motion, std::size_t other, double time);
  Eigen::VectorXd configuration_of_both(const Trajectory& motion, std::size_t other, double time) const;
  double end(const Trajectory& motion, std::size_t other) const;

  const std::vector<MovingRobot>& other_robots_;
  const Deadline& deadline_;
  std::vector<Checker::WorkspacePtr> workspaces_;  // of the exact checkers
  std::uint64_t checks_{};
};

}  // namespace srmp
