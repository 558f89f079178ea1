#include "srmp/collision/displacements.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace srmp::detail {

namespace {

/// How far a point with this velocity moves, along the direction if there is one.
double linear_of_point(const Eigen::Vector3d& velocity, const Eigen::Vector3d* direction) {
  return direction ? std::abs(velocity.dot(*direction)) : velocity.norm();
}

/// The same of all points within the radius of it.
double linear_of_sphere(const Eigen::Vector3d& velocity, const Eigen::Vector3d& turn, double radius,
                        const Eigen::Vector3d* direction) {
  const double of_center = linear_of_point(velocity, direction);
  if (!(radius > 0.0)) return of_center;
  return of_center + radius * (direction ? turn.cross(*direction).norm() : turn.norm());
}

}  // namespace

Displacements::Displacements(const SceneModel& model) : model_(model), joints_(model.group.actuated_joints().size()) {
  active_list_.reserve(joints_);
  speed_.resize(joints_);
  linear_.resize(joints_);
  rest_.resize(joints_);
  axes_.resize(joints_);
}

void Displacements::start_straight(const Eigen::VectorXd& delta) {
  const std::vector<ActuatedJoint>& actuated_joints = model_.group.actuated_joints();
  std::uint64_t active = 0;
  for (std::size_t k = 0; k < joints_; ++k) {
    linear_[k] = actuated_joints[k].ratio * delta[static_cast<Eigen::Index>(actuated_joints[k].joint)];
    speed_[k] = std::abs(linear_[k]);
    rest_[k] = 0.0;
    if (speed_[k] != 0.0) active |= std::uint64_t{1} << k;
  }
  start_any(active);
}

void Displacements::start_any(std::uint64_t active) {
  active_ = active;
  active_list_.clear();
  for (std::size_t k = joints_; k-- > 0;)  // children first
    if (active >> k & 1) active_list_.push_back(k);
}

void Displacements::limit(std::span<const double> change, std::span<const double> linear,
                          std::span<const double> rest) {
  for (std::size_t k : active_list_) {
    const ActuatedJoint& actuated = model_.group.actuated_joints()[k];
    speed_[k] = std::abs(actuated.ratio) * change[actuated.joint];
    linear_[k] = actuated.ratio * linear[actuated.joint];
    rest_[k] = std::abs(actuated.ratio) * rest[actuated.joint];
  }
}

void Displacements::place(const RobotGroup::Data& data) {
  const std::size_t moving = model_.bodies.moving.size() + model_.bodies.envelopes.size();
  for (std::size_t k : active_list_) axes_[k] = model_.group.actuated_joint_axis(data, k);
  chains_.resize(moving);
  arms_.resize(moving * joints_);  // not before: most motions are decided by spheres alone
  steps_.resize(moving * (joints_ + 1));
}

Displacements::Chain& Displacements::chain(std::size_t body, const Place& place) {
  Chain& chain = chains_[body];
  if (chain.placement != place.number) chain = {.placement = place.number};
  return chain;
}

const Displacements::Arm& Displacements::arm(std::size_t body, const Place& place, std::size_t joint) {
  Arm& arm = arms_[body * joints_ + joint];
  std::uint64_t& known = chain(body, place).arms;
  if (known >> joint & 1) return arm;
  known |= std::uint64_t{1} << joint;
  const auto& [point, axis] = axes_[joint];
  const Core& core = model_.bodies.moving_body(body).core;
  const Eigen::Vector3d center = place.center - point;
  arm.across = axis.cross(center);
  arm.center_reach = arm.across.norm();
  if (core.half.isZero(0.0)) {
    arm.reach = arm.center_reach + core.radius;
  } else {
    const Eigen::Vector3d half = place.pose.linear() * core.half;
    const auto from_axis = [&](const Eigen::Vector3d& end) { return end.cross(axis).norm(); };
    arm.reach = std::max(from_axis(center + half), from_axis(center - half)) + core.radius;
  }
  return arm;
}

/// Adds to `step`, of the deeper joints, what the joint moves.
void Displacements::add_joint(std::size_t joint, const Arm* arm, double half_width, Step& step) const {
  step.support |= std::uint64_t{1} << joint;
  const double change = speed_[joint] * half_width, linear = linear_[joint] * half_width;
  const Eigen::Vector3d& axis = axes_[joint].second;
  if (!arm) {
    step.velocity += linear * axis;
    step.center_rest += rest_[joint];
    step.rest += rest_[joint];
    step.center_sweep.moved += change;
    step.sweep.moved += change;
    return;
  }
  step.velocity += linear * arm->across;
  step.turn += linear * axis;
  step.center_rest += rest_[joint] * arm->center_reach;
  step.rest += rest_[joint] * arm->reach;
  step.center_sweep.add_turn(change, arm->center_reach);
  step.sweep.add_turn(change, arm->reach);
}

/// What the joints of `support` add up to, which move: the deepest ones of the body's chain, for every pair's.
const Displacements::Step& Displacements::sum(std::size_t body, const Place& place, std::uint64_t support,
                                              double half_width) {
  Chain& chain = this->chain(body, place);
  Step* steps = steps_.data() + body * (joints_ + 1);
  const auto begin = [&](double width) {
    chain.half_width = width;
    chain.steps = chain.next = 0;
  };
  const auto count = static_cast<std::uint32_t>(std::popcount(support));
  const auto go_on = [&](std::uint64_t among) {
    for (; chain.steps < count && chain.next < active_list_.size(); ++chain.next) {
      const std::size_t joint = active_list_[chain.next];
      if (!(among >> joint & 1)) continue;
      const Arm* own = model_.group.actuated_joints()[joint].prismatic ? nullptr : &arm(body, place, joint);
      steps[chain.steps + 1] = steps[chain.steps];
      add_joint(joint, own, half_width, steps[++chain.steps]);
    }
  };
  if (chain.half_width != half_width) begin(half_width);
  go_on(model_.bodies.moving_body(body).support);
  if (steps[count].support != support) {  // others: known for this call alone
    begin(-1.0);
    go_on(support);
  }
  return steps[count];
}

/// The smaller of two bounds. The first is what the joints add up to, from the deepest to the shallowest: each one
/// turns the body about the axis where it is now, since all that carries it stands still meanwhile, after the deeper
/// ones moved the body by `moved` at most. The other is that of Taylor's polynomial of first degree, which knows how
/// all joints move the body at once, and of its remainder: the second derivatives by two joints are no longer than the
/// distance from the axis of the deeper one.
double Displacements::of(std::size_t body, const Place& place, std::uint64_t support, double half_width,
                         const Eigen::Vector3d* direction) {
  support &= active_;
  if (support == 0) return 0.0;
  const Step& last = sum(body, place, support, half_width);
  const Core& core = model_.bodies.moving_body(body).core;
  double linear = 0.0;
  if (core.half.isZero(0.0)) {
    linear = linear_of_sphere(last.velocity, last.turn, core.radius, direction);
  } else {
    const Eigen::Vector3d at_end = last.turn.cross(place.pose.linear() * core.half);
    linear = direction ? std::abs(last.velocity.dot(*direction)) + std::abs(at_end.dot(*direction)) +
                             core.radius * last.turn.cross(*direction).norm()
                       : std::max((last.velocity + at_end).norm(), (last.velocity - at_end).norm()) +
                             core.radius * last.turn.norm();
  }
  return last.sweep.bound(linear + last.rest);
}

DirectedMotion Displacements::along(std::size_t body, const Place& place, std::uint64_t support, double half_width,
                                    const Eigen::Vector3d& direction) {
  support &= active_;
  if (support == 0) return {};
  const Step& last = sum(body, place, support, half_width);
  const Eigen::Vector3d slope = direction.cross(last.turn);
  return {last.velocity.dot(direction) - slope.dot(place.center), slope, last.rest + last.sweep.bent / 2.0};
}

double Displacements::of_center(std::size_t body, const Place& place, std::uint64_t support, double half_width,
                                const Eigen::Vector3d* direction) {
  support &= active_;
  if (support == 0) return 0.0;
  const Step& last = sum(body, place, support, half_width);
  return last.center_sweep.bound(linear_of_point(last.velocity, direction) + last.center_rest);
}

double Displacements::of_point(std::size_t body, const Place& place, std::uint64_t support,
                               const Eigen::Vector3d& offset, const Eigen::Vector3d* direction) {
  support &= active_;
  if (support == 0) return 0.0;
  const Step& last = sum(body, place, support, 1.0);
  return last.sweep.bound(linear_of_point(last.velocity + last.turn.cross(offset), direction) + last.rest);
}

/// The motion along a direction is a convex function of the point, so the corners bound it.
double Displacements::of(std::size_t body, const Place& place, std::uint64_t support, double half_width,
                         const Eigen::Vector3d& direction, std::span<const Eigen::Vector3d> part) {
  support &= active_;
  if (support == 0) return 0.0;
  const DirectedMotion motion = along(body, place, support, half_width, direction);
  double linear = 0.0;
  for (const Eigen::Vector3d& point : part) linear = std::max(linear, std::abs(motion.shift + motion.slope.dot(point)));
  return std::min(linear + motion.rest, sum(body, place, support, half_width).sweep.moved);
}

}  // namespace srmp::detail
