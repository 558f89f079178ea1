#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/scene/shape.hpp"

/// Readers of MoveIt's YAML files (moveit_msgs/PlanningScene, moveit_msgs/MotionPlanRequest; MotionBenchMaker's
/// scene*.yaml and request*.yaml). Results are plain names and numbers: no robot is needed to read a file.
namespace srmp::io {

/// One shape of a collision object. An object of several shapes gives "id", "id_1", "id_2", …
struct SceneObject {
  std::string name;   ///< unique in the file
  std::string id;     ///< of its collision object
  std::string frame;  ///< of `pose`; "" = the planning frame
  Shape shape;        ///< its sizes in metres
  Pose pose;          ///< object pose * shape pose
};

/// A collision object that is attached to a link.
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

/// entries[i][k]: may names[i] and names[k] be in contact?
struct AllowedCollisionMatrix {
  std::vector<std::string> names;          ///< n bodies: links and objects
  std::vector<std::vector<bool>> entries;  ///< (n, n), symmetric
  std::map<std::string, bool> defaults;    ///< name → contact allowed with everything that has no entry
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

/// The origin of a link must lie in a region.
struct PositionConstraint {
  std::string link;   ///< name of the link
  std::string frame;  ///< of `pose`; "" = the planning frame
  Shape region;       ///< Box or Sphere
  Pose pose;          ///< of the region
};

/// The orientation of a link must be near one.
struct OrientationConstraint {
  std::string link;                                                ///< name of the link
  std::string frame;                                               ///< "" = the planning frame
  Eigen::Quaterniond orientation{Eigen::Quaterniond::Identity()};  ///< the required orientation
  Eigen::Vector3d tolerance{Eigen::Vector3d::Zero()};              ///< [rad] about x, y, z, >= 0
  bool rotation_vector{
      false};  ///< tolerance bounds the rotation vector's components; otherwise intrinsic x, y, z angles
};

/// One of the alternative goals: all of its constraints must hold.
struct GoalAlternative {
  std::string name;                                 ///< as the file has it
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
  std::vector<GoalAlternative> goals;           ///< at least one; any may be reached
  std::optional<double> allowed_planning_time;  ///< [s], > 0; MoveIt's 0 means "not given"
  double velocity_scaling{1.0};                 ///< in (0, 1]; MoveIt's 0 means 1
  double acceleration_scaling{1.0};             ///< in (0, 1]; MoveIt's 0 means 1
  std::optional<WorkspaceBounds> workspace;     ///< bounds of the workspace, if the file has them
};

/// Both throw FileError, with file and line, for anything missing, misspelt (with the nearest known key), NaN, zero
/// quaternions (they are [x, y, z, w], or a map), sizes not above 0, or numbers that do not match; and NotSupported for
/// what is valid but not supported (planes, octomaps, link padding; path constraints, …). Only colours, stamps, object
/// types, subframes, and joint velocities and efforts are ignored.
SceneFile read_moveit_scene(const std::string& path);
/// As read_moveit_scene.
RequestFile read_moveit_request(const std::string& path);

/// Adds the file's objects, attached objects and their allowed collisions to the scene. Throws InvalidArgument or
/// NotSupported and then changes nothing.
///
/// `planning_frame` is the pose of the file's planning frame in the world: for MotionBenchMaker the base of the robot.
/// Frames of objects are looked up among the file's fixed frames, then the links of the scene's robots (as placed by
/// set_qpos). Robots are not moved: robot_state is left to the caller.
///
/// Only those entries of the allowed collision matrix are applied that concern an object of the file: entries between
/// two links repeat the SRDF's (or are older than it), which the scene's robot has already. Names of links or objects
/// that are neither in the file nor in the scene are refused when an object's entry allows contact with them.
void apply(const SceneFile& file, Scene& scene, const Pose& planning_frame = {});

/// Attaches the objects of a request's start state. Throws as apply() and then changes nothing.
void apply_attached(const RequestFile& file, Scene& scene, const Pose& planning_frame = {});

}  // namespace srmp::io
