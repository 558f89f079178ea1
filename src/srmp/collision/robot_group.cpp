#include "srmp/collision/robot_group.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"

namespace srmp::detail {

RobotGroup::RobotGroup(const Scene& scene, const std::vector<std::string>& robots) {
  for (const std::string& name : robots) {
    if (contains(name)) throw InvalidArgument("robot '" + name + "' is named twice");
    const RobotInstance& instance = scene.robot(name);
    Member member{instance, Eigen::Isometry3d::Identity(), joints_.size(), actuated_joints_.size()};
    if (!members_.empty()) member.base = (members_[0].instance.base.inverse() * instance.base).isometry();
    const RobotModel& model = *instance.model;
    joints_.insert(joints_.end(), model.joints().begin(), model.joints().end());
    std::vector<int> parent(model.actuated_joints().size(), -1);
    for (std::size_t link = 0; link < model.link_names().size(); ++link)
      if (const std::uint64_t support = model.link_support(link)) {
        const std::uint64_t above = support & ~(std::uint64_t{1} << deepest_drive(support));
        if (above) parent[static_cast<std::size_t>(deepest_drive(support))] = deepest_drive(above);
      }
    for (std::size_t k = 0; k < parent.size(); ++k) {
      ActuatedJoint drive = model.actuated_joints()[k];
      drive.joint += member.first_joint;
      actuated_joints_.push_back(drive);
      parents_.push_back(parent[k] < 0 ? -1 : parent[k] + static_cast<int>(member.first_drive));
      member_of_drive_.push_back(members_.size());
    }
    members_.push_back(std::move(member));
  }
  if (actuated_joints_.size() > 64)
    throw InvalidArgument(std::to_string(members_.size()) + " robots have " + std::to_string(actuated_joints_.size()) +
                          " moving joints together; a checker takes at most 64");
}

bool RobotGroup::contains(const std::string& robot) const {
  return std::any_of(members_.begin(), members_.end(),
                     [&](const Member& m) { return m.instance.model->name() == robot; });
}

void RobotGroup::require_configuration(ConstVector q, std::string_view what) const {
  if (members_.size() == 1) return model(0).require_configuration(q, what);
  if (q.size() != static_cast<Eigen::Index>(joints_.size())) {
    std::string robots;
    for (const Member& member : members_)
      robots += (robots.empty() ? "'" : ", '") + member.instance.model->name() + "'";
    throw InvalidArgument(std::string(what) + " has " + std::to_string(q.size()) + " entries, but " + robots +
                          " have " + std::to_string(joints_.size()) + " planned joints together");
  }
  for (const Member& member : members_)
    member.instance.model->require_configuration(q.segment(static_cast<Eigen::Index>(member.first_joint),
                                                           static_cast<Eigen::Index>(member.instance.model->dof())),
                                                 what);
}

RobotGroup::Data RobotGroup::make_data() const {
  Data data;
  for (const Member& member : members_)
    data.push_back(member.instance.model->make_data(member.instance.other_positions));
  return data;
}

void RobotGroup::forward(Data& data, ConstVector q) const {
  for (std::size_t i = 0; i < members_.size(); ++i)
    model(i).forward(*data[i], q.segment(static_cast<Eigen::Index>(members_[i].first_joint),
                                         static_cast<Eigen::Index>(model(i).dof())));
}

Eigen::Isometry3d RobotGroup::geometry_pose(const Data& data, std::size_t member, std::size_t geometry) const {
  const Eigen::Isometry3d& pose = model(member).geometry_pose(*data[member], geometry);
  return member == 0 ? pose : members_[member].base * pose;
}

Eigen::Isometry3d RobotGroup::link_pose(const Data& data, std::size_t member, std::size_t link) const {
  const Eigen::Isometry3d pose = model(member).link_pose(*data[member], link);
  return member == 0 ? pose : members_[member].base * pose;
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> RobotGroup::actuated_joint_axis(const Data& data, std::size_t drive) const {
  const std::size_t member = member_of_drive_[drive];
  const auto axis = model(member).actuated_joint_axis(*data[member], drive - members_[member].first_drive);
  if (member == 0) return axis;
  const Eigen::Isometry3d& base = members_[member].base;
  return {base * axis.first, base.linear() * axis.second};
}

}  // namespace srmp::detail
