#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/pose.hpp"

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// Where a robot comes from and which part of it is planned.
struct RobotDescription {
  std::string urdf_path{};                       ///< file; required unless urdf_text is given
  std::string urdf_text{};                       ///< the URDF itself
  std::string urdf_directory{};                  ///< of urdf_text: where its file would lie, for meshes; "" = nowhere
  std::string srdf_path{};                       ///< file; no SRDF: the allowed-collision matrix is sampled
  std::string srdf_text{};                       ///< the SRDF itself, instead of srdf_path
  std::string name{};                            ///< unique in a scene; "" = the URDF's robot name
  std::string end_effector{};                    ///< link that goals speak of; "" = tip of the group, or the only leaf
  std::string group{};                           ///< SRDF planning group; "" = chain to the end effector
  std::vector<std::string> joint_names{};        ///< named joints instead of a group or chain; order is kept
  std::map<std::string, double> fixed_joints{};  ///< values [rad or m] of joints that are not planned
  std::vector<std::string> package_dirs{};  ///< searched for package:// and relative meshes, after the URDF's directory
};

enum class JointKind { revolute, continuous, prismatic };

/// A scalar joint. Limits are -inf/inf for continuous joints.
struct Joint {
  std::string name;
  JointKind kind{};
  double lower{};         ///< [rad or m]
  double upper{};         ///< [rad or m]
  double max_velocity{};  ///< [rad/s or m/s]
};

/// One collision geometry of a link, and how it hangs on the tree.
struct LinkGeometry {
  std::string link;  ///< link name
  std::string name;  ///< unique within the robot: "<link>_<n>"
  /// Boxes, spheres, cylinders and capsules as such. A mesh is its convex hull where it is a closed convex surface (to
  /// 1 µm): a solid; else its triangles: a surface.
  std::shared_ptr<const coal::CollisionGeometry> shape;
  /// What spheres cover: the shape, or its convex hull where a mesh of several materials is read in two ways.
  std::shared_ptr<const coal::CollisionGeometry> envelope;
  Eigen::Vector3d center;  ///< of a bounding sphere, in the geometry's frame [m]
  double radius{};         ///< of that sphere [m]
  std::uint64_t
      support{};  ///< bit k: RobotModel::drives()[k] moves this geometry (an ancestor joint driven by the plan)
  std::size_t link_index{};  ///< into RobotModel::link_names()
};

/// A tree joint that a planned joint drives: the planned joint itself (ratio 1) or a mimic of it.
/// Listed parents before children; at most 64 a robot.
struct ActuatedJoint {
  std::size_t joint{};  ///< index into RobotModel::joints()
  double ratio{1.0};    ///< this tree joint moves by ratio * the planned joint
  bool prismatic{};
};

/// Scratch memory of one thread: the last configuration's kinematics. Made by RobotModel::make_data.
class RobotData;
struct RobotDataDeleter {
  void operator()(RobotData*) const;
};
using RobotDataPtr = std::unique_ptr<RobotData, RobotDataDeleter>;

/// A robot arm: kinematics, limits, collision geometry and which self-collisions matter. Immutable; threads share it,
/// each with RobotData of its own. Configurations q have dof() entries in the order of joints(), [rad or m].
class RobotModel {
 public:
  /// Reads URDF, SRDF and meshes. Throws FileError (missing or broken file; a missing mesh lists every place tried;
  /// URDF and SRDF mistakes say the line) and InvalidArgument (unknown group, joint or link, with the nearest name).
  /// Visuals, inertias and soft limits (safety_controller) are not read; a mimic joint's own limits are not enforced.
  static std::shared_ptr<const RobotModel> load(const RobotDescription& description);
  ~RobotModel();

  const std::string& name() const;
  const RobotDescription& description() const;
  /// The same robot without its files: URDF and SRDF as texts, as they were read. Meshes are still looked for where
  /// they were, in urdf_directory and package_dirs (absolute). Its name is that of this robot.
  const RobotDescription& self_contained_description() const;
  /// What was read but ignored, as sentences: SRDF rules about links that the URDF does not have, a differing
  /// robot name, floating and planar joints (held at their origin).
  const std::vector<std::string>& warnings() const;

  // --- planned joints
  std::size_t dof() const { return joints().size(); }
  const std::vector<Joint>& joints() const;
  const std::vector<std::string>& joint_names() const;

  // --- all other scalar joints (not planned, not mimic, not fixed); their values come from fixed_joints, the SRDF's
  //     group states, or the value nearest to 0 within limits, in this order
  const std::vector<Joint>& other_joints() const;
  const Eigen::VectorXd& default_other_positions() const;
  /// Named states of the planned group in the SRDF: name → q.
  const std::map<std::string, Eigen::VectorXd>& group_states() const;

  // --- links and geometry
  const std::vector<std::string>& link_names() const;
  std::size_t link_index(const std::string& link) const;  ///< throws InvalidArgument with the nearest name
  const std::string& end_effector() const;
  const std::vector<LinkGeometry>& geometries() const;
  const std::vector<ActuatedJoint>& actuated_joints() const;
  /// Bit k: drives()[k] moves this link.
  std::uint64_t link_support(std::size_t link_index) const;
  /// Pairs of geometries() that must be checked against each other (first < second).
  const std::vector<std::pair<std::size_t, std::size_t>>& self_pairs() const;
  bool allowed(const std::string& link_a, const std::string& link_b) const;  ///< is their contact ignored?
  /// Only when no SRDF was given: pairs of links that touch with all joints at (or nearest to) 0 and in more than 95 %
  /// of 2000 sampled configurations. No plan could avoid that, so they are allowed. Pairs that never touched in a
  /// sample stay checked: a sample proves nothing about the configurations between.
  const std::vector<std::pair<std::string, std::string>>& always_colliding() const;

  // --- kinematics, all in the robot's base frame
  RobotDataPtr make_data() const;                                          ///< other joints at their defaults
  RobotDataPtr make_data(ConstVector other_positions) const;               ///< empty: at their defaults
  void set_other_positions(RobotData& data, ConstVector positions) const;  ///< for all forward() that follow
  void forward(RobotData& data, ConstVector q) const;  ///< computes the poses below; q is not checked against limits
  const Eigen::Isometry3d& geometry_pose(const RobotData& data, std::size_t geometry) const;
  Eigen::Isometry3d link_pose(const RobotData& data, std::size_t link_index) const;
  /// Axis of drives()[k]: a point on it and its unit direction.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> actuated_joint_axis(const RobotData& data, std::size_t k) const;

  /// compute_jacobian of the last forward(), without allocating; `result` is 6 x dof.
  void jacobian(const RobotData& data, std::size_t link_index, Eigen::Ref<Eigen::MatrixXd> result) const;

  /// "" = end effector; other joints stand at `other_positions` (empty: at their defaults).
  Pose compute_fk(ConstVector q, const std::string& link = "", const Eigen::VectorXd& other_positions = {}) const;
  /// 6 x dof: linear rows [m/s] over angular rows [rad/s], of the link's origin, axes of the base frame.
  Eigen::MatrixXd compute_jacobian(ConstVector q, const std::string& link = "",
                                   const Eigen::VectorXd& other_positions = {}) const;

  /// Throws InvalidArgument unless q has dof() finite entries; names the joint. Limits are not looked at.
  void require_configuration(ConstVector q, std::string_view what) const;
  /// The first joint outside its limits (by more than `tolerance`), as a sentence: "panda_joint4: 0.12 rad is above the
  /// upper limit -0.07 rad"; nullopt when all are inside.
  std::optional<std::string> limit_violation(ConstVector q, double tolerance = 1e-9) const;
  /// Moves entries that are outside by at most `tolerance` onto the limit.
  Eigen::VectorXd clamped(ConstVector q, double tolerance) const;
  /// b - a, each continuous joint by the short way round.
  Eigen::VectorXd difference(ConstVector a, ConstVector b) const;

 private:
  friend struct RobotModelBuilder;
  RobotModel();
  struct Impl;
  std::unique_ptr<Impl> impl_;
  friend class RobotData;
};

}  // namespace srmp
