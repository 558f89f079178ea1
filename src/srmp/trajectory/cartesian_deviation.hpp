#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/cartesian_path.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/link_motion.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Proves how far a link leaves a Cartesian path, between rows too.
///
/// A part of a motion that takes the time d is compared with the chord between its ends: with linear acceleration of
/// the link below A it leaves the chord by no more than A d^2 / 8, with angular acceleration below W by no more than
/// 0.38 W d^2; and a chord leaves a straight segment no more than its ends do (its rotation by 1 % more). Parts are
/// halved until these bounds are a small fraction of the tolerance. The accelerations are bounded by the joints'
/// velocities and accelerations and the farthest that the link can be from each joint's axis.
class CartesianDeviationProof {
 public:
  /// The path is in the robot's base frame; model, path and deadline outlive this. At the deadline, `over` throws
  /// PlanningError (timed_out, cancelled): the smaller the tolerance, the longer it takes.
  CartesianDeviationProof(const RobotModel& robot, const Eigen::VectorXd& other_positions, std::size_t link,
                          const CartesianPath& path, const CartesianTolerance& tolerance, const Deadline& deadline);

  /// Of the motion of all joints, each along its cubic, which take the same time. `segment` is where on the path it
  /// begins, and afterwards where it ends. The time is from the beginning of the cubics.
  CartesianDeviation over(std::span<const detail::Cubic> joints, std::size_t& segment);
  /// Is the straight joint-space motion from a to b proved to keep the tolerance? Takes less time than the deviation.
  bool keeps(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t segment);
  /// How far a joint-space motion of length 1 moves the link, at most [m].
  double max_travel() const { return chain_.travel().norm(); }
  /// How far it turns the link, at most [rad].
  double max_turn() const { return chain_.turn().norm(); }

 private:
  struct End {
    double time;
    Pose pose;
    CartesianPath::Miss miss;
  };
  struct Bound {
    double position, rotation;
  };
  CartesianTolerance fine() const { return fraction_of(fineness, tolerance_); }
  double ahead(const LinkChain::Bounds& motion, double time) const;
  End end_at(std::span<const detail::Cubic> joints, double time, std::size_t first, double ahead);
  End middle_of(std::span<const detail::Cubic> joints, const LinkChain::Bounds& motion, const End& from, const End& to);
  std::pair<End, End> ends_of(std::span<const detail::Cubic> joints, std::size_t segment);
  std::optional<Bound> bound_of(const LinkChain::Bounds& motion, const End& from, const End& to,
                                const CartesianTolerance& fine) const;
  void add_part(std::span<const detail::Cubic> joints, const End& from, const End& to, CartesianDeviation& sum);
  bool part_keeps(std::span<const detail::Cubic> joints, const End& from, const End& to);
  void set_straight(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

  static constexpr double fineness = 0.1;  // of the tolerance: what bounds between ends may add

  const RobotModel& robot_;
  const std::size_t link_;
  const CartesianPath& path_;
  const CartesianTolerance tolerance_;
  const Deadline& deadline_;
  std::uint64_t ends_{};  // that were looked at
  RobotDataPtr data_;
  const LinkChain chain_;
  Eigen::VectorXd q_;
  std::vector<detail::Cubic> straight_;
};

/// Over a whole trajectory, in the frame of the world. Throws PlanningError (timed_out, cancelled) at the deadline.
CartesianDeviation prove_cartesian_deviation(const Trajectory& trajectory, const PlacedRobot& robot,
                                             const std::string& link, const CartesianPath& path,
                                             const CartesianTolerance& tolerance, const Deadline& deadline);

}  // namespace srmp
