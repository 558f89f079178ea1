#pragma once

// Internal: the messages that planning scenes and motion plan requests have in common.

#include <array>
#include <set>
#include <string>
#include <vector>

#include "srmp/io/moveit.hpp"
#include "srmp/io/yaml_reader.h"

namespace srmp::io {

using Names = std::vector<std::string>;

// Every key of a ROS message is known, so that a misspelt one is found. ROS 1 and ROS 2 names.
inline const Names pose_keys{"position", "orientation"};
inline const Names transform_keys{"translation", "rotation"};
inline const Names vector_keys{"x", "y", "z"};

/// Reads parts of one file. Every complaint is a FileError or NotSupported that names file and line; `what` names the
/// part in it.
class MessageReader {
 public:
  explicit MessageReader(const std::string& path) : file_(path) {}

 protected:
  using Node = YAML::Node;

  /// Refuses a file of this library in place of MoveIt's; `how` says what reads it.
  void refuse_srmp_file(const Node& root, const std::string& expected, const std::string& how) const;
  /// "" where there is none.
  std::string optional_text(const Node& map, const std::string& key) const;
  double optional_number(const Node& map, const std::string& key, double otherwise) const;
  /// Of the message's header; "" where there is none.
  std::string frame_of(const Node& message) const;

  /// [x, y, z] or {x: …, y: …, z: …}
  Eigen::Vector3d vector(const Node& node, const std::string& what) const;
  /// A missing part is zero or identity, as in a ROS 2 message.
  Pose pose(const Node& node, const std::string& what, const Names& keys = pose_keys) const;
  /// The same of an object or its parts: a quaternion of four zeros, as in an unset ROS 1 message, is the identity.
  Pose object_pose(const Node& node, const std::string& what) const;
  /// Four numbers as they are; [x, y, z, w] or {x: …, y: …, z: …, w: …}.
  std::array<double, 4> xyzw(const Node& node, const std::string& what) const;
  /// Normalised; [x, y, z, w] or {x: …, y: …, z: …, w: …}.
  Eigen::Quaterniond quaternion(const Node& node, const std::string& what) const;

  /// A shape_msgs/SolidPrimitive.
  Shape primitive(const Node& node, const std::string& what) const;
  /// A shape_msgs/Mesh.
  Shape mesh(const Node& node, const std::string& what) const;
  /// As many poses as shapes; none only where `may_be_absent`.
  std::vector<Pose> poses(const Node& object, const std::string& key, std::size_t count, bool may_be_absent,
                          const std::string& what) const;
  /// A moveit_msgs/CollisionObject; without shapes only where it does not add any.
  CollisionObject collision_object(const Node& node, bool shapes_may_be_absent);
  /// A moveit_msgs/RobotState; empty where there is none.
  RobotState robot_state(const Node& node);

  YamlFile file_;

 private:
  Pose make_pose(const Node& node, const Eigen::Vector3d& p, const std::array<double, 4>& q) const;
  ObjectOperation operation(const Node& node, const std::string& what) const;
  std::vector<PlacedShape> shapes_of(const Node& object, const std::string& what) const;
  std::vector<Pose> moved_poses(const Node& object, const std::string& what) const;
  std::map<std::string, Pose> subframes_of(const Node& object, const std::string& what) const;
  AttachedObject attached_object(const Node& node);
  void joint_state(const Node& node, RobotState& state) const;
  void multi_dof_joint_state(const Node& node, RobotState& state) const;

  std::set<std::string> added_;  // ids of the objects that are in the scene after those read so far
};

}  // namespace srmp::io
