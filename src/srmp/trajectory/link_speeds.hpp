#pragma once

#include <functional>
#include <span>
#include <vector>

#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/link_motion.hpp"
#include "srmp/trajectory/part_bound.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// Proves how fast links move, between rows too.
///
/// Over a part of a motion that takes the time d, the velocity of a point leaves the chord between its values at both
/// ends by no more than B d^2 / 8, where B bounds its second derivative (LinkChain::curvature); so the speed is no
/// larger than the larger one at the ends and that. Parts are halved until this is a small fraction of the largest
/// speed of the motion, or decides whether the limit is kept. The same holds for angular velocities. With scratch
/// memory: one thread uses it at a time.
class LinkSpeeds {
 public:
  /// As PartBound::fineness.
  static constexpr double fineness = PartBound::fineness;

  /// Without limits.
  LinkSpeeds() = default;
  /// Adds the limits of a robot whose joints are those from `first_joint` on in the motions. The model outlives this.
  /// Throws InvalidArgument for an unknown link, with the nearest name, and for one that no planned joint moves.
  void add(const RobotModel& robot, const Eigen::VectorXd& other_positions, const std::vector<LinkSpeedLimit>& limits,
           std::size_t first_joint = 0);

  bool empty() const { return links_.empty(); }
  /// The largest fraction of a limit that is used at q where the joints have these velocities.
  double use(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity);

  /// A motion in segments, along a cubic for each joint in each.
  struct Motion {
    std::size_t segments{};
    /// Writes the cubics of all joints of a segment, and returns when it begins [s].
    std::function<double(std::size_t segment, std::vector<detail::Cubic>& joints)> cubics{};
  };
  /// That of a trajectory, which outlives it.
  static Motion motion_of(const Trajectory& motion);
  /// Straight from a to b, which outlive it, at an even speed in this time [s].
  static Motion straight(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double time);
  /// What is proved of a motion: one for each limit, in the order in which they were added.
  std::vector<LinkSpeedUse> prove(const Motion& motion);
  std::vector<LinkSpeedUse> prove(const Trajectory& motion);
  /// The largest fraction of a limit that is proved of a motion.
  double use(const Motion& motion);
  double use(const Trajectory& motion);
  /// Of the straight motion from a to b in one second.
  double straight_use(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

 private:
  struct Link {
    const RobotModel* robot;
    Eigen::Index first, dof;  // joints
    std::size_t link;
    LinkSpeedLimit limit;
    RobotDataPtr data;
    LinkChain chain;
  };
  struct Sample {
    double time{}, speed{}, angular_speed{};
  };

  Sample sample(Link& link, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity, double time);
  Sample sample(Link& link, double time);
  void add_part(Link& link, const Sample& from, const Sample& to, double start, LinkSpeedUse& worst);

  std::vector<Link> links_;
  Eigen::MatrixXd jacobian_;
  std::vector<detail::Cubic> joints_;  // of the segment
};

/// Adds what is proved of the motion to its certificate, and faults where a limit is not kept.
void add_link_speeds(Certificate& certificate, const Trajectory& motion, LinkSpeeds& speeds, bool faults);

}  // namespace srmp
