#pragma once

#include <span>
#include <string>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_dynamics.hpp"
#include "srmp/trajectory/link_speeds.hpp"

namespace srmp {

/// No timing keeps the torque limits.
class Overload : public Error {
 public:
  using Error::Error;
};

/// Proves which torques the joints need, between rows too.
///
/// Over a part of a motion that takes the time d, a torque leaves the chord between its values at both ends by no more
/// than B d^2 / 8, where B bounds its second derivative: by the recursion of Newton and Euler, with the lengths of all
/// vectors and of their derivatives in place of the vectors. With scratch memory: one thread uses it at a time.
class JointTorques {
 public:
  /// Without limits.
  JointTorques() = default;
  /// Adds a robot with this base pose in the world, whose joints are those from `first_joint` on in the motions;
  /// nothing where `limits` has no torques. The model outlives this. Throws InvalidArgument as RobotDynamics.
  void add(const RobotModel& robot, const Pose& base, const Eigen::VectorXd& other_positions,
           const MotionLimits& limits, std::size_t first_joint = 0);

  bool empty() const { return robots_.empty(); }
  /// What is proved of a motion: the joint that uses the largest fraction of its limit.
  LimitUse prove(const LinkSpeeds::Motion& motion);
  LimitUse prove(const Trajectory& motion);
  /// By which factor a motion has to be slower to keep the limits, as far as can be told at once: 1 if it keeps them.
  /// Slower motions have torques nearer to those at rest. Throws Overload for a motion through a configuration at which
  /// a joint cannot hold the robot at rest.
  double slowdown(const LinkSpeeds::Motion& motion);
  double slowdown(const Trajectory& motion);
  /// Whether all joints can hold the robot at rest at every configuration of the straight motion from a to b: proved.
  bool can_hold(const Eigen::VectorXd& a, const Eigen::VectorXd& b);
  /// What is needed to hold the robot at rest at q.
  LimitUse holding(const Eigen::VectorXd& q);
  /// The joint that cannot hold the robot at rest at q, with what it needs, as the end of a sentence; "": all can.
  std::string overload(const Eigen::VectorXd& q);

 private:
  struct Arm {
    Eigen::Index first, dof;  // joints
    Eigen::VectorXd limit;    // [N m or N]; infinity: not limited
    std::vector<std::string> names;
    RobotDynamics dynamics;
  };
  struct Sample {
    double time{};
    Eigen::VectorXd use;  // of each joint's limit
  };
  struct State {
    Eigen::VectorXd q, velocity, acceleration;
  };

  State state(const Arm& arm, double time) const;
  Sample sample(Arm& arm, double time);
  void add_part(Arm& arm, const Sample& from, const Sample& to, double start, LimitUse& worst);
  double slowdown_at(Arm& arm, double time);

  std::vector<Arm> robots_;
  std::vector<detail::Cubic> joints_;  // of the segment
};

/// Bounds on the second derivatives of the torques (dof,) [N m/s^2 or N/s^2] of a robot whose joints follow these
/// cubics, between two times of them.
Eigen::VectorXd torque_curvature(const std::vector<RobotDynamics::Body>& bodies, std::span<const detail::Cubic> joints,
                                 double from, double to);

/// Adds what is proved of the motion to its certificate, and a fault where a torque is not kept.
void add_torques(Certificate& certificate, const Trajectory& motion, JointTorques& torques, bool faults);

/// What is proved of a motion with the robot at hand: how fast links move, and the torques of joints.
struct RobotBounds {
  LinkSpeeds links;
  JointTorques torques;

  /// Adds the limits of a robot whose joints are those from `first_joint` on.
  void add(const RobotModel& robot, const Pose& base, const Eigen::VectorXd& other_positions,
           const MotionLimits& limits, std::size_t first_joint = 0);
  void add(const PlacedRobot& robot, const MotionLimits& limits, std::size_t first_joint = 0);
  /// Adds what is proved of the motion to its certificate, and faults where a limit is not kept.
  void certify(Certificate& certificate, const Trajectory& motion, bool faults);
  /// By which factor a motion has to be slower: 1 or less if it keeps the limits.
  double slowdown(const Trajectory& motion);
};

/// Whether the limits need to know the robot.
bool need_robot(const MotionLimits& limits);

/// Throws InvalidArgument as RobotBounds::add does: for links that do not exist or do not move, and for torques of a
/// robot without masses.
void require_bounds_of_robot(const MotionLimits& limits, const RobotModel& robot);

}  // namespace srmp
