#pragma once

// The representation of RobotModel, shared by the files that build and evaluate it.

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "srmp/robot/kinematic_tree.hpp"
#include "srmp/robot/robot_description.hpp"
#include "srmp/robot/srdf.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

class RobotModel;

/// A joint of the tree whose position follows a planned or other joint: position = ratio * source + offset.
struct Follower {
  KinematicTree::Slot slot;
  std::size_t source{};  ///< index into joints() or other_joints()
  double ratio{1.0}, offset{0.0};
  Eigen::Vector3d axis{1, 0, 0};  ///< in the joint's frame
};

/// Members have the meaning of the function of RobotModel with the same name, where there is one.
struct RobotModelImpl {
  RobotDescription description, self_contained;
  std::string name;
  Urdf urdf;
  std::unique_ptr<KinematicTree> tree;

  std::vector<Joint> joints, other_joints;
  std::vector<std::string> joint_names;
  Eigen::VectorXd default_other_positions;
  std::map<std::string, Eigen::VectorXd> group_states;
  std::map<std::string, std::vector<std::string>> groups;
  std::optional<VirtualJoint> virtual_joint;

  std::vector<std::string> link_names;  // as in urdf.links
  std::string end_effector;
  std::vector<std::string> end_links;
  std::vector<EndEffector> end_effectors;
  std::size_t end_effector_index{};

  std::vector<ActuatedJoint> actuated_joints;
  std::vector<Follower> planned_followers;  // by actuated_joints
  std::vector<Follower> other_followers;
  std::vector<std::uint64_t> joint_support;  // by joint of the tree
  std::vector<std::size_t> moving_joints;    // of the tree: those that planned joints move, parents before children

  std::vector<LinkGeometry> geometries;
  std::vector<KinematicTree::FixedPlacement> geometry_placements;
  std::vector<char> allowed;  // link x link
  std::vector<std::pair<std::size_t, std::size_t>> self_pairs;
  std::vector<std::pair<std::string, std::string>> always_colliding;
  std::vector<std::string> warnings;

  bool is_allowed(std::size_t a, std::size_t b) const { return allowed[a * link_names.size() + b]; }
  void set_allowed(std::size_t a, std::size_t b, bool yes) {
    allowed[a * link_names.size() + b] = allowed[b * link_names.size() + a] = yes;
  }
};

/// See robot_model.hpp.
class RobotData {
 public:
  KinematicTree::DataPtr tree;
  std::vector<Eigen::Isometry3d> joint_poses;  // by joint of the tree
  bool others_moved{true};                     // joints that are not planned, since the last forward()
};

/// The steps of RobotModel::load, in several files.
struct RobotModelBuilder {
  using Impl = RobotModelImpl;

  /// RobotModel::load.
  static std::shared_ptr<RobotModel> build(const RobotDescription& description);

  /// RobotModel::end_effectors.
  static void list_end_effectors(Impl& impl, const Srdf& srdf);
  /// Selects the planned joints, the other joints with their defaults, and the end effector. `srdf` may be null.
  static void choose_joints(Impl& impl, const Srdf* srdf);
  /// Sets the actuated joints, the followers and the joint supports.
  static void build_actuated_joints(Impl& impl);
  /// Loads all collision geometries, with their bounding spheres, placements and joint supports.
  static void build_geometries(Impl& impl);
  /// Allows contact of links that are rigidly joined or adjacent, and applies the rules of the SRDF, which may be null.
  static void allow_by_rules(Impl& impl, const Srdf* srdf);
  /// Lists the pairs of geometries whose contact is not allowed.
  static void list_self_pairs(Impl& impl);
  /// RobotModel::always_colliding, without an SRDF. All other steps must be done.
  static void allow_always_colliding(RobotModel& model);

  static Impl& impl(RobotModel& model);
};

}  // namespace srmp
