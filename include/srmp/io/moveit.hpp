#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/scene/shape.hpp"

/// Files. What MoveIt writes as YAML (moveit_msgs/PlanningScene, moveit_msgs/MotionPlanRequest; MotionBenchMaker's
/// scene*.yaml and request*.yaml), as plain names and numbers: no robot is needed to read one.
namespace srmp::io {

/// One shape of a collision object. An object of several shapes gives "id", "id_1", "id_2", …
struct SceneObject {
  std::string name;   ///< unique in the file
  std::string id;     ///< of the collision object it belongs to
  std::string frame;  ///< that `pose` is given in; "" = the planning frame
  Shape shape;        ///< its sizes in metres
  Pose pose;          ///< object pose * shape pose, in `frame`
};

/// A collision object that is attached to a link of the robot.
struct AttachedObject {
  std::string link;                      ///< the link that it is attached to
  std::vector<SceneObject> objects;      ///< its shapes
  std::vector<std::string> touch_links;  ///< links that it may touch
};

/// A state of the robot: joints, and the objects attached to it.
struct RobotState {
  std::map<std::string, double> joints;          ///< joint → [rad or m]
  std::map<std::string, Pose> multi_dof_joints;  ///< floating and planar joints, such as SRDF virtual joints
  std::vector<AttachedObject> attached;          ///< attached objects
};

/// entries[i][k]: may names[i] and names[k] touch?
struct AllowedCollisionMatrix {
  std::vector<std::string> names;          ///< n bodies: links and objects
  std::vector<std::vector<bool>> entries;  ///< (n, n), symmetric
  std::map<std::string, bool> defaults;    ///< name → allowed with everything that has no entry
};

/// A frame that the file defines.
struct FixedFrame {
  std::string name;  ///< that objects refer to
  Pose pose;         ///< in the planning frame
};

/// The content of a scene file (moveit_msgs/PlanningScene).
struct SceneFile {
  std::string path;                           ///< the file it was read from
  std::string name;                           ///< of the scene
  std::string robot_model_name;               ///< the robot that it is for
  std::vector<SceneObject> objects;           ///< collision objects, one entry for each shape
  std::vector<FixedFrame> fixed_frames;       ///< frames that objects may refer to
  AllowedCollisionMatrix allowed_collisions;  ///< empty if the file has none
  RobotState robot_state;                     ///< state of the robot
};

/// The position of a joint must be within an interval.
struct JointConstraint {
  std::string joint;         ///< name of the joint
  double position{};         ///< [rad or m]
  double tolerance_above{};  ///< [rad or m], >= 0
  double tolerance_below{};  ///< [rad or m], >= 0
};

/// The origin of a link must be in a region.
struct PositionConstraint {
  std::string link;   ///< name of the link
  std::string frame;  ///< of `pose`; "" = the planning frame
  Shape region;       ///< Box or Sphere
  Pose pose;          ///< of the region
};

/// The orientation of a link must be near one.
struct OrientationConstraint {
  std::string link;                                                ///< name of the link
  std::string frame;                                               ///< of `orientation`; "" = the planning frame
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};  ///< the required orientation
  Eigen::Vector3d tolerance{Eigen::Vector3d::Zero()};              ///< [rad] about x, y, z, >= 0
  bool rotation_vector{false};  ///< tolerance bounds the rotation vector's parts; otherwise intrinsic x, y, z angles
};

/// One alternative of the goal: all of its constraints must hold.
struct GoalAlternative {
  std::string name;                                 ///< of the constraints, as the file has it
  std::vector<JointConstraint> joints;              ///< constraints of joints
  std::vector<PositionConstraint> positions;        ///< constraints of link positions
  std::vector<OrientationConstraint> orientations;  ///< constraints of link orientations
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
  std::vector<GoalAlternative> goals;           ///< at least one; reaching any is enough
  std::optional<double> allowed_planning_time;  ///< [s], > 0; MoveIt's 0 means "not said"
  double velocity_scaling{1.0};                 ///< in (0, 1]; MoveIt's 0 means 1
  double acceleration_scaling{1.0};             ///< in (0, 1]; MoveIt's 0 means 1
  std::optional<WorkspaceBounds> workspace;     ///< bounds of the workspace, if the file has them
};

/// Reads a scene file, or a request file. Both throw FileError, with file and line, for anything missing, misspelt
/// (with the nearest known key), NaN, zero quaternions (they are [x, y, z, w], or a map), sizes not above 0, or numbers
/// that do not match; and NotSupported for what is right but not done here (planes, octomaps, link padding; path
/// constraints, …). Nothing is skipped silently but colours, stamps, object types, subframes, and joint velocities and
/// efforts.
SceneFile read_moveit_scene(const std::string& path);
/// As read_moveit_scene.
RequestFile read_moveit_request(const std::string& path);

/// Puts the file's objects, attached objects and their allowed collisions into the scene, or throws and changes
/// nothing.
///
/// `planning_frame` is where the file's planning frame is in the world: for MotionBenchMaker the base of the robot.
/// Frames of objects are looked up among the file's fixed frames, then the links of the scene's robots (where set_qpos
/// put them). Robots are not moved: robot_state is for the caller to check.
///
/// Of the allowed-collision matrix only the entries that concern an object of the file are taken. Those between two
/// links repeat the SRDF's (or are older than it) and the scene's robot has its own rules; names of links or objects
/// that are neither in the file nor in the scene are refused when an object's entry allows contact with them.
void apply(const SceneFile& file, Scene& scene, const Pose& planning_frame = {});

/// Adds and attaches the objects that a request's start state holds, or throws and changes nothing.
void apply_attached(const RequestFile& file, Scene& scene, const Pose& planning_frame = {});

}  // namespace srmp::io
