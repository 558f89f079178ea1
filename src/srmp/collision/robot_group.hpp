#pragma once

#include <bit>
#include <string>
#include <vector>

#include "srmp/scene/scene.hpp"

namespace srmp::detail {

/// Of a set of drives on one chain, which is not empty; drives are listed parents first.
inline int deepest_drive(std::uint64_t support) { return 63 - std::countl_zero(support); }

/// The kinematics of one or more robots of a scene as if they were one: configurations one after the other, everything
/// in the base frame of the first. Const; threads share it, each with Data of its own.
class RobotGroup {
 public:
  using Data = std::vector<RobotDataPtr>;

  /// Throws InvalidArgument for unknown or repeated names, and for more than 64 drives together.
  RobotGroup(const Scene& scene, const std::vector<std::string>& robots);

  std::size_t size() const { return members_.size(); }
  const RobotInstance& instance(std::size_t member) const { return members_[member].instance; }
  const RobotModel& model(std::size_t member) const { return *members_[member].instance.model; }
  bool contains(const std::string& robot) const;
  std::size_t first_joint(std::size_t member) const { return members_[member].first_joint; }  ///< into joints()

  const std::vector<Joint>& joints() const { return joints_; }
  const std::vector<ActuatedJoint>& actuated_joints() const { return actuated_joints_; }
  /// What RobotModel and LinkGeometry call movers, as a set of drives().
  std::uint64_t support(std::size_t member, std::uint64_t of_model) const {
    return of_model << members_[member].first_drive;
  }
  /// Throws InvalidArgument unless q has joints().size() finite entries.
  void require_configuration(ConstVector q, std::string_view what) const;

  Data make_data() const;
  void forward(Data& data, ConstVector q) const;
  Eigen::Isometry3d geometry_pose(const Data& data, std::size_t member, std::size_t geometry) const;
  Eigen::Isometry3d link_pose(const Data& data, std::size_t member, std::size_t link) const;
  std::pair<Eigen::Vector3d, Eigen::Vector3d> actuated_joint_axis(const Data& data, std::size_t drive) const;
  /// ActuatedJoint `k`'s parent among drives(), -1: a base.
  int parent(std::size_t k) const { return parents_[k]; }

 private:
  struct Member {
    RobotInstance instance;
    Eigen::Isometry3d base;  // in the first one's base frame
    std::size_t first_joint{}, first_drive{};
  };
  std::vector<Member> members_;
  std::vector<Joint> joints_;
  std::vector<ActuatedJoint> actuated_joints_;
  std::vector<int> parents_;
  std::vector<std::size_t> member_of_drive_;
};

}  // namespace srmp::detail
