#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace srmp {

// The parts of a URDF that this library uses, checked. Visuals, safety controllers and extension tags are not read.
// Lines are those of the file, for messages.

/// A collision geometry.
struct UrdfGeometry {
  enum class Kind { box, sphere, cylinder, capsule, mesh };
  Kind kind{};
  Eigen::Vector3d size{0, 0, 0};                            ///< box: full edge lengths [m]
  double radius{}, length{};                                ///< [m]; a capsule's length is without its caps
  std::string filename;                                     ///< mesh: as written in the file
  Eigen::Vector3d scale{1, 1, 1};                           ///< mesh
  Eigen::Isometry3d origin{Eigen::Isometry3d::Identity()};  ///< in the link's frame
  int line{};
};

/// The mass of a link. Read without checks: most files are used without it.
struct UrdfInertia {
  double mass{};                                            ///< [kg]
  Eigen::Isometry3d origin{Eigen::Isometry3d::Identity()};  ///< of the centre of mass, in the link's frame
  Eigen::Matrix3d inertia{Eigen::Matrix3d::Zero()};         ///< about the centre of mass, along origin's axes [kg m^2]
};

/// A link; joints are indices into Urdf::joints.
struct UrdfLink {
  std::string name;
  std::vector<UrdfGeometry> collisions;
  std::optional<UrdfInertia> inertia;       ///< none: it has no mass, or one that cannot be used
  std::optional<std::size_t> parent_joint;  ///< none: the root
  std::vector<std::size_t> child_joints;    ///< in file order
  int line{};
};

/// As in the URDF.
enum class UrdfJointType { fixed, revolute, continuous, prismatic, floating, planar };

/// The position of a mimic joint is multiplier * source + offset.
struct UrdfMimic {
  std::size_t source{};  ///< joint
  double multiplier{1.0}, offset{0.0};
};

/// A joint; links are indices into Urdf::links.
struct UrdfJoint {
  std::string name;
  UrdfJointType type{};
  std::size_t parent{}, child{};               ///< links
  Eigen::Vector3d xyz{0, 0, 0}, rpy{0, 0, 0};  ///< origin [m], [rad]
  Eigen::Vector3d axis{1, 0, 0};               ///< unit length
  double lower{}, upper{};                     ///< [rad or m]; infinite for continuous joints
  std::optional<double> velocity;              ///< limit [rad/s or m/s], >= 0
  std::optional<double> effort;                ///< limit [N m or N], > 0
  std::optional<UrdfMimic> mimic;              ///< its source is not a mimic joint: chains are multiplied out
  int line{};

  /// Does the joint have one degree of freedom?
  bool scalar() const {
    return type == UrdfJointType::revolute || type == UrdfJointType::continuous || type == UrdfJointType::prismatic;
  }
};

/// A tree of links and joints.
struct Urdf {
  std::string label;  ///< file path, for messages
  std::string name;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
  std::size_t root{};                    ///< link
  std::vector<std::size_t> joint_order;  ///< joints in depth-first order: parents before children

  std::vector<std::string> warnings;  ///< mistakes that do not change the meaning, as sentences

  /// Read and check a URDF. Both throw FileError "<label>:<line>: …" or "<label> …"; when `strict`, also for what is a
  /// warning otherwise.
  static Urdf read_file(const std::string& path);
  static Urdf parse(const std::string& text, const std::string& label = "URDF text", bool strict = false);

  /// The index of a link or joint; nullopt when there is none of this name.
  std::optional<std::size_t> find_link(const std::string& link) const;
  std::optional<std::size_t> find_joint(const std::string& joint) const;
  std::vector<std::string> link_names() const;
  std::vector<std::string> joint_names() const;
  /// Joints from the root down to the link.
  std::vector<std::size_t> chain_to(std::size_t link) const;
  /// Links without children.
  std::vector<std::size_t> leaves() const;
  /// The kinematic tree alone as URDF text, so that Pinocchio reads exactly what was checked here.
  std::string kinematics_text() const;
};

}  // namespace srmp
