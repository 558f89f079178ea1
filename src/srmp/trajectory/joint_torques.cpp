#include "srmp/trajectory/joint_torques.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

constexpr double torque_excess = 1e-6;  // of a limit
constexpr double torque_margin = 2e-3;  // of a limit, that motions that are slowed down keep
constexpr double least_slowdown = 1e-2;
constexpr int samples_of_slowdown = 4;  // of a segment, besides its begin

constexpr double motion_margin = 0.1;  // of a limit: searches leave as much for motion, except near ends without it
constexpr double hold_margin = 5e-3;   // of a limit, that is left where the robot is at rest, for motion
constexpr double long_time = 1e5;      // [s] in which a motion needs no torque but for holding

/// Bounds on the length of a vector and of its first four derivatives.
using Lengths = std::array<double, 5>;
constexpr double binomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};

/// The n-th derivative of a product of vectors, n <= 3.
double product(const Lengths& a, const Lengths& b, int n) {
  double sum = 0.0;
  for (int k = 0; k <= n; ++k) sum += binomial[n][k] * a[k] * b[n - k];
  return sum;
}

/// A vector of this length that turns with an angular velocity.
Lengths turning(double length, const Lengths& angular) {
  Lengths result{length};
  for (int n = 0; n < 4; ++n) result[n + 1] = product(angular, result, n);
  return result;
}

void operator+=(Lengths& a, const Lengths& b) {
  for (std::size_t n = 0; n < a.size(); ++n) a[n] += b[n];
}

/// Bounds of a body over a part of a motion.
struct BodyMotion {
  Lengths angular{};   // velocity
  Lengths position{};  // of its joint; the derivatives alone
  Lengths arm{};       // from its parent's joint
  Lengths axis{};      // of its joint
  Lengths lever{};     // to its centre of mass
  Lengths force{}, moment{};

  BodyMotion() = default;
  BodyMotion(const RobotDynamics::Body& body, const BodyMotion& parent, std::span<const detail::Cubic> joints,
             double from, double to)
      : angular(parent.angular),
        position(parent.position),
        arm(turning(body.offset, parent.angular)),
        axis(turning(1.0, parent.angular)) {
    const Lengths rates = body.joint ? rates_of(body, joints[*body.joint], from, to) : Lengths{};
    if (body.prismatic) {
      for (int n = 0; n < 4; ++n) arm[n] += product(rates, axis, n);
      // The fourth derivative: all terms, of which the joint's own fourth is 0.
      arm[4] += rates[0] * axis[4] + 4.0 * rates[1] * axis[3] + 6.0 * rates[2] * axis[2] + 4.0 * rates[3] * axis[1];
    } else {
      const Lengths speeds{rates[1], rates[2], rates[3], 0.0, 0.0};
      for (int n = 0; n < 4; ++n) angular[n] += product(speeds, axis, n);
    }
    position += arm;
    lever = turning(body.lever, angular);
    Lengths centre = position;
    centre += lever;
    force = {body.mass * (centre[2] + RobotDynamics::gravity), body.mass * centre[3], body.mass * centre[4]};
    Lengths inertia{body.inertia};
    for (int n = 0; n < 3; ++n) inertia[n + 1] = 2.0 * product(angular, inertia, n);
    for (int n = 0; n < 3; ++n) moment[n] = product(inertia, angular, n + 1);
  }

 private:
  /// Position and its derivatives of the body's own joint.
  static Lengths rates_of(const RobotDynamics::Body& body, const detail::Cubic& cubic, double from, double to) {
    const double ratio = std::abs(body.ratio), middle = (from + to) / 2.0, half = (to - from) / 2.0;
    const double acceleration = ratio * std::max(std::abs(cubic.acceleration(from)), std::abs(cubic.acceleration(to)));
    const double speed = ratio * std::abs(cubic.velocity(middle)) + acceleration * half;
    return {std::abs(body.ratio * cubic.position(middle) + body.shift) + speed * half, speed, acceleration,
            ratio * std::abs(cubic.jerk()), 0.0};
  }
};

}  // namespace

Eigen::VectorXd torque_curvature(const std::vector<RobotDynamics::Body>& bodies, std::span<const detail::Cubic> joints,
                                 double from, double to) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(joints.size()));
  std::vector<BodyMotion> motions(bodies.size());
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    motions[i] = BodyMotion(bodies[i], motions[bodies[i].parent], joints, from, to);
    if (bodies[i].mass == 0.0) continue;
    Lengths arm = motions[i].lever;  // from joint j to the centre of mass
    for (std::size_t j = i; j != 0; j = bodies[j].parent) {
      if (bodies[j].joint) {
        Lengths load = motions[i].force;
        if (!bodies[j].prismatic)
          for (int n = 0; n < 3; ++n) load[n] = product(arm, motions[i].force, n) + motions[i].moment[n];
        result[static_cast<Eigen::Index>(*bodies[j].joint)] +=
            std::abs(bodies[j].ratio) * product(motions[j].axis, load, 2);
      }
      arm += motions[j].arm;
    }
  }
  return result;
}

void JointTorques::add(const RobotModel& robot, const Pose& base, const Eigen::VectorXd& other_positions,
                       const MotionLimits& limits, std::size_t first_joint) {
  if (limits.torque.size() == 0) return;
  robots_.push_back({static_cast<Eigen::Index>(first_joint), static_cast<Eigen::Index>(robot.dof()), limits.torque,
                     robot.joint_names(), RobotDynamics(robot, base, other_positions, limits.payload)});
}

JointTorques::State JointTorques::state(const Arm& arm, double time) const {
  State state{Eigen::VectorXd(arm.dof), Eigen::VectorXd(arm.dof), Eigen::VectorXd(arm.dof)};
  for (Eigen::Index j = 0; j < arm.dof; ++j) {
    const detail::Cubic& cubic = joints_[static_cast<std::size_t>(arm.first + j)];
    state.q[j] = cubic.position(time);
    state.velocity[j] = cubic.velocity(time);
    state.acceleration[j] = cubic.acceleration(time);
  }
  return state;
}

JointTorques::Sample JointTorques::sample(Arm& arm, double time) {
  const auto [q, velocity, acceleration] = state(arm, time);
  return {time, arm.dynamics.torques(q, velocity, acceleration).cwiseAbs().cwiseQuotient(arm.limit)};
}

void JointTorques::add_part(Arm& arm, const Sample& from, const Sample& to, double start, LimitUse& worst) {
  const double time = to.time - from.time;
  const std::span<const detail::Cubic> joints(joints_.data() + arm.first, static_cast<std::size_t>(arm.dof));
  const Eigen::VectorXd curvature = torque_curvature(arm.dynamics.bodies(), joints, from.time, to.time);
  const auto bound = [&](Eigen::Index j) {
    return PartBound{std::max(from.use[j], to.use[j]), curvature[j] * time * time / 8.0 / arm.limit[j], 1.0};
  };
  bool known = true;
  for (Eigen::Index j = 0; j < arm.dof && known; ++j) known = bound(j).is_known_well(worst.fraction);
  if (known || time <= PartBound::smallest_part) {
    for (Eigen::Index j = 0; j < arm.dof; ++j) {
      if (bound(j).bound() > worst.fraction) worst.joint = arm.names[static_cast<std::size_t>(j)];
      bound(j).raise(worst.fraction, worst.time, start + (from.use[j] > to.use[j] ? from.time : to.time));
    }
    return;
  }
  const Sample middle = sample(arm, (from.time + to.time) / 2.0);
  add_part(arm, from, middle, start, worst);
  add_part(arm, middle, to, start, worst);
}

LimitUse JointTorques::prove(const LinkSpeeds::Motion& motion) {
  LimitUse worst;
  for (Arm& arm : robots_) {
    std::vector<std::pair<Sample, Sample>> ends(motion.segments);
    for (std::size_t i = 0; i < motion.segments; ++i) {  // first, so that parts with small torques need not be divided
      const double start = motion.cubics(i, joints_);
      ends[i] = {sample(arm, 0.0), sample(arm, joints_.front().h)};
      for (const Sample& end : {ends[i].first, ends[i].second})
        for (Eigen::Index j = 0; j < arm.dof; ++j)
          if (end.use[j] > worst.fraction)
            worst = {end.use[j], arm.names[static_cast<std::size_t>(j)], start + end.time};
    }
    for (std::size_t i = 0; i < motion.segments; ++i) {
      interruption_point();
      const double start = motion.cubics(i, joints_);
      add_part(arm, ends[i].first, ends[i].second, start, worst);
    }
  }
  return worst;
}

LimitUse JointTorques::prove(const Trajectory& motion) { return prove(LinkSpeeds::motion_of(motion)); }

double JointTorques::slowdown_at(Arm& arm, double time) {
  const auto [q, velocity, acceleration] = state(arm, time);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(arm.dof);
  const Eigen::VectorXd moving = arm.dynamics.torques(q, velocity, acceleration),
                        resting = arm.dynamics.torques(q, zero, zero);
  double squared = 1.0;
  for (Eigen::Index j = 0; j < arm.dof; ++j) {
    const double of_motion = moving[j] - resting[j];
    const double left = (1.0 - torque_margin) * arm.limit[j] - std::copysign(1.0, of_motion) * resting[j];
    if (left <= 0.0)
      throw Overload(arm.names[static_cast<std::size_t>(j)] + " needs " + to_text(std::abs(resting[j]) / arm.limit[j]) +
                     " of its torque limit to hold the robot at rest on the way");
    squared = std::max(squared, std::abs(of_motion) / left);
  }
  return std::sqrt(squared);
}

double JointTorques::slowdown(const LinkSpeeds::Motion& motion) {
  if (empty() || prove(motion).fraction <= 1.0 + torque_excess / 2.0) return 1.0;
  double factor = 1.0 + least_slowdown;
  for (Arm& arm : robots_)
    for (std::size_t i = 0; i < motion.segments; ++i) {
      motion.cubics(i, joints_);
      for (int k = 0; k <= samples_of_slowdown; ++k)
        factor = std::max(factor, slowdown_at(arm, joints_.front().h * k / samples_of_slowdown));
    }
  return factor;
}

double JointTorques::slowdown(const Trajectory& motion) { return slowdown(LinkSpeeds::motion_of(motion)); }

bool JointTorques::can_hold(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const double at_ends = std::max(holding(a).fraction, holding(b).fraction);
  const double allowed = std::min(std::max(1.0 - motion_margin, at_ends), 1.0 - hold_margin);
  return prove(LinkSpeeds::straight(a, b, long_time)).fraction <= allowed * (1.0 + PartBound::fineness);
}

LimitUse JointTorques::holding(const Eigen::VectorXd& q) {
  LimitUse worst;
  for (Arm& arm : robots_) {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(arm.dof);
    const Eigen::VectorXd torques = arm.dynamics.torques(q.segment(arm.first, arm.dof), zero, zero);
    for (Eigen::Index j = 0; j < arm.dof; ++j)
      if (const double use = std::abs(torques[j]) / arm.limit[j]; use > worst.fraction)
        worst = {use, arm.names[static_cast<std::size_t>(j)], 0.0};
  }
  return worst;
}

std::string JointTorques::overload(const Eigen::VectorXd& q) {
  const LimitUse use = holding(q);
  if (use.fraction <= 1.0 - hold_margin) return "";
  return use.joint + " needs " + to_text(use.fraction) + " of its torque limit to hold the robot there at rest";
}

void add_torques(Certificate& certificate, const Trajectory& motion, JointTorques& torques, bool faults) {
  certificate.torque = torques.prove(motion);
  if (!faults || certificate.torque.fraction <= 1.0 + torque_excess) return;
  certificate.faults.push_back({FaultKind::torque_limit,
                                certificate.torque.joint + ": the torque reaches up to " +
                                    to_text(certificate.torque.fraction) + " times its limit near " +
                                    to_text(certificate.torque.time) + " s",
                                certificate.torque.time});
}

void RobotBounds::add(const RobotModel& robot, const Pose& base, const Eigen::VectorXd& other_positions,
                      const MotionLimits& limits, std::size_t first_joint) {
  links.add(robot, other_positions, limits.link_speeds, first_joint);
  torques.add(robot, base, other_positions, limits, first_joint);
}

void RobotBounds::add(const PlacedRobot& robot, const MotionLimits& limits, std::size_t first_joint) {
  add(*robot.model, robot.base, robot.other_positions, limits, first_joint);
}

void RobotBounds::certify(Certificate& certificate, const Trajectory& motion, bool faults) {
  if (!links.empty()) add_link_speeds(certificate, motion, links, faults);
  if (!torques.empty()) add_torques(certificate, motion, torques, faults);
}

double RobotBounds::slowdown(const Trajectory& motion) {
  return std::max(links.empty() ? 0.0 : links.use(motion), torques.slowdown(motion));
}

void require_bounds_of_robot(const MotionLimits& limits, const RobotModel& robot) {
  if (!limits.link_speeds.empty()) LinkSpeeds().add(robot, robot.default_other_positions(), limits.link_speeds);
  if (limits.torque.size() > 0) RobotDynamics(robot, {}, robot.default_other_positions(), limits.payload);
}

bool need_robot(const MotionLimits& limits) { return !limits.link_speeds.empty() || limits.torque.size() > 0; }

}  // namespace srmp
