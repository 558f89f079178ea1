// RobotModel::end_effectors: what an SRDF says about grippers, and how far their fingers open.
#include <algorithm>
#include <cmath>

#include "srmp/robot/robot_impl.hpp"

namespace srmp {

namespace {

using FingerImpl = RobotModelImpl;

/// A joint that slides with `source`: along the axis, at ratio * position + offset.
struct Finger {
  const UrdfJoint* joint;
  std::size_t source;
  double ratio, offset;
  Eigen::Vector3d axis;  // in the frame of the parent link

  double at(double position) const { return ratio * position + offset; }
};

Eigen::Vector3d axis_in_parent(const UrdfJoint& joint) {
  const auto about = [](double angle, const Eigen::Vector3d& axis) { return Eigen::AngleAxisd(angle, axis); };
  return about(joint.rpy[2], Eigen::Vector3d::UnitZ()) * about(joint.rpy[1], Eigen::Vector3d::UnitY()) *
         about(joint.rpy[0], Eigen::Vector3d::UnitX()) * joint.axis;
}

/// The joints that move with the sources, as fingers; empty: they are not two that slide along one line.
std::vector<Finger> fingers_of(const Urdf& urdf, const std::vector<std::size_t>& sources) {
  std::vector<Finger> fingers;
  for (const std::size_t index : urdf.joint_order) {
    const UrdfJoint& joint = urdf.joints[index];
    if (!joint.scalar()) continue;
    const UrdfMimic mimic = joint.mimic.value_or(UrdfMimic{index, 1.0, 0.0});
    if (std::find(sources.begin(), sources.end(), mimic.source) == sources.end()) continue;
    if (joint.type != UrdfJointType::prismatic) return {};
    fingers.push_back({&joint, mimic.source, mimic.multiplier, mimic.offset, axis_in_parent(joint)});
  }
  if (fingers.size() != 2 || fingers[0].joint->parent != fingers[1].joint->parent) return {};
  if (std::abs(std::abs(fingers[0].axis.dot(fingers[1].axis)) - 1.0) > 1e-6) return {};
  return fingers;
}

/// How far the second finger is from the first, along the first one's axis.
double separation(const std::vector<Finger>& fingers, double first, double second) {
  const Eigen::Vector3d& along = fingers[0].axis;
  return along.dot(fingers[1].joint->xyz - fingers[0].joint->xyz) + along.dot(fingers[1].axis) * fingers[1].at(second) -
         fingers[0].at(first);
}

/// With both at limits of their joints. Nothing: the fingers pass each other, or move in the same direction.
std::optional<GripperOpening> opening_of(const Urdf& urdf, const std::vector<std::size_t>& sources) {
  constexpr double rounding = 1e-9;  // [m]
  const std::vector<Finger> fingers = fingers_of(urdf, sources);
  if (fingers.empty()) return std::nullopt;
  const UrdfJoint &a = urdf.joints[fingers[0].source], &b = urdf.joints[fingers[1].source];
  struct Ends {
    double first, second, separation;
  };
  std::vector<Ends> corners;
  for (const double first : {a.lower, a.upper})
    for (const double second : {b.lower, b.upper})
      if (&a != &b || first == second) corners.push_back({first, second, separation(fingers, first, second)});
  const auto less = [](const Ends& x, const Ends& y) { return x.separation < y.separation; };
  Ends closed = *std::min_element(corners.begin(), corners.end(), less);
  Ends opened = *std::max_element(corners.begin(), corners.end(), less);
  if (closed.separation < -rounding && opened.separation > rounding) return std::nullopt;
  if (opened.separation <= rounding) std::swap(closed, opened);
  const double width = std::abs(opened.separation - closed.separation);
  const double by_first = std::abs(fingers[0].at(opened.first) - fingers[0].at(closed.first));
  const double by_second = std::abs(fingers[1].at(opened.second) - fingers[1].at(closed.second));
  const bool opposed = std::abs(by_first + by_second - width) <= rounding && by_first > 0.0 && by_second > 0.0;
  if (!opposed || !std::isfinite(width)) return std::nullopt;
  return GripperOpening{
      width, {{a.name, closed.first}, {b.name, closed.second}}, {{a.name, opened.first}, {b.name, opened.second}}};
}

std::map<std::string, std::map<std::string, double>> states_of(const FingerImpl& impl, const Srdf& srdf,
                                                               const SrdfEndEffector& effector) {
  std::map<std::string, std::map<std::string, double>> states;
  for (const SrdfState& state : srdf.states) {
    if (state.group != effector.group) continue;
    std::map<std::string, double> positions;
    for (const auto& [name, value] : state.positions) {
      const UrdfJoint& joint = impl.urdf.joints[*impl.urdf.find_joint(name)];
      if (joint.scalar() && !joint.mimic) positions.emplace(name, value);
    }
    if (!positions.empty()) states.emplace(state.name, std::move(positions));
  }
  return states;
}

}  // namespace

void RobotModelBuilder::list_end_effectors(Impl& m, const Srdf& srdf) {
  for (const SrdfEndEffector& effector : srdf.end_effectors) {
    EndEffector result{.name = effector.name,
                       .link = effector.parent_link,
                       .group = effector.group,
                       .parent_group = effector.parent_group,
                       .joints = {},
                       .states = states_of(m, srdf, effector),
                       .opening = std::nullopt};
    const SrdfGroup* group = srdf.find_group(effector.group);
    if (group && group->fault.empty()) {
      const std::vector<std::size_t> joints = srdf.joints_of(*group, m.urdf);
      for (const std::size_t joint : joints) result.joints.push_back(m.urdf.joints[joint].name);
      if (!joints.empty()) result.opening = opening_of(m.urdf, joints);
    }
    m.end_effectors.push_back(std::move(result));
  }
}

}  // namespace srmp
