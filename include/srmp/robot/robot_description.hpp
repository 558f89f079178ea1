#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// Where a planar joint may move in its plane: a rectangle [m].
struct PlanarBounds {
  Eigen::Vector2d lower{0, 0};  ///< smallest x and y
  Eigen::Vector2d upper{0, 0};  ///< largest x and y
};

/// Where a floating joint may move: a box [m].
struct FloatingBounds {
  Eigen::Vector3d lower{0, 0, 0};  ///< smallest x, y and z
  Eigen::Vector3d upper{0, 0, 0};  ///< largest x, y and z
};

/// Which files describe a robot, and which of its joints are planned.
struct RobotDescription {
  std::string urdf_path{};                       ///< file; required unless urdf_text is given
  std::string urdf_text{};                       ///< the URDF itself, instead of urdf_path
  std::string urdf_directory{};                  ///< of urdf_text: the directory of its relative meshes; "" = none
  std::string srdf_path{};                       ///< file; without an SRDF, allowed collisions are sampled
  std::string srdf_text{};                       ///< the SRDF itself, instead of srdf_path
  std::string name{};                            ///< unique in a scene; "" = the robot name of the URDF
  std::string end_effector{};                    ///< link of goal poses; "" = RobotModel::end_links
  std::string group{};                           ///< SRDF planning group; "" = chain to the end effector
  std::vector<std::string> joint_names{};        ///< planned joints by name, in this order, instead of a group or chain
  std::map<std::string, double> fixed_joints{};  ///< positions [rad or m] of joints that are not planned
  std::vector<std::string> package_dirs{};  ///< searched for package:// and relative meshes, after the URDF's directory
  /// Plans a robot that drives: its planar joint (of the URDF, or the virtual joint of the SRDF; otherwise one called
  /// "base" that moves the root link) becomes "<joint>/x", "<joint>/y" [m] and "<joint>/theta" [rad], which are planned
  /// before the other joints. The base is taken to move in any direction. Unset: a planar joint stays at its origin.
  std::optional<PlanarBounds> planar_bounds{};
  /// Plans a robot that flies: its floating joint (of the URDF, or the virtual joint of the SRDF; otherwise one called
  /// "base" that moves the root link) becomes "<joint>/x", "<joint>/y", "<joint>/z" [m], "<joint>/yaw", "<joint>/pitch"
  /// and "<joint>/roll" [rad], which are planned before the other joints. Pitch is within ±pi/2, so that every
  /// orientation is reached once; at ±pi/2 yaw and roll turn about the same axis. Unset: a floating joint stays at its
  /// origin. Not together with planar_bounds.
  std::optional<FloatingBounds> floating_bounds{};
  bool strict{false};  ///< mistakes in the files that do not change their meaning are errors, not warnings
};

/// The joint of an SRDF that places the root link in a frame outside of the robot.
struct VirtualJoint {
  std::string name;          ///< as in the SRDF
  std::string type;          ///< "fixed", "planar" or "floating"
  std::string parent_frame;  ///< the frame outside of the robot
};

/// How far two opposed fingers open. Between the two positions the width changes in proportion.
struct GripperOpening {
  double max_width{};                      ///< [m] > 0
  std::map<std::string, double> closed{};  ///< by joint name [m]: where they are nearest to each other, width 0
  std::map<std::string, double> opened{};  ///< by joint name [m]: where the width is max_width
};

/// An end effector of an SRDF, such as a gripper.
struct EndEffector {
  std::string name;                 ///< as in the SRDF
  std::string link;                 ///< to which it is attached: the SRDF's parent_link
  std::string group;                ///< of its own links and joints
  std::string parent_group{};       ///< of the arm that carries it; "" = the SRDF does not say
  std::vector<std::string> joints;  ///< of its group, with one degree of freedom, that are not mimic joints
  /// The group's states, such as "open": by name, then by joint name [rad or m]. A state may give some of the joints.
  std::map<std::string, std::map<std::string, double>> states;
  /// Of two prismatic fingers on one link that move against each other; the width is how far they have moved apart from
  /// where they are nearest, which is the gap between them if they touch there. nullopt: they are no such fingers.
  std::optional<GripperOpening> opening;
};

/// How a scalar joint moves: about an axis with or without limits, or along one.
enum class JointKind {
  revolute,    ///< [rad], with limits
  continuous,  ///< [rad], without limits; positions that differ by 2 pi are the same
  prismatic,   ///< [m], with limits
};

/// A joint with one degree of freedom.
struct Joint {
  std::string name;       ///< as in the URDF
  JointKind kind{};       ///< how it moves
  double lower{};         ///< [rad or m]; minus infinity for continuous joints
  double upper{};         ///< [rad or m]; infinity for continuous joints
  double max_velocity{};  ///< [rad/s or m/s]; when the URDF gives none: 0, and 1 for planned joints
  double max_effort{};    ///< [N m or N]; 0: the URDF gives none
};

/// What a link carries, for joint torques.
struct Payload {
  double mass{};                                  ///< [kg], > 0
  Eigen::Vector3d center_of_mass{0.0, 0.0, 0.0};  ///< in the link's frame [m]
  Eigen::Vector3d inertia{0.0, 0.0, 0.0};         ///< about the centre of mass, for the link's axes [kg m^2], >= 0
  std::string link{};                             ///< "" = the end effector
  /// Whether all numbers are the same.
  bool operator==(const Payload& other) const {
    return mass == other.mass && center_of_mass == other.center_of_mass && inertia == other.inertia &&
           link == other.link;
  }
};

/// One collision geometry of a link.
struct LinkGeometry {
  std::string link;  ///< link name
  std::string name;  ///< unique within the robot: "<link>_<n>"
  /// A primitive stays a primitive. A mesh becomes its convex hull, which is solid, if it is a closed convex surface
  /// (to 1 µm); otherwise it becomes its triangles, which are a surface.
  std::shared_ptr<const coal::CollisionGeometry> shape;
  /// The geometry that sphere covers contain: the shape, or its convex hull for a mesh of several materials, which is
  /// read in two ways.
  std::shared_ptr<const coal::CollisionGeometry> envelope;
  Eigen::Vector3d center;    ///< of a bounding sphere, in the geometry's frame [m]
  double radius{};           ///< of that sphere [m]
  std::uint64_t support{};   ///< joint support: bit k is set when RobotModel::actuated_joints()[k] moves this geometry
  std::size_t link_index{};  ///< into RobotModel::link_names()
};

/// A joint of the kinematic tree that a planned joint moves: the planned joint itself (ratio 1) or a mimic joint of it.
struct ActuatedJoint {
  std::size_t joint{};  ///< index of the planned joint in RobotModel::joints()
  double ratio{1.0};    ///< this joint moves by ratio times the motion of the planned joint
  bool prismatic{};     ///< otherwise revolute or continuous
};

}  // namespace srmp
