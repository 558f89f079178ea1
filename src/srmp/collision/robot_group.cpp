#include "srmp/collision/robot_group.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp::detail {

RobotGroup::RobotGroup(const Scene& scene, const std::vector<std::string>& robots) {
  for (const std::string& name : robots) {
    if (contains(name)) throw InvalidArgument("robot '" + name + "' is named twice");
    const RobotInstance& instance = scene.robot(name);
    Robot robot{instance, Eigen::Isometry3d::Identity(), joints_.size(), actuated_joints_.size()};
    if (!robots_.empty()) robot.base = (robots_[0].instance.base.inverse() * instance.base).isometry();
    for (const Joint& joint : instance.model->joints()) {
      joints_.push_back(joint);
      continuous_.push_back(joint.kind == JointKind::continuous);
    }
    add_actuated_joints(robot);
    robots_.push_back(std::move(robot));
  }
  if (actuated_joints_.size() > 64)
    throw InvalidArgument(std::to_string(robots_.size()) + " robots have " + std::to_string(actuated_joints_.size()) +
                          " moving joints together; a checker takes at most 64");
}

void RobotGroup::add_actuated_joints(const Robot& robot) {
  const RobotModel& model = *robot.instance.model;
  std::vector<int> parent(model.actuated_joints().size(), -1);
  for (std::size_t link = 0; link < model.link_names().size(); ++link)
    if (const std::uint64_t support = model.link_support(link)) {
      const int deepest = deepest_actuated_joint(support);
      const std::uint64_t above = support & ~(std::uint64_t{1} << deepest);
      if (above) parent[static_cast<std::size_t>(deepest)] = deepest_actuated_joint(above);
    }
  for (std::size_t k = 0; k < parent.size(); ++k) {
    ActuatedJoint actuated = model.actuated_joints()[k];
    actuated.joint += robot.first_joint;
    actuated_joints_.push_back(actuated);
    parents_.push_back(parent[k] < 0 ? -1 : parent[k] + static_cast<int>(robot.first_actuated));
    robot_of_actuated_.push_back(robots_.size());
  }
}

bool RobotGroup::contains(const std::string& name) const {
  return std::any_of(robots_.begin(), robots_.end(), [&](const Robot& r) { return r.instance.model->name() == name; });
}

std::uint64_t RobotGroup::actuated_by(std::span<const std::size_t> joints) const {
  std::uint64_t result = 0;
  for (std::size_t k = 0; k < actuated_joints_.size(); ++k)
    if (std::find(joints.begin(), joints.end(), actuated_joints_[k].joint) != joints.end())
      result |= std::uint64_t{1} << k;
  return result;
}

void RobotGroup::require_configuration(ConstVector q, std::string_view what) const {
  if (q.size() == static_cast<Eigen::Index>(joints_.size()) && q.allFinite()) return;
  if (robots_.size() == 1) return model(0).require_configuration(q, what);
  if (q.size() != static_cast<Eigen::Index>(joints_.size())) {
    std::string robots;
    for (const Robot& robot : robots_) robots += (robots.empty() ? "'" : ", '") + robot.instance.model->name() + "'";
    throw InvalidArgument(std::string(what) + " has " + std::to_string(q.size()) + " entries, but " + robots +
                          " have " + std::to_string(joints_.size()) + " planned joints together");
  }
  for (const Robot& robot : robots_)
    robot.instance.model->require_configuration(
        q.segment(static_cast<Eigen::Index>(robot.first_joint), static_cast<Eigen::Index>(robot.instance.model->dof())),
        what);
}

Eigen::VectorXd RobotGroup::difference(ConstVector a, ConstVector b) const {
  Eigen::VectorXd result = b - a;
  for (std::size_t i = 0; i < continuous_.size(); ++i) {
    double& change = result[static_cast<Eigen::Index>(i)];
    if (continuous_[i]) change = std::remainder(change, 2.0 * std::numbers::pi);
  }
  return result;
}

RobotGroup::Data RobotGroup::make_data() const {
  Data data;
  for (const Robot& robot : robots_) data.push_back(robot.instance.model->make_data(robot.instance.other_positions));
  return data;
}

void RobotGroup::forward(Data& data, ConstVector q) const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    model(i).forward(*data[i], q.segment(static_cast<Eigen::Index>(robots_[i].first_joint),
                                         static_cast<Eigen::Index>(model(i).dof())));
}

Eigen::Isometry3d RobotGroup::geometry_pose(const Data& data, std::size_t robot, std::size_t geometry) const {
  if (robot == 0) return model(0).geometry_pose(*data[0], geometry);
  return robots_[robot].base * model(robot).geometry_pose(*data[robot], geometry);
}

Eigen::Isometry3d RobotGroup::link_pose(const Data& data, std::size_t robot, std::size_t link) const {
  if (robot == 0) return model(0).link_pose(*data[0], link);
  return robots_[robot].base * model(robot).link_pose(*data[robot], link);
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> RobotGroup::actuated_joint_axis(const Data& data, std::size_t k) const {
  const std::size_t robot = robot_of_actuated_[k];
  const auto axis = model(robot).actuated_joint_axis(*data[robot], k - robots_[robot].first_actuated);
  if (robot == 0) return axis;
  const Eigen::Isometry3d& base = robots_[robot].base;
  return {base * axis.first, base.linear() * axis.second};
}

}  // namespace srmp::detail
