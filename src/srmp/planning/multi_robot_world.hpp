#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "srmp/lattice/lattice.hpp"
#include "srmp/multi/world.hpp"
#include "srmp/planning/group_checkers.hpp"
#include "srmp/planning/motion_checks.hpp"

namespace srmp {

/// What a robot is to do, found for it alone.
struct WorldTask {
  Eigen::VectorXd start;                 ///< free
  std::vector<Eigen::VectorXd> targets;  ///< free
  std::vector<Eigen::VectorXd>
      single_robot_path;  ///< a free path from start to a target that leads the search; may be empty
  std::vector<std::vector<Eigen::VectorXd>> alternatives{};  ///< other such paths
  bool anywhere{};                                           ///< every configuration is a goal
  /// Of its lattice; none: rich_primitives at the world's resolution.
  std::optional<PrimitiveSet> primitives{};
  std::shared_ptr<const PlacedConstraints> constraints{};  ///< that its path keeps; null: none
  MotionLimits limits{};                                   ///< whose torques can hold the robot all along its path
};

/// Robots on their lattices, in discrete time: a move takes the steps that its slowest joint needs at full speed.
///
/// Threads may share it, each with robots of its own: lattices grow, and so does what is known of a robot's motions.
/// Any thread may query conflicts of two robots, and what never changes: robots, tasks, durations.
class MultiRobotWorld : public multi::World {
 public:
  struct Options {
    double resolution{};            ///< lattice step of revolute joints [rad]
    double prismatic_resolution{};  ///< [m]
    double scale{1.0};              ///< the lattices' own primitives have steps of so many times the resolution
    /// Edges lead to a few waypoints of the single-robot path from each state, not to all.
    bool sparse{};
    /// Robots conflict wherever spheres do not prove them apart, but for moves from a start or to a goal: where the
    /// robots must be, it matters how near they are exactly; elsewhere spheres are quicker.
    bool by_spheres{};
  };

  /// References outlive this. One task a robot, in the order of the checkers' names.
  MultiRobotWorld(const GroupCheckers& checkers, std::vector<WorldTask> tasks, const Options& options);
  ~MultiRobotWorld() override;

  std::size_t size() const override { return agents_.size(); }
  multi::Agent& agent(std::size_t i) override;
  bool may_conflict(std::size_t a, std::size_t b) const override { return checkers_.may_conflict(a, b); }
  bool in_conflict(std::size_t a, const multi::Move& move_a, std::size_t b, const multi::Move& move_b) override;

  /// Where the robot is at a step of its move.
  Eigen::VectorXd at(std::size_t robot, const multi::Move& move, int step) const;
  const RobotModel& model(std::size_t robot) const { return checkers_.alone(robot).robot(); }
  /// From now on nothing is free, or proved apart, once the deadline has passed and checking takes long. It must
  /// outlive this, or the next call.
  void stop_at(const Deadline& deadline);
  /// Has that deadline passed? Then checks may have been cut off, and their results are not to be remembered.
  bool is_stopped() const { return deadline_ && deadline_->expired(); }
  double step_time() const { return step_time_; }  ///< [s] at full speed
  bool has_own_primitives() const;                 ///< has any task?
  /// Steps that a straight motion takes, > 0.
  int duration(std::size_t robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;
  /// Full turns added to continuous joints, so that every row follows the one before by the short way.
  RowMatrix unwrapped(std::size_t robot, ConstRows rows) const;
  const WorldTask& task(std::size_t robot) const;
  double alone(std::size_t robot) const;   ///< length of its path as if it were alone [rad, prismatic joints m]
  double direct(std::size_t robot) const;  ///< straight from its start to its nearest goal: no path is shorter
  const Options& options() const { return options_; }
  const GroupCheckers& checkers() const { return checkers_; }

  /// Are two straight motions at the same time free of collisions with each other?
  bool are_collision_free(std::size_t a, const Eigen::VectorXd& from_a, const Eigen::VectorXd& to_a, std::size_t b,
                          const Eigen::VectorXd& from_b, const Eigen::VectorXd& to_b, const MotionQuery& query = {});
  /// Of each point of b: are the two surely collision-free when a is at q? By spheres alone: quick, and never true
  /// wrongly.
  std::vector<char> collision_free_with(std::size_t a, const Eigen::VectorXd& q, std::size_t b,
                                        std::span<const Eigen::VectorXd> points);
  bool is_free_for_one(std::size_t robot, const Eigen::VectorXd& q);
  /// A straight motion from where it is free. With path constraints: is it proved to keep this fraction of them, too?
  bool is_free_for_one(std::size_t robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                       double of_tolerances = constraint_fractions.motions);

  std::uint64_t pair_checks() const;  ///< motions of two robots that were checked
  std::uint64_t states() const;
  std::size_t memory() const;  ///< bytes of the lattices and of what is known of motions and pairs of them

 private:
  class RobotAgent;
  class Pair;
  /// Of a < b; null: they never conflict.
  Pair* pair(std::size_t a, std::size_t b) const;

  const GroupCheckers& checkers_;
  Options options_;
  std::vector<std::unique_ptr<RobotAgent>> agents_;
  std::map<std::pair<std::size_t, std::size_t>, std::unique_ptr<Pair>> pairs_;
  double step_time_{};
  const Deadline* deadline_{};
};

}  // namespace srmp
