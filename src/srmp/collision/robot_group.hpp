#pragma once

#include <bit>
#include <span>
#include <string>
#include <vector>

#include "srmp/scene/scene.hpp"

namespace srmp::detail {

/// The last of a set of actuated joints on one chain; the set is not empty. Actuated joints are listed parents first.
inline int deepest_actuated_joint(std::uint64_t support) { return 63 - std::countl_zero(support); }

/// The kinematics of one or more robots of a scene as if they were one: configurations one after the other, everything
/// in the base frame of the first. Const; threads share it, each with Data of its own.
class RobotGroup {
 public:
  using Data = std::vector<RobotDataPtr>;

  /// Throws InvalidArgument for unknown or repeated names, and for more than 64 actuated joints together.
  RobotGroup(const Scene& scene, const std::vector<std::string>& robots);

  std::size_t size() const { return robots_.size(); }
  const RobotInstance& instance(std::size_t robot) const { return robots_[robot].instance; }
  const RobotModel& model(std::size_t robot) const { return *robots_[robot].instance.model; }
  bool contains(const std::string& name) const;
  std::size_t first_joint(std::size_t robot) const { return robots_[robot].first_joint; }  ///< into joints()

  const std::vector<Joint>& joints() const { return joints_; }
  /// Of each of joints(): is it continuous?
  const std::vector<char>& continuous() const { return continuous_; }
  const std::vector<ActuatedJoint>& actuated_joints() const { return actuated_joints_; }
  /// A support of one robot's model (RobotModel::link_support) as a set of actuated_joints() of the group.
  std::uint64_t support(std::size_t robot, std::uint64_t of_model) const {
    return of_model << robots_[robot].first_actuated;
  }
  /// The actuated_joints() that these of joints() move.
  std::uint64_t actuated_by(std::span<const std::size_t> joints) const;
  /// Throws InvalidArgument unless q has joints().size() finite entries.
  void require_configuration(ConstVector q, std::string_view what) const;
  /// b - a; continuous joints go the short way.
  Eigen::VectorXd difference(ConstVector a, ConstVector b) const;

  Data make_data() const;
  void forward(Data& data, ConstVector q) const;
  Eigen::Isometry3d geometry_pose(const Data& data, std::size_t robot, std::size_t geometry) const;
  Eigen::Isometry3d link_pose(const Data& data, std::size_t robot, std::size_t link) const;
  /// A point on the axis of an actuated joint, and the axis' direction.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> actuated_joint_axis(const Data& data, std::size_t k) const;
  /// Index of the actuated joint that carries actuated joint k; -1: a base does.
  int parent(std::size_t k) const { return parents_[k]; }

 private:
  struct Robot {
    RobotInstance instance;
    Eigen::Isometry3d base;  // in the first one's base frame
    std::size_t first_joint{}, first_actuated{};
  };
  void add_actuated_joints(const Robot& robot);

  std::vector<Robot> robots_;
  std::vector<Joint> joints_;
  std::vector<char> continuous_;
  std::vector<ActuatedJoint> actuated_joints_;
  std::vector<int> parents_;
  std::vector<std::size_t> robot_of_actuated_;
};

}  // namespace srmp::detail
