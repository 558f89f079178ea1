#pragma once

// Inside of RobotModel, shared by the files that build it. Not for users.

#include <string>
#include <vector>

#include "srmp/robot/kinematic_tree.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/robot/srdf.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

/// A tree joint that follows a planned or other joint: value = ratio * source + offset.
struct Follower {
  KinematicTree::Slot slot;
  std::size_t source{};  ///< index into joints() or other_joints()
  double ratio{1.0}, offset{0.0};
  Eigen::Vector3d axis{1, 0, 0};  ///< in the joint's frame
};

struct RobotModel::Impl {
  RobotDescription description, self_contained;
  std::string name;
  Urdf urdf;
  std::unique_ptr<KinematicTree> tree;

  std::vector<Joint> joints, other_joints;
  std::vector<std::string> joint_names;
  Eigen::VectorXd default_other_positions;
  std::map<std::string, Eigen::VectorXd> group_states;

  std::vector<std::string> link_names;  // as in urdf.links
  std::string end_effector;
  std::size_t end_effector_index{};

  std::vector<ActuatedJoint> actuated_joints;
  std::vector<Follower> planned_followers;  // as drives
  std::vector<Follower> other_followers;
  std::vector<std::uint64_t> joint_support;  // by joint of the tree

  std::vector<LinkGeometry> geometries;
  std::vector<KinematicTree::FixedPlacement> geometry_placements;
  std::vector<char> allowed;  // link x link
  std::vector<std::pair<std::size_t, std::size_t>> self_pairs;
  std::vector<std::pair<std::string, std::string>> always_colliding;
  std::vector<std::string> warnings;

  bool is_allowed(std::size_t a, std::size_t b) const { return allowed[a * link_names.size() + b]; }
  void allow(std::size_t a, std::size_t b, bool yes) {
    allowed[a * link_names.size() + b] = allowed[b * link_names.size() + a] = yes;
  }
};

class RobotData {
 public:
  KinematicTree::DataPtr tree;
  std::vector<Eigen::Isometry3d> joint_poses;     // by joint of the tree
  std::vector<Eigen::Isometry3d> geometry_poses;  // by geometry
  bool fixed_are_stale{true};                     // geometries that the plan does not move
};

/// The steps of RobotModel::load; each has a file of its own.
struct RobotModelBuilder {
  using Impl = RobotModel::Impl;

  static std::shared_ptr<RobotModel> build(const RobotDescription& description);

  /// Which joints are planned, which follow, which stand still, and where the end effector is. `srdf` may be null.
  static void choose_joints(Impl& impl, const Srdf* srdf);
  /// Drives, followers and which drive moves what.
  static void build_drives(Impl& impl);
  /// Shapes, bounding spheres and mounts of all collision geometries.
  static void build_geometries(Impl& impl);
  /// Allowed pairs of links that need no sampling: rigidly joined, adjacent, and the SRDF's. Then the pairs to check.
  static void allow_by_rules(Impl& impl, const Srdf* srdf);
  static void list_self_pairs(Impl& impl);
  /// Without an SRDF, see RobotModel::always_colliding. Needs everything else in place.
  static void allow_always_colliding(RobotModel& model);

  static Impl& impl(RobotModel& model) { return *model.impl_; }
};

}  // namespace srmp
