#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/scene/shape.hpp"

/// MoveIt's messages moveit_msgs/PlanningScene and moveit_msgs/MotionPlanRequest as plain names and numbers, and
/// readers of their YAML files (MotionBenchMaker's scene*.yaml and request*.yaml). No robot is needed to read a file.
/// The plugin for MoveIt fills the same structures from ROS messages, and MoveItSession plans with them.
namespace srmp::io {

/// A shape of a collision object.
struct PlacedShape {
  Shape shape;  ///< its sizes in metres
  Pose pose;    ///< in the object's frame
};

/// What a collision object does to the scene (CollisionObject.operation).
enum class ObjectOperation {
  add,     ///< adds it; one of the same id is replaced
  remove,  ///< removes the object of this id, or all where the id is empty; of an attached object: detaches it
  append,  ///< adds its shapes to the object of this id, or the object where there is none
  move,    ///< moves the object of this id
};

/// A collision object (moveit_msgs/CollisionObject).
struct CollisionObject {
  std::string id;                         ///< unique in a MoveIt scene
  std::string frame;                      ///< of `pose`; "" = the planning frame
  Pose pose;                              ///< of the object's frame
  std::vector<PlacedShape> shapes;        ///< none where an object is removed, moved, or attached as it is
  std::vector<Pose> shape_poses;          ///< with move: new poses of all shapes in the object's frame, or none
  std::map<std::string, Pose> subframes;  ///< by name, in the object's frame
  std::size_t planes{};                   ///< number of infinite planes, which are not supported
  ObjectOperation operation{ObjectOperation::add};  ///< what it does to the scene
};

/// A collision object that is attached to a link.
struct AttachedObject {
  std::string link;                      ///< the link that it is attached to
  CollisionObject object;                ///< without shapes: the object of the world with this id
  std::vector<std::string> touch_links;  ///< links that it may touch
};

/// A state of the robot: joints, and the objects attached to it.
struct RobotState {
  std::map<std::string, double> joints;          ///< joint → [rad or m]
  std::map<std::string, double> velocities;      ///< joint → [rad/s or m/s]; of a request's start only
  double speed{};                                ///< largest of the twists of multi_dof_joints [rad/s or m/s]
  std::map<std::string, Pose> multi_dof_joints;  ///< floating and planar joints, such as SRDF virtual joints
  std::string multi_dof_frame;                   ///< of multi_dof_joints; "" = the planning frame
  std::vector<AttachedObject> attached;          ///< attached objects
  bool is_diff{false};                           ///< what it leaves out stays as it is
};

/// entries[i][k]: may names[i] and names[k] be in contact?
struct AllowedCollisionMatrix {
  std::vector<std::string> names;          ///< n bodies: links and objects
  std::vector<std::vector<bool>> entries;  ///< (n, n), symmetric
  std::map<std::string, bool> defaults;    ///< name → contact allowed with everything that has no entry
};

/// A transform between two frames, one of which it defines (PlanningScene.fixed_frame_transforms). MoveIt names the
/// frame that it defines in the header and the planning frame as its child, the reverse of tf; both are understood.
struct FixedFrame {
  std::string frame;  ///< header.frame_id
  std::string child;  ///< child_frame_id
  /// Where `child` is a frame that is known already: the pose of `frame` in it; otherwise the pose of `child` in
  /// `frame`.
  Pose pose;
};

/// The content of a scene file (moveit_msgs/PlanningScene).
struct SceneFile {
  std::string path;                            ///< the file it was read from
  std::string name;                            ///< of the scene
  std::string robot_model_name;                ///< the robot that it is for
  std::vector<CollisionObject> objects;        ///< in the order of the file, which is that of their operations
  std::vector<FixedFrame> fixed_frames;        ///< frames that objects may refer to
  AllowedCollisionMatrix allowed_collisions;   ///< empty if the file has none
  std::map<std::string, double> link_padding;  ///< link → [m], >= 0
  std::map<std::string, double> link_scale;    ///< link → factor; only 1 is supported
  RobotState robot_state;                      ///< state of the robot
  bool is_diff{false};                         ///< objects of earlier files stay
};

/// The position of a joint must be within an interval.
struct JointConstraint {
  std::string joint;         ///< name of the joint
  double position{};         ///< [rad or m]
  double tolerance_above{};  ///< [rad or m], >= 0
  double tolerance_below{};  ///< [rad or m], >= 0
};

/// A point of a link must lie in one of several regions.
struct PositionConstraint {
  std::string link;                                 ///< name of a link, an attached object or a subframe of one
  std::string frame;                                ///< of the regions' poses; "" = the planning frame
  Eigen::Vector3d offset{Eigen::Vector3d::Zero()};  ///< the point, in the link's frame [m]
  std::vector<PlacedShape> regions{};               ///< at least one; Box, Sphere or Cylinder
  std::size_t mesh_regions{};                       ///< number of meshes among the regions: not supported
};

/// The orientation of a link must be near one.
struct OrientationConstraint {
  std::string link;                                                ///< as PositionConstraint::link
  std::string frame;                                               ///< "" = the planning frame
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};  ///< the required orientation
  Eigen::Vector3d tolerance{Eigen::Vector3d::Zero()};              ///< [rad] about x, y, z, >= 0
  /// The tolerance bounds the components of the rotation vector in `frame`; otherwise the intrinsic x, y, z angles of
  /// the rotation in the required orientation.
  bool rotation_vector{false};
};

/// One of the alternative goals: all of its constraints must hold.
struct GoalAlternative {
  std::string name{};                                 ///< as the file has it
  std::vector<JointConstraint> joints{};              ///< constraints of joints
  std::vector<PositionConstraint> positions{};        ///< constraints of link positions
  std::vector<OrientationConstraint> orientations{};  ///< constraints of link orientations
  std::size_t visibilities{};                         ///< number of visibility constraints, which are not supported
};

/// An axis-aligned box.
struct WorkspaceBounds {
  std::string frame;           ///< of the corners; "" = the planning frame
  Eigen::Vector3d min_corner;  ///< [m]
  Eigen::Vector3d max_corner;  ///< [m]
};

/// The content of a request file (moveit_msgs/MotionPlanRequest).
struct RequestFile {
  std::string path;                             ///< the file it was read from
  std::string group_name;                       ///< the planning group that it is for
  std::string planner_id;                       ///< as the file has it
  std::string pipeline_id;                      ///< as the file has it
  RobotState start_state;                       ///< start of the plan; may name some of the joints only
  std::vector<GoalAlternative> goals;           ///< at least one; any may be reached
  std::optional<double> allowed_planning_time;  ///< [s], > 0; MoveIt's 0 means "not given"
  double velocity_scaling{1.0};                 ///< in (0, 1]; MoveIt's 0 means 1
  double acceleration_scaling{1.0};             ///< in (0, 1]; MoveIt's 0 means 1
  std::optional<WorkspaceBounds> workspace;     ///< bounds of the workspace, if the file has them
  int attempts{};                               ///< num_planning_attempts, >= 0; planners are deterministic: no effect
  /// Must hold all the way: positions in one box or sphere each, and orientations. Other constraints are not supported.
  GoalAlternative path_constraints{};
  double max_cartesian_speed{};                ///< [m/s] of that link's origin; 0 = not limited
  std::string cartesian_speed_limited_link{};  ///< "" = the end effector
  // What follows is not supported; the readers refuse files that hold it.
  std::size_t trajectory_constraints{};  ///< their number
  std::size_t reference_trajectories{};  ///< their number
};

/// A shape_msgs/SolidPrimitive: type 1 = box, 2 = sphere, 3 = cylinder (height, radius), 4 = cone (height, radius),
/// with its dimensions [m]. Throws NotSupported for a prism (5), and InvalidArgument for other types, another number of
/// dimensions and those that are not above 0; the sentence begins with a verb ("is …", "has …").
Shape solid_primitive(int type, const std::vector<double>& dimensions);

/// Both throw FileError, with file and line, for anything missing, misspelt (with the nearest known key), NaN, zero
/// quaternions (they are [x, y, z, w], or a map), sizes not above 0, or numbers that do not match; and NotSupported for
/// what is valid but not supported (planes, octomaps, scaled links, …). docs/moveit.md says of every
/// field what it means here.
SceneFile read_moveit_scene(const std::string& path);
/// As read_moveit_scene.
RequestFile read_moveit_request(const std::string& path);

/// Changes the scene as MoveIt would: robot states, objects, attached objects, allowed collisions and padding
/// (docs/moveit.md). A file that is not a diff replaces the objects of earlier files; objects that were added otherwise
/// stay. The shapes of an object `id` are the objects "id", "id_1", "id_2", … of Scene::groups()[id].
///
/// `planning_frame` is the pose of the file's planning frame in the world. Frames are looked up by FrameLookup's rules.
///
/// Returns what was not used, as sentences: joints that no robot has or whose position is outside of its limits,
/// and entries of the allowed collision matrix that forbid contact which a robot's own rules allow. Throws
/// InvalidArgument (with the nearest known name) or NotSupported and then changes nothing.
std::vector<std::string> apply(const SceneFile& file, Scene& scene, const Pose& planning_frame = {});

/// A start state as the scene has it after apply_start.
struct StartState {
  Eigen::VectorXd q;                       ///< (dof,) [rad or m]: planned joints; those left out are at their set_qpos
  Eigen::VectorXd velocity;                ///< (dof,) [rad/s or m/s] of the planned joints; empty: at rest
  std::vector<std::string> unused_joints;  ///< named in the file, but not movable joints of this robot
};

/// Sets the start state of a request in the scene: the robot's base (by the position of its virtual joint), its joints
/// that are not planned, and the objects attached to it; the planned joints are returned. Throws as apply(), for joints
/// that look misspelt (nearly the name of one that the file leaves out), and NotSupported when the robot holds an
/// object that the state, which is not a diff, leaves out, and when joints move that are not planned; it then changes
/// nothing.
StartState apply_start(const RequestFile& file, Scene& scene, const std::string& robot,
                       const Pose& planning_frame = {});

}  // namespace srmp::io
