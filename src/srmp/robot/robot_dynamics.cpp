#include "srmp/robot/robot_dynamics.hpp"

#include <cmath>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_impl.hpp"

namespace srmp {

namespace {

pinocchio::SE3 to_se3(const Eigen::Isometry3d& pose) { return {pose.linear(), pose.translation()}; }

}  // namespace

struct RobotDynamics::Model {
  pinocchio::Model tree;
  pinocchio::Data data;
  Eigen::VectorXd q, velocity, acceleration;
  std::vector<Follower> planned;
  std::size_t dof{};

  Eigen::Index velocity_index(const Follower& f) const { return tree.joints[f.slot.joint].idx_v(); }
};

RobotDynamics::RobotDynamics(const RobotModel& robot, const Pose& base, const Eigen::VectorXd& other_positions,
                             const std::optional<Payload>& payload)
    : model_(std::make_unique<Model>()) {
  const RobotModelImpl& impl = *robot.impl_;
  Model& m = *model_;
  pinocchio::urdf::buildModelFromXML(impl.urdf.kinematics_text(), m.tree);
  const auto carry = [&](std::size_t link, const pinocchio::Inertia& inertia) {
    const KinematicTree::FixedPlacement& fixed = impl.tree->fixed_placement(link);
    m.tree.appendBodyToJoint(fixed.joint, inertia, to_se3(fixed.placement));
  };
  bool has_mass = false;
  for (std::size_t link = 0; link < impl.urdf.links.size(); ++link) {
    const std::optional<UrdfInertia>& own = impl.urdf.links[link].inertia;
    if (!own) continue;
    has_mass = true;
    const Eigen::Matrix3d rotation = own->origin.linear();
    carry(link, {own->mass, own->origin.translation(), rotation * own->inertia * rotation.transpose()});
  }
  if (!has_mass)
    throw InvalidArgument("the torques of robot '" + robot.name() +
                          "' cannot be limited: no link of its URDF has an <inertial> with a mass");
  if (payload)
    carry(robot.link_or_end_effector(payload->link),
          {payload->mass, payload->center_of_mass, Eigen::Matrix3d(payload->inertia.asDiagonal())});
  m.tree.gravity.linear(base.q.conjugate() * Eigen::Vector3d(0.0, 0.0, -gravity));
  m.data = pinocchio::Data(m.tree);
  m.q = pinocchio::neutral(m.tree);
  m.velocity = m.acceleration = Eigen::VectorXd::Zero(m.tree.nv);
  m.planned = impl.planned_followers;
  m.dof = robot.dof();

  bodies_.resize(static_cast<std::size_t>(m.tree.njoints));
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const pinocchio::Inertia& inertia = m.tree.inertias[i];
    bodies_[i] = {.parent = m.tree.parents[i],
                  .joint = std::nullopt,
                  .offset = m.tree.jointPlacements[i].translation().norm(),
                  .mass = inertia.mass(),
                  .lever = inertia.lever().norm(),
                  .inertia = inertia.inertia().matrix().norm()};
  }
  const Eigen::VectorXd& others = other_positions.size() ? other_positions : robot.default_other_positions();
  for (const Follower& f : impl.other_followers) {
    const double position = f.ratio * others[static_cast<Eigen::Index>(f.source)] + f.offset;
    KinematicTree::set(m.q, f.slot, position);
    bodies_[f.slot.joint].offset += std::abs(position);  // of prismatic joints; more than enough of others
  }
  for (std::size_t k = 0; k < m.planned.size(); ++k) {
    const Follower& f = m.planned[k];
    Body& body = bodies_[f.slot.joint];
    body.joint = f.source;
    body.ratio = f.ratio;
    body.shift = f.offset;
    body.prismatic = robot.actuated_joints()[k].prismatic;
  }
}

RobotDynamics::~RobotDynamics() = default;
RobotDynamics::RobotDynamics(RobotDynamics&&) noexcept = default;

Eigen::VectorXd RobotDynamics::torques(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                                       const Eigen::VectorXd& acceleration) {
  Model& m = *model_;
  for (const Follower& f : m.planned) {
    const auto joint = static_cast<Eigen::Index>(f.source);
    KinematicTree::set(m.q, f.slot, f.ratio * q[joint] + f.offset);
    m.velocity[m.velocity_index(f)] = f.ratio * velocity[joint];
    m.acceleration[m.velocity_index(f)] = f.ratio * acceleration[joint];
  }
  const Eigen::VectorXd& all = pinocchio::rnea(m.tree, m.data, m.q, m.velocity, m.acceleration);
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(m.dof));
  for (const Follower& f : m.planned) result[static_cast<Eigen::Index>(f.source)] += f.ratio * all[m.velocity_index(f)];
  return result;
}

}  // namespace srmp
