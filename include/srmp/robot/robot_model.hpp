#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/robot/robot_description.hpp"

namespace srmp {

struct RobotModelImpl;

/// Scratch memory of one thread, which holds the kinematics of one configuration. RobotModel::make_data creates it.
class RobotData;
/// Deletes RobotData, whose type is incomplete here.
struct RobotDataDeleter {
  /// Deletes the scratch memory.
  void operator()(RobotData*) const;
};
/// Owns the scratch memory of one thread.
using RobotDataPtr = std::unique_ptr<RobotData, RobotDataDeleter>;

/// A robot: kinematics, limits, collision geometry and the self-collisions to check. Immutable; threads share it, each
/// with RobotData of its own. A configuration q has shape (dof(),), in the order of joints(), in rad or m.
class RobotModel {
 public:
  /// Reads URDF, SRDF and meshes. Throws FileError for files that are missing or wrong (a missing mesh lists every
  /// place tried, mistakes in URDF and SRDF give the line) and InvalidArgument for unknown groups, joints or links
  /// (with the nearest known name) and for descriptions that contradict themselves. Visuals and soft limits
  /// (safety_controller) are not read; the limits of mimic joints are not enforced.
  static std::shared_ptr<const RobotModel> load(const RobotDescription& description);
  ~RobotModel();

  /// The name of this robot, unique in a scene.
  const std::string& name() const;
  /// The description that was loaded.
  const RobotDescription& description() const;
  /// A description of the same robot without its files: URDF and SRDF are texts as they were read, and the name is that
  /// of this robot. Meshes are still read from urdf_directory and package_dirs, which are absolute.
  const RobotDescription& self_contained_description() const;
  /// What was read but not used, as sentences: tags and attributes of the URDF and SRDF that are not known, names in
  /// the SRDF that the URDF does not have (with the group, state or rule that they are in), an SRDF with another robot
  /// name; planar and floating joints without bounds, which stay at their origin; planned joints without a velocity
  /// limit; and angles that look like degrees.
  const std::vector<std::string>& warnings() const;

  // --- planned joints
  /// The number of planned joints, at least 1.
  std::size_t dof() const { return joints().size(); }
  const std::vector<Joint>& joints() const;             ///< in the order of the group, chain or joint_names
  const std::vector<std::string>& joint_names() const;  ///< the names of joints()

  // --- other joints
  /// All other joints with one degree of freedom, which are not planned and not mimic joints, in the URDF's tree order.
  const std::vector<Joint>& other_joints() const;
  /// Positions of other_joints() [rad or m]: from fixed_joints, otherwise from the SRDF's group states, otherwise the
  /// value nearest to 0 within the limits.
  const Eigen::VectorXd& default_other_positions() const;
  /// The SRDF's named states that give every planned joint: from name to q.
  const std::map<std::string, Eigen::VectorXd>& group_states() const;
  /// The SRDF's planning groups: from name to its joints with one degree of freedom that are not mimic joints, parents
  /// before children. Empty without an SRDF.
  const std::map<std::string, std::vector<std::string>>& groups() const;
  /// The SRDF's virtual joint of the root link; nullopt when there is none. Its position is the robot's base pose.
  const std::optional<VirtualJoint>& virtual_joint() const;

  // --- links and geometry
  const std::vector<std::string>& link_names() const;     ///< in the order of the URDF
  std::size_t link_index(const std::string& link) const;  ///< throws InvalidArgument with the nearest name
  const std::string& end_effector() const;                ///< link of goal poses; the first of end_links()
  /// The link that was given as end effector, or the last link of the planned joints' chain. Where none was given and
  /// the planned joints branch: the links of the SRDF's end effectors that they move, or else the last link of each
  /// branch. With several of these, goals have to name their link.
  const std::vector<std::string>& end_links() const;
  /// The index of a link; of "": of the end effector. Throws InvalidArgument for unknown links, with the nearest name,
  /// and for "" where end_links() has several.
  std::size_t link_or_end_effector(const std::string& link) const;
  /// The end effectors of the SRDF, in its order. Empty without an SRDF.
  const std::vector<EndEffector>& end_effectors() const;
  const std::vector<LinkGeometry>& geometries() const;  ///< in the order of the URDF
  /// Joints that planned joints move, parents before children; at most 64.
  const std::vector<ActuatedJoint>& actuated_joints() const;
  /// The joint support of a link: bit k is set when actuated_joints()[k] moves it.
  std::uint64_t link_support(std::size_t link_index) const;
  /// Pairs of geometries(), as indices (first < second), that must be checked against each other.
  const std::vector<std::pair<std::size_t, std::size_t>>& self_pairs() const;
  /// Is contact between the two links ignored? Throws InvalidArgument for unknown links, with the nearest name.
  bool allowed(const std::string& link_a, const std::string& link_b) const;
  /// Without an SRDF: pairs of links that collide with the planned joints at 0 (or nearest to it within limits) and in
  /// more than 95 % of 2000 sampled configurations. No plan could avoid that, so their contact is allowed. Pairs that
  /// collide in no sample are still checked, because samples prove nothing about other configurations. With an SRDF:
  /// empty.
  const std::vector<std::pair<std::string, std::string>>& always_colliding() const;

  // --- kinematics, in the robot's base frame (the frame of the URDF's root link)
  /// Data with the other joints at their defaults, and the planned joints at 0.
  RobotDataPtr make_data() const;
  /// Data with the other joints at `other_positions` [rad or m], or at their defaults when that is empty. Throws
  /// InvalidArgument for another size.
  RobotDataPtr make_data(ConstVector other_positions) const;
  /// Sets the positions of other_joints() [rad or m] for all calls of forward() that follow. Throws InvalidArgument for
  /// another size; limits are not checked.
  void set_other_positions(RobotData& data, ConstVector positions) const;
  /// Forward kinematics: computes what the following functions return. Neither the size nor the limits of q are
  /// checked.
  void forward(RobotData& data, ConstVector q) const;
  /// The pose of geometries()[geometry], in the base frame.
  Eigen::Isometry3d geometry_pose(const RobotData& data, std::size_t geometry) const;
  /// The pose of link_names()[link_index], in the base frame.
  Eigen::Isometry3d link_pose(const RobotData& data, std::size_t link_index) const;
  /// The axis of actuated_joints()[k], in the base frame: a point on it [m] and its unit direction.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> actuated_joint_axis(const RobotData& data, std::size_t k) const;

  /// compute_jacobian at the configuration of the last forward(), without allocating. `result` has shape (6, dof()).
  void jacobian(const RobotData& data, std::size_t link_index, Eigen::Ref<Eigen::MatrixXd> result) const;

  /// The pose of a link ("" = end effector) in the base frame. The other joints are at `other_positions`, or at their
  /// defaults when that is empty. Throws InvalidArgument for unknown links, with the nearest name, and as
  /// require_configuration does.
  Pose compute_fk(ConstVector q, const std::string& link = "", const Eigen::VectorXd& other_positions = {}) const;
  /// The Jacobian of a link's origin, shape (6, dof()): linear rows [m/s] above angular rows [rad/s], along the axes of
  /// the base frame. Arguments and exceptions are those of compute_fk.
  Eigen::MatrixXd compute_jacobian(ConstVector q, const std::string& link = "",
                                   const Eigen::VectorXd& other_positions = {}) const;

  // --- configurations
  /// Throws InvalidArgument unless q has dof() finite entries; the message names the joint, and `what` the argument.
  /// Limits are not checked.
  void require_configuration(ConstVector q, std::string_view what) const;
  /// Throws InvalidArgument for the name of a joint that is neither planned nor one of other_joints(): the sentence
  /// says whether it mimics another joint, is fixed, has more than one degree of freedom, or does not exist.
  [[noreturn]] void refuse_joint(const std::string& joint) const;
  /// The first joint outside of its limits by more than `tolerance` [rad or m], as a sentence: "panda_joint4: 0.12 rad
  /// is above the upper limit -0.07 rad"; nullopt when all joints are within their limits.
  std::optional<std::string> limit_violation(ConstVector q, double tolerance = 1e-9) const;
  /// q with the entries that are outside of a limit by at most `tolerance` [rad or m] moved onto the limit.
  Eigen::VectorXd clamped(ConstVector q, double tolerance) const;
  /// b - a; continuous joints along the shorter way round, within [-pi, pi].
  Eigen::VectorXd difference(ConstVector a, ConstVector b) const;

 private:
  friend struct RobotModelBuilder;
  friend class RobotDynamics;
  RobotModel();
  std::unique_ptr<RobotModelImpl> impl_;
};

}  // namespace srmp
