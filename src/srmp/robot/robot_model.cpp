#include "srmp/robot/robot_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "srmp/core/error.hpp"
#include "srmp/core/run_interruptibly.hpp"
#include "srmp/robot/joint_names.hpp"
#include "srmp/robot/robot_impl.hpp"

namespace srmp {

RobotModel::RobotModel() : impl_(std::make_unique<RobotModelImpl>()) {}
RobotModel::~RobotModel() = default;
void RobotDataDeleter::operator()(RobotData* data) const { delete data; }

std::shared_ptr<const RobotModel> RobotModel::load(const RobotDescription& description) {
  return run_interruptibly(
      [description] { return std::shared_ptr<const RobotModel>(RobotModelBuilder::build(description)); });
}

const std::string& RobotModel::name() const { return impl_->name; }
const RobotDescription& RobotModel::description() const { return impl_->description; }
const RobotDescription& RobotModel::self_contained_description() const { return impl_->self_contained; }
const std::vector<std::string>& RobotModel::warnings() const { return impl_->warnings; }
const std::vector<Joint>& RobotModel::joints() const { return impl_->joints; }
const std::vector<std::string>& RobotModel::joint_names() const { return impl_->joint_names; }
const std::vector<Joint>& RobotModel::other_joints() const { return impl_->other_joints; }
const Eigen::VectorXd& RobotModel::default_other_positions() const { return impl_->default_other_positions; }
const std::map<std::string, Eigen::VectorXd>& RobotModel::group_states() const { return impl_->group_states; }
const std::map<std::string, std::vector<std::string>>& RobotModel::groups() const { return impl_->groups; }
const std::optional<VirtualJoint>& RobotModel::virtual_joint() const { return impl_->virtual_joint; }
const std::vector<std::string>& RobotModel::link_names() const { return impl_->link_names; }
const std::string& RobotModel::end_effector() const { return impl_->end_effector; }
const std::vector<std::string>& RobotModel::end_links() const { return impl_->end_links; }
const std::vector<EndEffector>& RobotModel::end_effectors() const { return impl_->end_effectors; }
const std::vector<LinkGeometry>& RobotModel::geometries() const { return impl_->geometries; }
const std::vector<ActuatedJoint>& RobotModel::actuated_joints() const { return impl_->actuated_joints; }
const std::vector<std::pair<std::size_t, std::size_t>>& RobotModel::self_pairs() const { return impl_->self_pairs; }
const std::vector<std::pair<std::string, std::string>>& RobotModel::always_colliding() const {
  return impl_->always_colliding;
}

std::size_t RobotModel::link_or_end_effector(const std::string& link) const {
  if (!link.empty()) return link_index(link);
  if (end_links().size() == 1) return impl_->end_effector_index;
  throw InvalidArgument("robot '" + name() + "' was given no end effector, and its planned joints move several: name " +
                        "the link, such as " + quoted_list(end_links()));
}

std::size_t RobotModel::link_index(const std::string& link) const {
  const auto& names = impl_->link_names;
  const auto it = std::find(names.begin(), names.end(), link);
  if (it == names.end())
    throw InvalidArgument("robot '" + name() + "' has no link '" + link + "'" + did_you_mean(link, names));
  return static_cast<std::size_t>(it - names.begin());
}

std::uint64_t RobotModel::link_support(std::size_t link_index) const {
  return impl_->joint_support[impl_->tree->fixed_placement(link_index).joint];
}

bool RobotModel::allowed(const std::string& link_a, const std::string& link_b) const {
  return impl_->is_allowed(link_index(link_a), link_index(link_b));
}

// --- kinematics

RobotDataPtr RobotModel::make_data() const {
  RobotDataPtr data(new RobotData);
  data->tree = impl_->tree->make_data();
  data->joint_poses.assign(impl_->tree->joint_count(), Eigen::Isometry3d::Identity());
  set_other_positions(*data, default_other_positions());
  forward(*data, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dof())));
  return data;
}

void RobotModel::set_other_positions(RobotData& data, ConstVector positions) const {
  if (positions.size() != static_cast<Eigen::Index>(other_joints().size()))
    throw InvalidArgument("robot '" + name() + "' has " + std::to_string(other_joints().size()) +
                          " other joints, got " + std::to_string(positions.size()) + " positions");
  data.others_moved = true;
  for (const Follower& f : impl_->other_followers)
    KinematicTree::set(*data.tree, f.slot, f.ratio * positions[static_cast<Eigen::Index>(f.source)] + f.offset);
}

void RobotModel::forward(RobotData& data, ConstVector q) const {
  for (const Follower& f : impl_->planned_followers)
    KinematicTree::set(*data.tree, f.slot, f.ratio * q[static_cast<Eigen::Index>(f.source)] + f.offset);
  if (std::exchange(data.others_moved, false))
    impl_->tree->forward(*data.tree, data.joint_poses);
  else
    impl_->tree->forward(*data.tree, data.joint_poses, impl_->moving_joints);
}

Eigen::Isometry3d RobotModel::geometry_pose(const RobotData& data, std::size_t geometry) const {
  const KinematicTree::FixedPlacement& fixed = impl_->geometry_placements[geometry];
  return data.joint_poses[fixed.joint] * fixed.placement;
}

Eigen::Isometry3d RobotModel::link_pose(const RobotData& data, std::size_t link_index) const {
  const KinematicTree::FixedPlacement& fixed = impl_->tree->fixed_placement(link_index);
  return data.joint_poses[fixed.joint] * fixed.placement;
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> RobotModel::actuated_joint_axis(const RobotData& data,
                                                                            std::size_t k) const {
  const Follower& f = impl_->planned_followers[k];
  const Eigen::Isometry3d& pose = data.joint_poses[f.slot.joint];
  return {pose.translation(), pose.linear() * f.axis};
}

void RobotModel::jacobian(const RobotData& data, std::size_t link_index, Eigen::Ref<Eigen::MatrixXd> result) const {
  const Eigen::Vector3d origin = link_pose(data, link_index).translation();
  const std::uint64_t support = link_support(link_index);
  result.setZero();
  for (std::size_t k = 0; k < actuated_joints().size(); ++k) {
    if (!(support >> k & 1)) continue;
    const auto [point, axis] = actuated_joint_axis(data, k);
    const ActuatedJoint& actuated = actuated_joints()[k];
    auto column = result.col(static_cast<Eigen::Index>(actuated.joint));
    if (actuated.prismatic) {
      column.head<3>() += actuated.ratio * axis;
    } else {
      column.head<3>() += actuated.ratio * axis.cross(origin - point);
      column.tail<3>() += actuated.ratio * axis;
    }
  }
}

RobotDataPtr RobotModel::make_data(ConstVector other_positions) const {
  RobotDataPtr data = make_data();
  if (other_positions.size() > 0) set_other_positions(*data, other_positions);
  return data;
}

Pose RobotModel::compute_fk(ConstVector q, const std::string& link, const Eigen::VectorXd& other_positions) const {
  require_configuration(q, "configuration");
  const std::size_t index = link.empty() ? impl_->end_effector_index : link_index(link);
  const RobotDataPtr data = make_data(other_positions);
  forward(*data, q);
  return Pose::from_isometry(link_pose(*data, index));
}

Eigen::MatrixXd RobotModel::compute_jacobian(ConstVector q, const std::string& link,
                                             const Eigen::VectorXd& other_positions) const {
  require_configuration(q, "configuration");
  const std::size_t index = link.empty() ? impl_->end_effector_index : link_index(link);
  const RobotDataPtr data = make_data(other_positions);
  forward(*data, q);
  Eigen::MatrixXd result(6, static_cast<Eigen::Index>(dof()));
  jacobian(*data, index, result);
  return result;
}

// --- configurations

namespace {

const char* unit(JointKind kind) { return kind == JointKind::prismatic ? " m" : " rad"; }

}  // namespace

void RobotModel::require_configuration(ConstVector q, std::string_view what) const {
  if (q.size() != static_cast<Eigen::Index>(dof()))
    throw InvalidArgument(std::string(what) + " has " + std::to_string(q.size()) + " values; robot '" + name() +
                          "' has " + std::to_string(dof()) + " planned joints: " + quoted_list(joint_names()));
  require_finite({q.data(), static_cast<std::size_t>(q.size())}, what, joint_names());
}

void RobotModel::refuse_joint(const std::string& joint) const { throw InvalidArgument(why_not_a_joint(*impl_, joint)); }

std::optional<std::string> RobotModel::limit_violation(ConstVector q, double tolerance) const {
  for (std::size_t i = 0; i < dof(); ++i) {
    const Joint& joint = joints()[i];
    const double value = q[static_cast<Eigen::Index>(i)];
    const bool below = value<joint.lower - tolerance, above = value> joint.upper + tolerance;
    if (!below && !above) continue;
    return joint.name + ": " + to_text(value) + unit(joint.kind) + " is " +
           (below ? "below the lower limit " + to_text(joint.lower) : "above the upper limit " + to_text(joint.upper)) +
           unit(joint.kind) + degrees_hint(joint, value);
  }
  return std::nullopt;
}

Eigen::VectorXd RobotModel::clamped(ConstVector q, double tolerance) const {
  Eigen::VectorXd result = q;
  for (std::size_t i = 0; i < dof(); ++i) {
    const Joint& joint = joints()[i];
    double& value = result[static_cast<Eigen::Index>(i)];
    if (value < joint.lower && value >= joint.lower - tolerance) value = joint.lower;
    if (value > joint.upper && value <= joint.upper + tolerance) value = joint.upper;
  }
  return result;
}

Eigen::VectorXd RobotModel::difference(ConstVector a, ConstVector b) const {
  Eigen::VectorXd result = b - a;
  for (std::size_t i = 0; i < dof(); ++i)
    if (joints()[i].kind == JointKind::continuous) {
      double& d = result[static_cast<Eigen::Index>(i)];
      d = std::remainder(d, 2 * std::numbers::pi);
    }
  return result;
}

}  // namespace srmp
