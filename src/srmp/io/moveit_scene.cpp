#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/io/moveit_messages.h"
#include "srmp/io/moveit_rules.h"

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
    const Node is_diff = root["is_diff"];
    scene.is_diff = !is_empty(is_diff) && file_.boolean(is_diff, "is_diff");
    read_world(root["world"], scene);
    read_fixed_frames(root["fixed_frame_transforms"], scene);
    read_allowed_collisions(root["allowed_collision_matrix"], scene.allowed_collisions);
    scene.robot_state = robot_state(root["robot_state"]);
    read_padding(root["link_padding"], scene.link_padding);
    refuse_scale(root["link_scale"]);
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
    for (const Node& object : objects) scene.objects.push_back(collision_object(object, false));
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
      const std::string child = file_.text(file_.require(entry, "child_frame_id", what), "child_frame_id");
      const std::string frame = frame_of(entry);
      for (const FixedFrame& other : scene.fixed_frames)
        if (other.frame == frame && other.child == child)
          file_.fail(entry, "the fixed frames '" + frame + "' and '" + child + "' appear twice");
      scene.fixed_frames.push_back(
          {frame, child, pose(file_.require(entry, "transform", what), "fixed frame '" + child + "'", transform_keys)});
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
    const Node values = row.IsMap() ? file_.require(row, "enabled", "a row of entry_values") : row;
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

  void read_padding(const Node& list, std::map<std::string, double>& padding) const {
    if (is_empty(list)) return;
    file_.require_list(list, "link_padding");
    for (const Node& entry : list) {
      file_.require_map(entry, "a link padding", Names{"link_name", "padding"});
      const std::string link = file_.text(file_.require(entry, "link_name", "a link padding"), "link_name");
      const double value = optional_number(entry, "padding", 0.0);
      if (const std::string fault = padding_fault(link, value); !fault.empty()) file_.fail(entry, fault);
      if (!padding.emplace(link, value).second) file_.fail(entry, "link '" + link + "' has two paddings");
    }
  }

  void refuse_scale(const Node& list) const {
    if (is_empty(list)) return;
    file_.require_list(list, "link_scale");
    for (const Node& entry : list) {
      file_.require_map(entry, "a link scale", Names{"link_name", "scale"});
      if (optional_number(entry, "scale", 1.0) != 1.0)
        file_.unsupported(entry, scale_fault(optional_text(entry, "link_name")));
    }
  }
};

}  // namespace

SceneFile read_moveit_scene(const std::string& path) { return SceneReader(path).read(); }

}  // namespace srmp::io
