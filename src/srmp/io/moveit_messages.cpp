#include "srmp/io/moveit_messages.h"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/io/moveit_rules.h"

namespace srmp::io {

namespace {

using YAML::Node;

const Names header_keys{"frame_id", "stamp", "seq"};
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

enum class PrimitiveType { box = 1, sphere, cylinder, cone };  // shape_msgs/SolidPrimitive

PrimitiveType primitive_type(const YamlFile& file, const Node& node, const std::string& what) {
  static const Names names{"box", "sphere", "cylinder", "cone"};
  std::string type = file.text(node, what + "'s type");
  for (char& c : type) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (type == "prism" || type == "5") file.unsupported(node, what + " " + prism_fault);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (type == names[i] || type == std::to_string(i + 1)) return static_cast<PrimitiveType>(i + 1);
  file.fail(node, what + " has the unknown type '" + type + "'; known are " + quoted_list(names));
}

}  // namespace

void MessageReader::refuse_srmp_file(const Node& root, const std::string& expected, const std::string& how) const {
  if (!root.IsMap() || !root["format"].IsDefined() || !root["format"].IsScalar()) return;
  const std::string& format = root["format"].Scalar();
  if (format.starts_with("srmp "))
    file_.fail(root["format"], "this is a file of the format '" + format + "', not " + expected + "; " + how);
}

std::string MessageReader::optional_text(const Node& map, const std::string& key) const {
  const Node node = map[key];
  return is_empty(node) ? "" : file_.text(node, key);
}

double MessageReader::optional_number(const Node& map, const std::string& key, double otherwise) const {
  const Node node = map[key];
  return is_empty(node) ? otherwise : file_.number(node, key);
}

std::string MessageReader::frame_of(const Node& message) const {
  const Node header = message["header"];
  if (is_empty(header)) return "";
  file_.require_map(header, "a header", header_keys);
  const std::string frame = optional_text(header, "frame_id");
  return frame.starts_with('/') ? frame.substr(1) : frame;  // as early ROS 1 has it
}

Eigen::Vector3d MessageReader::vector(const Node& node, const std::string& what) const {
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

std::array<double, 4> MessageReader::xyzw(const Node& node, const std::string& what) const {
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

Pose MessageReader::make_pose(const Node& node, const Eigen::Vector3d& p, const std::array<double, 4>& q) const {
  try {
    return Pose::from_xyzw(p, q);
  } catch (const InvalidArgument& error) {
    file_.fail(node, error.what());
  }
}

Pose MessageReader::pose(const Node& node, const std::string& what, const Names& keys) const {
  file_.require_map(node, what, keys);
  const Node p = node[keys[0]], q = node[keys[1]];
  const Eigen::Vector3d position = is_empty(p) ? Eigen::Vector3d::Zero() : vector(p, what + "'s " + keys[0]);
  if (is_empty(q)) return {position, Eigen::Quaterniond::Identity()};
  return make_pose(q, position, xyzw(q, what + "'s " + keys[1]));
}

Pose MessageReader::object_pose(const Node& node, const std::string& what) const {
  file_.require_map(node, what, pose_keys);
  const Node q = node["orientation"];
  if (!is_empty(q) && xyzw(q, what + "'s orientation") == std::array<double, 4>{}) {
    const Node p = node["position"];
    return {is_empty(p) ? Eigen::Vector3d::Zero() : vector(p, what + "'s position"), Eigen::Quaterniond::Identity()};
  }
  return pose(node, what);
}

Eigen::Quaterniond MessageReader::quaternion(const Node& node, const std::string& what) const {
  return make_pose(node, Eigen::Vector3d::Zero(), xyzw(node, what)).q;
}

Shape MessageReader::primitive(const Node& node, const std::string& what) const {
  file_.require_map(node, what, primitive_keys);
  const PrimitiveType type = primitive_type(file_, file_.require(node, "type", what), what);
  const Node list = file_.require(node, "dimensions", what);
  const std::size_t count = type == PrimitiveType::box ? 3 : type == PrimitiveType::sphere ? 1 : 2;
  try {
    return solid_primitive(static_cast<int>(type), file_.numbers(list, what + "'s dimensions", count));
  } catch (const InvalidArgument& error) {
    file_.fail(list, what + " " + error.what());
  }
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
  for (const Node& entry : list) result.push_back(object_pose(entry, what + "'s pose"));
  return result;
}

ObjectOperation MessageReader::operation(const Node& node, const std::string& what) const {
  static const Names names{"add", "remove", "append", "move"};
  std::string text = optional_text(node, "operation");
  if (text.empty()) return ObjectOperation::add;
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (std::size_t i = 0; i < names.size(); ++i)
    if (text == names[i] || text == std::to_string(i)) return static_cast<ObjectOperation>(i);
  file_.fail(node["operation"], what + " has the unknown operation '" + text +
                                    "'; known are 0 (add), 1 (remove), 2 (append) and 3 (move)");
}

std::vector<PlacedShape> MessageReader::shapes_of(const Node& object, const std::string& what) const {
  const bool has_pose = object["pose"].IsDefined() && !object["pose"].IsNull();
  std::vector<PlacedShape> shapes;
  const auto add_all = [&](const std::string& key, const std::string& pose_key, auto&& read) {
    if (is_empty(object[key]) && is_empty(object[pose_key])) return;
    if (!is_empty(object[key])) file_.require_list(object[key], what + "'s " + key);
    const std::size_t count = is_empty(object[key]) ? 0 : object[key].size();
    const std::vector<Pose> shape_poses = poses(object, pose_key, count, has_pose, what);
    for (std::size_t i = 0; i < count; ++i) shapes.push_back({read(object[key][i]), shape_poses[i]});
  };
  add_all("primitives", "primitive_poses", [&](const Node& shape) { return primitive(shape, what); });
  add_all("meshes", "mesh_poses", [&](const Node& shape) { return mesh(shape, what); });
  return shapes;
}

std::vector<Pose> MessageReader::moved_poses(const Node& object, const std::string& what) const {
  for (const char* key : {"primitives", "meshes"})
    if (!is_empty(object[key]))
      file_.fail(object[key], what + " is moved and has " + key + "; an object that is moved keeps its shapes");
  std::vector<Pose> result;
  for (const char* key : {"primitive_poses", "mesh_poses"}) {
    if (is_empty(object[key])) continue;
    file_.require_list(object[key], what + "'s " + key);
    for (const Node& entry : object[key]) result.push_back(object_pose(entry, what + "'s pose"));
  }
  return result;
}

std::map<std::string, Pose> MessageReader::subframes_of(const Node& object, const std::string& what) const {
  const Node name_list = object["subframe_names"], pose_list = object["subframe_poses"];
  const Names names = is_empty(name_list) ? Names{} : file_.texts(name_list, what + "'s subframe_names");
  if (!is_empty(pose_list)) file_.require_list(pose_list, what + "'s subframe_poses");
  const std::size_t count = is_empty(pose_list) ? 0 : pose_list.size();
  if (names.size() != count)
    file_.fail(object, what + " has " + std::to_string(names.size()) + " subframe_names, but " + std::to_string(count) +
                           " subframe_poses");
  std::map<std::string, Pose> subframes;
  for (std::size_t i = 0; i < count; ++i)
    if (!subframes.emplace(names[i], object_pose(pose_list[i], "subframe '" + names[i] + "'")).second)
      file_.fail(name_list, what + " has two subframes '" + names[i] + "'");
  return subframes;
}

CollisionObject MessageReader::collision_object(const Node& node, bool shapes_may_be_absent) {
  file_.require_map(node, "a collision object", object_keys);
  CollisionObject object;
  object.operation = operation(node, "a collision object");
  const bool remove = object.operation == ObjectOperation::remove, move = object.operation == ObjectOperation::move;
  object.id = remove ? optional_text(node, "id")
                     : file_.text(file_.require(node, "id", "a collision object"), "a collision object's id");
  if (object.id.empty() && !remove) file_.fail(node, "a collision object's id is empty");
  const std::string what = "object '" + object.id + "'";
  object.frame = frame_of(node);
  for (const char* key : {"planes", "plane_poses"})
    if (!is_empty(node[key])) file_.unsupported(node[key], what + " has " + key + plane_fault);
  if (node["pose"].IsDefined() && !node["pose"].IsNull()) object.pose = object_pose(node["pose"], what + "'s pose");
  object.subframes = subframes_of(node, what);
  if (remove) {
    added_.erase(object.id);
    return object;
  }
  if (move) {
    object.shape_poses = moved_poses(node, what);
    return object;
  }
  object.shapes = shapes_of(node, what);
  if (object.shapes.empty() && !shapes_may_be_absent)
    file_.fail(node, what + " has no shape: neither primitives nor meshes");
  if (!added_.insert(object.id).second && object.operation == ObjectOperation::add && !object.shapes.empty())
    file_.fail(node, "there are two objects named '" + object.id + "'; names must be unique");
  return object;
}

AttachedObject MessageReader::attached_object(const Node& node) {
  const std::string what = "an attached object";
  file_.require_map(node, what, attached_keys);
  AttachedObject attached;
  attached.object = collision_object(file_.require(node, "object", what), true);
  const bool detach = attached.object.operation == ObjectOperation::remove;
  attached.link =
      detach ? optional_text(node, "link_name") : file_.text(file_.require(node, "link_name", what), "link_name");
  if (attached.object.operation == ObjectOperation::move)
    file_.unsupported(node, "attached object '" + attached.object.id + "' is moved, which MoveIt cannot do either");
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
  state.multi_dof_frame = frame_of(node);
  for (std::size_t i = 0; i < count; ++i)
    if (!state.multi_dof_joints.emplace(names[i], pose(transforms[i], "joint '" + names[i] + "'", transform_keys))
             .second)
      file_.fail(node["joint_names"], "joint '" + names[i] + "' appears twice in a multi-dof joint state");
}

RobotState MessageReader::robot_state(const Node& node) {
  RobotState state;
  if (is_empty(node)) return state;
  file_.require_map(node, "a robot state", state_keys);
  const Node is_diff = node["is_diff"];
  state.is_diff = !is_empty(is_diff) && file_.boolean(is_diff, "is_diff");
  joint_state(node["joint_state"], state);
  multi_dof_joint_state(node["multi_dof_joint_state"], state);
  const Node attached = node["attached_collision_objects"];
  if (is_empty(attached)) return state;
  file_.require_list(attached, "attached_collision_objects");
  for (const Node& entry : attached) state.attached.push_back(attached_object(entry));
  return state;
}

}  // namespace srmp::io
