#include "srmp/io/moveit.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/io/yaml_reader.h"

namespace srmp::io {

namespace {

using YAML::Node;
using Names = std::vector<std::string>;

// Every key of the ROS messages that are read, so that a misspelt one is found. ROS 1 and ROS 2 names.
const Names header_keys{"frame_id", "stamp", "seq"};
const Names pose_keys{"position", "orientation"};
const Names transform_keys{"translation", "rotation"};
const Names vector_keys{"x", "y", "z"};
const Names quaternion_keys{"x", "y", "z", "w"};
const Names primitive_keys{"type", "dimensions", "polygon"};
const Names mesh_keys{"vertices", "triangles", "resource", "dimensions"};
const Names object_keys{"id",       "header",     "type",   "pose",        "primitives",     "primitive_poses",
                        "meshes",   "mesh_poses", "planes", "plane_poses", "subframe_names", "subframe_poses",
                        "operation"};
const Names attached_keys{"link_name", "object", "touch_links", "detach_posture", "weight"};
const Names state_keys{"joint_state", "multi_dof_joint_state", "attached_collision_objects", "is_diff"};
const Names joint_state_keys{"header", "name", "position", "velocity", "effort"};
const Names multi_dof_keys{"header", "joint_names", "transforms", "twist", "wrench"};
const Names fixed_frame_keys{"header", "child_frame_id", "transform"};
const Names acm_keys{"entry_names", "entry_values", "default_entry_names", "default_entry_values"};
const Names world_keys{"collision_objects", "octomap"};
const Names scene_keys{"name",
                       "robot_model_name",
                       "robot_state",
                       "fixed_frame_transforms",
                       "allowed_collision_matrix",
                       "link_padding",
                       "link_scale",
                       "object_colors",
                       "world",
                       "is_diff"};
const Names constraints_keys{"name", "joint_constraints", "position_constraints", "orientation_constraints",
                             "visibility_constraints"};
const Names joint_constraint_keys{"joint_name", "position", "tolerance_above", "tolerance_below", "weight"};
const Names position_constraint_keys{"header", "link_name", "target_point_offset", "constraint_region", "weight"};
const Names region_keys{"primitives", "primitive_poses", "meshes", "mesh_poses"};
const Names orientation_constraint_keys{"header",
                                        "orientation",
                                        "link_name",
                                        "absolute_x_axis_tolerance",
                                        "absolute_y_axis_tolerance",
                                        "absolute_z_axis_tolerance",
                                        "parameterization",
                                        "weight"};
const Names workspace_keys{"header", "min_corner", "max_corner"};
const Names request_keys{"workspace_parameters",
                         "start_state",
                         "goal_constraints",
                         "path_constraints",
                         "trajectory_constraints",
                         "reference_trajectories",
                         "pipeline_id",
                         "planner_id",
                         "group_name",
                         "num_planning_attempts",
                         "allowed_planning_time",
                         "max_velocity_scaling_factor",
                         "max_acceleration_scaling_factor",
                         "cartesian_speed_limited_link",
                         "cartesian_speed_end_effector_link",
                         "max_cartesian_speed"};

/// Reads the messages that scenes and requests have in common.
class MessageReader {
 public:
  explicit MessageReader(const std::string& path) : file_(path) {}

 protected:
  /// A file of this library in place of MoveIt's.
  void refuse_our_own(const Node& root, const std::string& expected, const std::string& how) const {
    if (!root.IsMap() || !root["format"].IsDefined() || !root["format"].IsScalar()) return;
    const std::string& format = root["format"].Scalar();
    if (format.starts_with("srmp "))
      file_.fail(root["format"], "this is a file of the format '" + format + "', not " + expected + "; " + how);
  }
  std::string optional_text(const Node& map, const std::string& key) const {
    const Node node = map[key];
    return is_empty(node) ? "" : file_.text(node, key);
  }
  double optional_number(const Node& map, const std::string& key, double otherwise) const {
    const Node node = map[key];
    return is_empty(node) ? otherwise : file_.number(node, key);
  }
  std::string frame_of(const Node& message) const {
    const Node header = message["header"];
    if (is_empty(header)) return "";
    file_.require_map(header, "a header", header_keys);
    const std::string frame = optional_text(header, "frame_id");
    return frame.starts_with('/') ? frame.substr(1) : frame;  // ROS 1 of old
  }

  /// [x, y, z] or {x: …, y: …, z: …}
  Eigen::Vector3d vector(const Node& node, const std::string& what) const {
    if (!node.IsMap()) {
      const std::vector<double> v = file_.numbers(node, what, 3);
      return {v[0], v[1], v[2]};
    }
    file_.require_map(node, what, vector_keys);
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i)
      v[i] = file_.number(file_.require(node, vector_keys[static_cast<std::size_t>(i)], what), what);
    return v;
  }
  /// [x, y, z, w] or {x: …, y: …, z: …, w: …}
  std::array<double, 4> xyzw(const Node& node, const std::string& what) const {
    std::array<double, 4> q{};
    if (node.IsMap()) {
      file_.require_map(node, what, quaternion_keys);
      for (std::size_t i = 0; i < 4; ++i) q[i] = file_.number(file_.require(node, quaternion_keys[i], what), what);
    } else {
      const std::vector<double> v = file_.numbers(node, what, 4);
      std::copy(v.begin(), v.end(), q.begin());
    }
    return q;
  }
  Pose make_pose(const Node& node, const Eigen::Vector3d& p, const std::array<double, 4>& q) const {
    try {
      return Pose::from_xyzw(p, q);
    } catch (const InvalidArgument& error) {
      file_.fail(node, error.what());
    }
  }
  /// A missing part is zero or identity, as in a ROS 2 message.
  Pose pose(const Node& node, const std::string& what, const Names& keys = pose_keys) const {
    file_.require_map(node, what, keys);
    const Node p = node[keys[0]], q = node[keys[1]];
    const Eigen::Vector3d position = is_empty(p) ? Eigen::Vector3d::Zero() : vector(p, what + "'s " + keys[0]);
    if (is_empty(q)) return {position, Eigen::Quaterniond::Identity()};
    return make_pose(q, position, xyzw(q, what + "'s " + keys[1]));
  }
  Eigen::Quaterniond quaternion(const Node& node, const std::string& what) const {
    return make_pose(node, Eigen::Vector3d::Zero(), xyzw(node, what)).q;
  }

  Shape primitive(const Node& node, const std::string& what) const;
  Shape mesh(const Node& node, const std::string& what) const;
  std::vector<Pose> poses(const Node& object, const std::string& key, std::size_t count, bool may_be_absent,
                          const std::string& what) const;
  std::vector<SceneObject> collision_object(const Node& node);
  RobotState robot_state(const Node& node);

  YamlFile file_;

 private:
  std::string unique_name(const Node& node, const std::string& name) {
    if (!names_.insert(name).second)
      file_.fail(node, "there are two objects named '" + name + "'; names must be unique");
    return name;
  }
  AttachedObject attached_object(const Node& node);
  void joint_state(const Node& node, RobotState& state) const;
  void multi_dof_joint_state(const Node& node, RobotState& state) const;

  std::set<std::string> names_;
};

enum class PrimitiveType { box = 1, sphere, cylinder, cone };  // shape_msgs/SolidPrimitive

PrimitiveType primitive_type(const YamlFile& file, const Node& node, const std::string& what) {
  static const Names names{"box", "sphere", "cylinder", "cone"};
  std::string type = file.text(node, what + "'s type");
  for (char& c : type) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (type == "prism" || type == "5") file.unsupported(node, what + " is a prism, which is not supported; use a mesh");
  for (std::size_t i = 0; i < names.size(); ++i)
    if (type == names[i] || type == std::to_string(i + 1)) return static_cast<PrimitiveType>(i + 1);
  file.fail(node, what + " has the unknown type '" + type + "'; known are " + quoted_list(names));
}

Shape MessageReader::primitive(const Node& node, const std::string& what) const {
  file_.require_map(node, what, primitive_keys);
  const PrimitiveType type = primitive_type(file_, file_.require(node, "type", what), what);
  const Node list = file_.require(node, "dimensions", what);
  const std::size_t count = type == PrimitiveType::box ? 3 : type == PrimitiveType::sphere ? 1 : 2;
  const std::vector<double> d = file_.numbers(list, what + "'s dimensions", count);
  for (const double value : d)
    if (!(value > 0.0)) file_.fail(list, what + " has the dimension " + to_text(value) + "; all must be above 0");
  switch (type) {
    case PrimitiveType::box: return Box{{d[0], d[1], d[2]}};
    case PrimitiveType::sphere: return Sphere{d[0]};
    case PrimitiveType::cylinder: return Cylinder{.radius = d[1], .length = d[0]};  // the message has the height first
    case PrimitiveType::cone: return Cone{.radius = d[1], .length = d[0]};
  }
  file_.fail(node, what + " has an unknown type");
}

Shape MessageReader::mesh(const Node& node, const std::string& what) const {
  file_.require_map(node, what, mesh_keys);
  if (!is_empty(node["resource"]))
    file_.unsupported(node["resource"],
                      what + " names a mesh file; only vertices and triangles in the scene file are supported");
  Mesh mesh;
  const Node vertices = file_.require(node, "vertices", what), triangles = file_.require(node, "triangles", what);
  file_.require_list(vertices, what + "'s vertices");
  file_.require_list(triangles, what + "'s triangles");
  for (const Node& vertex : vertices) mesh.vertices.push_back(vector(vertex, what + "'s vertex"));
  const std::string corner = what + "'s triangle";
  for (const Node& triangle : triangles) {
    if (triangle.IsMap()) file_.require_map(triangle, corner, Names{"vertex_indices"});
    const std::vector<double> v =
        file_.numbers(triangle.IsMap() ? file_.require(triangle, "vertex_indices", corner) : triangle, corner, 3);
    std::array<int, 3> indices{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(v[i] >= 0 && v[i] < static_cast<double>(mesh.vertices.size())) || v[i] != std::floor(v[i]))
        file_.fail(triangle, corner + " has the index " + to_text(v[i]) + ", but there are " +
                                 std::to_string(mesh.vertices.size()) + " vertices, counted from 0");
      indices[i] = static_cast<int>(v[i]);
    }
    mesh.triangles.push_back(indices);
  }
  if (mesh.triangles.empty()) file_.fail(node, what + " is a mesh without triangles");
  return mesh;
}

std::vector<Pose> MessageReader::poses(const Node& object, const std::string& key, std::size_t count,
                                       bool may_be_absent, const std::string& what) const {
  const Node list = object[key];
  if (is_empty(list) && (count == 0 || may_be_absent)) return std::vector<Pose>(count);
  if (is_empty(list)) file_.fail(object, what + " has no '" + key + "'");
  file_.require_list(list, what + "'s " + key);
  if (list.size() != count)
    file_.fail(list,
               what + " has " + std::to_string(count) + " shapes, but " + std::to_string(list.size()) + " " + key);
  std::vector<Pose> result;
  for (const Node& entry : list) result.push_back(pose(entry, what + "'s pose"));
  return result;
}

std::vector<SceneObject> MessageReader::collision_object(const Node& node) {
  file_.require_map(node, "a collision object", object_keys);
  const std::string id = file_.text(file_.require(node, "id", "a collision object"), "a collision object's id");
  if (id.empty()) file_.fail(node, "a collision object's id is empty");
  const std::string what = "object '" + id + "'", frame = frame_of(node);
  if (!is_empty(node["planes"]))
    file_.unsupported(node["planes"], what + " is a plane, which is not supported; use a large box");
  if (const std::string operation = optional_text(node, "operation");
      !(operation.empty() || operation == "0" || operation == "ADD" || operation == "add"))
    file_.unsupported(node["operation"],
                      what + " has the operation '" + operation + "'; only 0 (add) is supported in a scene");
  const Node whole = node["pose"];
  const bool has_pose = whole.IsDefined() && !whole.IsNull();
  const Pose object_pose = has_pose ? pose(whole, what + "'s pose") : Pose{};

  std::vector<SceneObject> shapes;
  const auto add_all = [&](const std::string& key, const std::string& pose_key, auto&& read) {
    if (!is_empty(node[key])) file_.require_list(node[key], what + "'s " + key);
    const std::size_t count = is_empty(node[key]) ? 0 : node[key].size();
    const std::vector<Pose> shape_poses = poses(node, pose_key, count, has_pose, what);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string name = shapes.empty() ? id : id + "_" + std::to_string(shapes.size());
      shapes.push_back({unique_name(node, name), id, frame, read(node[key][i]), object_pose * shape_poses[i]});
    }
  };
  add_all("primitives", "primitive_poses", [&](const Node& shape) { return primitive(shape, what); });
  add_all("meshes", "mesh_poses", [&](const Node& shape) { return mesh(shape, what); });
  if (shapes.empty()) file_.fail(node, what + " has no shape: neither primitives nor meshes");
  return shapes;
}

AttachedObject MessageReader::attached_object(const Node& node) {
  const std::string what = "an attached object";
  file_.require_map(node, what, attached_keys);
  AttachedObject attached;
  attached.link = file_.text(file_.require(node, "link_name", what), "link_name");
  attached.objects = collision_object(file_.require(node, "object", what));
  if (!is_empty(node["touch_links"])) attached.touch_links = file_.texts(node["touch_links"], "touch_links");
  return attached;
}

void MessageReader::joint_state(const Node& node, RobotState& state) const {
  if (is_empty(node)) return;
  file_.require_map(node, "a joint state", joint_state_keys);
  const Names names = is_empty(node["name"]) ? Names{} : file_.texts(node["name"], "joint_state's name");
  const std::vector<double> positions =
      is_empty(node["position"]) ? std::vector<double>{} : file_.numbers(node["position"], "joint_state's position");
  if (names.size() != positions.size())
    file_.fail(node, "a joint state names " + std::to_string(names.size()) + " joints, but has " +
                         std::to_string(positions.size()) + " positions");
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!state.joints.emplace(names[i], positions[i]).second)
      file_.fail(node["name"], "joint '" + names[i] + "' appears twice in a joint state");
}

void MessageReader::multi_dof_joint_state(const Node& node, RobotState& state) const {
  if (is_empty(node)) return;
  file_.require_map(node, "a multi-dof joint state", multi_dof_keys);
  const Names names = is_empty(node["joint_names"]) ? Names{} : file_.texts(node["joint_names"], "joint_names");
  const Node transforms = node["transforms"];
  if (!is_empty(transforms)) file_.require_list(transforms, "transforms");
  const std::size_t count = is_empty(transforms) ? 0 : transforms.size();
  if (names.size() != count)
    file_.fail(node, "a multi-dof joint state names " + std::to_string(names.size()) + " joints, but has " +
                         std::to_string(count) + " transforms");
  for (std::size_t i = 0; i < count; ++i)
    state.multi_dof_joints[names[i]] = pose(transforms[i], "joint '" + names[i] + "'", transform_keys);
}

RobotState MessageReader::robot_state(const Node& node) {
  RobotState state;
  if (is_empty(node)) return state;
  file_.require_map(node, "a robot state", state_keys);
  joint_state(node["joint_state"], state);
  multi_dof_joint_state(node["multi_dof_joint_state"], state);
  const Node attached = node["attached_collision_objects"];
  if (is_empty(attached)) return state;
  file_.require_list(attached, "attached_collision_objects");
  for (const Node& entry : attached) state.attached.push_back(attached_object(entry));
  return state;
}

class SceneReader : public MessageReader {
 public:
  using MessageReader::MessageReader;

  SceneFile read() {
    const Node& root = file_.root();
    refuse_our_own(root, "a MoveIt planning scene", "PlannerInterface.load_scene reads it");
    file_.require_map(root, "a planning scene", scene_keys);
    SceneFile scene;
    scene.path = file_.path();
    scene.name = optional_text(root, "name");
    scene.robot_model_name = optional_text(root, "robot_model_name");
    read_world(root["world"], scene);
    read_fixed_frames(root["fixed_frame_transforms"], scene);
    read_allowed_collisions(root["allowed_collision_matrix"], scene.allowed_collisions);
    scene.robot_state = robot_state(root["robot_state"]);
    refuse_unlike(root["link_padding"], "padding", 0.0);
    refuse_unlike(root["link_scale"], "scale", 1.0);
    return scene;
  }

 private:
  void read_world(const Node& world, SceneFile& scene) {
    if (is_empty(world)) return;
    file_.require_map(world, "the world", world_keys);
    refuse_octomap(world["octomap"]);
    const Node objects = world["collision_objects"];
    if (is_empty(objects)) return;
    file_.require_list(objects, "collision_objects");
    for (const Node& object : objects)
      for (SceneObject& shape : collision_object(object)) scene.objects.push_back(std::move(shape));
  }

  /// ROS dumps always hold one; it counts only when it holds data.
  void refuse_octomap(const Node& octomap) const {
    if (is_empty(octomap)) return;
    const bool empty_message =
        octomap.IsMap() &&
        (is_empty(octomap["octomap"]) || (octomap["octomap"].IsMap() && is_empty(octomap["octomap"]["data"]))) &&
        is_empty(octomap["data"]);
    if (!empty_message)
      file_.unsupported(octomap, "the scene holds an octomap, which is not supported; add its points as a point cloud");
  }

  void read_fixed_frames(const Node& list, SceneFile& scene) const {
    if (is_empty(list)) return;
    file_.require_list(list, "fixed_frame_transforms");
    for (const Node& entry : list) {
      const std::string what = "a fixed frame";
      file_.require_map(entry, what, fixed_frame_keys);
      const std::string name = file_.text(file_.require(entry, "child_frame_id", what), "child_frame_id");
      for (const FixedFrame& other : scene.fixed_frames)
        if (other.name == name) file_.fail(entry, "the fixed frame '" + name + "' appears twice");
      scene.fixed_frames.push_back(
          {name, pose(file_.require(entry, "transform", what), "fixed frame '" + name + "'", transform_keys)});
    }
  }

  void read_allowed_collisions(const Node& node, AllowedCollisionMatrix& matrix) const {
    if (is_empty(node)) return;
    const std::string what = "the allowed collision matrix";
    file_.require_map(node, what, acm_keys);
    if (!is_empty(node["entry_names"])) matrix.names = file_.texts(node["entry_names"], "entry_names");
    if (!is_empty(node["entry_values"])) {
      file_.require_list(node["entry_values"], "entry_values");
      for (const Node& row : node["entry_values"]) matrix.entries.push_back(read_row(row));
    }
    for (const std::vector<bool>& row : matrix.entries)
      if (row.size() != matrix.names.size())
        file_.fail(node, what + " has a row of " + std::to_string(row.size()) + " values for " +
                             std::to_string(matrix.names.size()) + " names");
    if (matrix.entries.size() != matrix.names.size())
      file_.fail(node, what + " has " + std::to_string(matrix.entries.size()) + " rows for " +
                           std::to_string(matrix.names.size()) + " names");
    read_defaults(node, matrix);
  }

  /// [true, …], or {enabled: [true, …]} as the message has it.
  std::vector<bool> read_row(const Node& row) const {
    if (row.IsMap()) file_.require_map(row, "a row of entry_values", Names{"enabled"});
    const Node values = row.IsMap() ? row["enabled"] : row;
    file_.require_list(values, "a row of entry_values");
    std::vector<bool> result;
    for (const Node& value : values) result.push_back(file_.boolean(value, "an entry of entry_values"));
    return result;
  }

  void read_defaults(const Node& node, AllowedCollisionMatrix& matrix) const {
    const Names names = is_empty(node["default_entry_names"])
                            ? Names{}
                            : file_.texts(node["default_entry_names"], "default_entry_names");
    const std::vector<bool> values =
        is_empty(node["default_entry_values"]) ? std::vector<bool>{} : read_row(node["default_entry_values"]);
    if (names.size() != values.size())
      file_.fail(node, "the allowed collision matrix has " + std::to_string(names.size()) +
                           " default_entry_names, but " + std::to_string(values.size()) + " default_entry_values");
    for (std::size_t i = 0; i < names.size(); ++i) matrix.defaults[names[i]] = values[i];
  }

  void refuse_unlike(const Node& list, const std::string& key, double neutral) const {
    if (is_empty(list)) return;
    file_.require_list(list, "link_" + key);
    for (const Node& entry : list) {
      file_.require_map(entry, "a link " + key, Names{"link_name", key});
      if (optional_number(entry, key, neutral) != neutral)
        file_.unsupported(entry, "the scene sets the " + key + " of link '" + optional_text(entry, "link_name") +
                                     "', which is not supported; set it for the whole robot");
    }
  }
};

class RequestReader : public MessageReader {
 public:
  using MessageReader::MessageReader;

  RequestFile read() {
    const Node& root = file_.root();
    refuse_our_own(root, "a MoveIt motion plan request", "srmp replay plans a saved problem again");
    file_.require_map(root, "a motion plan request", request_keys);
    RequestFile request;
    request.path = file_.path();
    request.group_name = optional_text(root, "group_name");
    request.planner_id = optional_text(root, "planner_id");
    request.pipeline_id = optional_text(root, "pipeline_id");
    request.start_state = robot_state(root["start_state"]);
    request.velocity_scaling = scaling(root, "max_velocity_scaling_factor");
    request.acceleration_scaling = scaling(root, "max_acceleration_scaling_factor");
    read_planning_time(root, request);
    read_workspace(root["workspace_parameters"], request);
    refuse_unsupported(root);
    read_goals(root, request);
    return request;
  }

 private:
  double scaling(const Node& root, const std::string& key) const {
    const double value = optional_number(root, key, 1.0);
    if (!(value >= 0.0 && value <= 1.0))
      file_.fail(root[key], key + " is " + to_text(value) + "; it must be in 0 … 1 (0 means 1)");
    return value == 0.0 ? 1.0 : value;
  }

  void read_planning_time(const Node& root, RequestFile& request) const {
    const double time = optional_number(root, "allowed_planning_time", 0.0);
    if (time < 0.0)
      file_.fail(root["allowed_planning_time"],
                 "allowed_planning_time is " + to_text(time) + "; it must be 0 (not said) or above");
    if (time > 0.0) request.allowed_planning_time = time;
    optional_number(root, "num_planning_attempts", 0.0);
  }

  void read_workspace(const Node& node, RequestFile& request) const {
    if (is_empty(node)) return;
    const std::string what = "workspace_parameters";
    file_.require_map(node, what, workspace_keys);
    const WorkspaceBounds bounds{frame_of(node), vector(file_.require(node, "min_corner", what), "min_corner"),
                                 vector(file_.require(node, "max_corner", what), "max_corner")};
    for (int i = 0; i < 3; ++i)
      if (bounds.min_corner[i] > bounds.max_corner[i])
        file_.fail(node, "the workspace's min_corner " + to_text(bounds.min_corner[i]) + " is above its max_corner " +
                             to_text(bounds.max_corner[i]) + " along " + vector_keys[static_cast<std::size_t>(i)]);
    request.workspace = bounds;
  }

  bool holds_constraints(const Node& node) const {
    if (is_empty(node)) return false;
    file_.require_map(node, "constraints", constraints_keys);
    return std::any_of(constraints_keys.begin() + 1, constraints_keys.end(),
                       [&](const std::string& key) { return !is_empty(node[key]); });
  }

  void refuse_unsupported(const Node& root) const {
    if (holds_constraints(root["path_constraints"]))
      file_.unsupported(root["path_constraints"], "path_constraints are not supported");
    const Node trajectory = root["trajectory_constraints"];
    if (!is_empty(trajectory)) {
      file_.require_map(trajectory, "trajectory_constraints", Names{"constraints"});
      if (!is_empty(trajectory["constraints"]))
        file_.unsupported(trajectory, "trajectory_constraints are not supported");
    }
    if (!is_empty(root["reference_trajectories"]))
      file_.unsupported(root["reference_trajectories"], "reference_trajectories are not supported");
    if (optional_number(root, "max_cartesian_speed", 0.0) > 0.0)
      file_.unsupported(root["max_cartesian_speed"], "max_cartesian_speed is not supported");
  }

  void read_goals(const Node& root, RequestFile& request) const {
    const Node goals = root["goal_constraints"];
    if (is_empty(goals)) file_.fail(root, "a motion plan request has no goal_constraints");
    file_.require_list(goals, "goal_constraints");
    for (const Node& goal : goals) request.goals.push_back(read_goal(goal));
  }

  GoalAlternative read_goal(const Node& node) const {
    file_.require_map(node, "a goal", constraints_keys);
    if (!is_empty(node["visibility_constraints"]))
      file_.unsupported(node["visibility_constraints"], "visibility_constraints are not supported");
    GoalAlternative goal;
    goal.name = optional_text(node, "name");
    for_each(node["joint_constraints"], "joint_constraints",
             [&](const Node& entry) { goal.joints.push_back(joint_constraint(entry, goal)); });
    for_each(node["position_constraints"], "position_constraints",
             [&](const Node& entry) { goal.positions.push_back(position_constraint(entry)); });
    for_each(node["orientation_constraints"], "orientation_constraints",
             [&](const Node& entry) { goal.orientations.push_back(orientation_constraint(entry)); });
    if (goal.joints.empty() && goal.positions.empty() && goal.orientations.empty())
      file_.fail(node, "a goal holds no constraints");
    return goal;
  }

  template <class Read>
  void for_each(const Node& list, const std::string& what, Read&& read) const {
    if (is_empty(list)) return;
    file_.require_list(list, what);
    for (const Node& entry : list) read(entry);
  }

  double tolerance(const Node& node, const std::string& key) const {
    const double value = optional_number(node, key, 0.0);
    if (value < 0.0) file_.fail(node[key], key + " is " + to_text(value) + "; it must be 0 or above");
    return value;
  }

  JointConstraint joint_constraint(const Node& node, const GoalAlternative& goal) const {
    const std::string what = "a joint constraint";
    file_.require_map(node, what, joint_constraint_keys);
    JointConstraint constraint;
    constraint.joint = file_.text(file_.require(node, "joint_name", what), "joint_name");
    constraint.position = file_.number(file_.require(node, "position", what), constraint.joint + "'s position");
    constraint.tolerance_above = tolerance(node, "tolerance_above");
    constraint.tolerance_below = tolerance(node, "tolerance_below");
    optional_number(node, "weight", 1.0);
    for (const JointConstraint& other : goal.joints)
      if (other.joint == constraint.joint)
        file_.fail(node, "joint '" + constraint.joint + "' is constrained twice in one goal");
    return constraint;
  }

  PositionConstraint position_constraint(const Node& node) const {
    const std::string what = "a position constraint";
    file_.require_map(node, what, position_constraint_keys);
    const std::string link = file_.text(file_.require(node, "link_name", what), "link_name");
    const Node offset = node["target_point_offset"];
    if (!is_empty(offset) && !vector(offset, "target_point_offset").isZero(0.0))
      file_.unsupported(offset, "a target_point_offset other than zero is not supported");
    const Node region = file_.require(node, "constraint_region", what);
    file_.require_map(region, "a constraint region", region_keys);
    const Node primitives = region["primitives"];
    if (!is_empty(primitives)) file_.require_list(primitives, "a constraint region's primitives");
    if (is_empty(primitives) || primitives.size() != 1 || !is_empty(region["meshes"]))
      file_.unsupported(region, "a constraint region other than one primitive is not supported");
    const Shape shape = primitive(primitives[0], "a constraint region");
    if (!std::holds_alternative<Box>(shape) && !std::holds_alternative<Sphere>(shape))
      file_.unsupported(primitives[0], "a constraint region that is a " +
                                           std::string(std::holds_alternative<Cone>(shape) ? "cone" : "cylinder") +
                                           " is not supported; use a sphere or a box");
    optional_number(node, "weight", 1.0);
    return {link, frame_of(node), shape, poses(region, "primitive_poses", 1, false, "a constraint region")[0]};
  }

  OrientationConstraint orientation_constraint(const Node& node) const {
    const std::string what = "an orientation constraint";
    file_.require_map(node, what, orientation_constraint_keys);
    OrientationConstraint constraint;
    constraint.link = file_.text(file_.require(node, "link_name", what), "link_name");
    constraint.frame = frame_of(node);
    constraint.orientation = quaternion(file_.require(node, "orientation", what), "orientation");
    constraint.tolerance = {tolerance(node, "absolute_x_axis_tolerance"), tolerance(node, "absolute_y_axis_tolerance"),
                            tolerance(node, "absolute_z_axis_tolerance")};
    const double parameterization = optional_number(node, "parameterization", 0.0);
    if (parameterization != 0.0 && parameterization != 1.0)
      file_.fail(node["parameterization"], "parameterization is " + to_text(parameterization) +
                                               "; it must be 0 (x, y, z angles) or 1 (rotation vector)");
    constraint.rotation_vector = parameterization == 1.0;
    optional_number(node, "weight", 1.0);
    return constraint;
  }
};

}  // namespace

SceneFile read_moveit_scene(const std::string& path) { return SceneReader(path).read(); }

RequestFile read_moveit_request(const std::string& path) { return RequestReader(path).read(); }

}  // namespace srmp::io
