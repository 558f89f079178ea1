#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/io/moveit_messages.h"

namespace srmp::io {

namespace {

using YAML::Node;

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

class SceneReader : public MessageReader {
 public:
  using MessageReader::MessageReader;

  SceneFile read() {
    const Node& root = file_.root();
    refuse_srmp_file(root, "a MoveIt planning scene", "PlannerInterface.load_scene reads it");
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

}  // namespace

SceneFile read_moveit_scene(const std::string& path) { return SceneReader(path).read(); }

}  // namespace srmp::io
