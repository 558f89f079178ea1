#include "srmp/io/scene_file.hpp"

#include "srmp/io/scene_archive.h"

namespace srmp::io {

namespace {

const std::vector<std::string> scene_formats{scene_format, problem_format};

/// A robot and its state in the scene.
struct RobotText {
  RobotDescription description;
  Pose base;
  Eigen::VectorXd q;
  std::map<std::string, double> other_joints;
  double padding{};
};

/// An object; the pose of an attached one is in the link's frame.
struct ObjectText {
  std::string name;
  Shape shape{Box{Eigen::Vector3d::Zero()}};
  Pose pose;
  double padding{};
  std::optional<Attachment> attachment;
};

struct AllowedText {
  std::string a, b;
  bool allowed{};
};

struct GroupText {
  std::string id;
  ObjectGroup group;
};

}  // namespace

template <class Archive>
void describe(Archive& archive, Ref<Archive, RobotText> robot) {
  archive("name", robot.description.name);
  archive("end_effector", robot.description.end_effector);
  archive("group", robot.description.group);
  archive("joint_names", robot.description.joint_names);
  archive("fixed_joints", robot.description.fixed_joints);
  archive("urdf_directory", robot.description.urdf_directory);
  archive("package_dirs", robot.description.package_dirs);
  archive("base_pose", robot.base);
  archive("q", robot.q);
  archive("other_joints", robot.other_joints);
  archive("padding", robot.padding);
  archive("urdf", robot.description.urdf_text);
  archive("srdf", robot.description.srdf_text);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Box> box) {
  archive("size", box.size);
}
template <class Archive>
void describe(Archive& archive, Ref<Archive, Sphere> sphere) {
  archive("radius", sphere.radius);
}
template <class Archive, class Round>
void describe_round(Archive& archive, Round& round) {
  archive("radius", round.radius);
  archive("length", round.length);
}
template <class Archive>
void describe(Archive& archive, Ref<Archive, Cylinder> cylinder) {
  describe_round(archive, cylinder);
}
template <class Archive>
void describe(Archive& archive, Ref<Archive, Capsule> capsule) {
  describe_round(archive, capsule);
}
template <class Archive>
void describe(Archive& archive, Ref<Archive, Cone> cone) {
  describe_round(archive, cone);
}
template <class Archive>
void describe(Archive& archive, Ref<Archive, Mesh> mesh) {
  archive("convex", mesh.convex);
  archive("vertices", mesh.vertices);
  archive("triangles", mesh.triangles);
}
template <class Archive>
void describe(Archive& archive, Ref<Archive, PointCloud> cloud) {
  archive("resolution", cloud.resolution);
  archive("points", cloud.points);
}

/// An empty shape of this kind, as shape_kind names it.
Shape shape_of_kind(const JsonReader& reader, const std::string& kind) {
  std::vector<std::string> known;
  for (const Shape& shape : std::initializer_list<Shape>{Box{Eigen::Vector3d::Zero()}, Sphere{}, Cylinder{}, Capsule{},
                                                         Cone{}, Mesh{}, PointCloud{}}) {
    if (shape_kind(shape) == kind) return shape;
    known.push_back(shape_kind(shape));
  }
  reader.fail("the kind is '" + kind + "'; known are " + quoted_list(known));
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Shape> shape) {
  std::string kind = shape_kind(shape);
  archive("kind", kind);
  if constexpr (Archive::reading) shape = shape_of_kind(archive, kind);
  std::visit([&](auto& typed) { describe(archive, typed); }, shape);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Attachment> attachment) {
  archive("robot", attachment.robot);
  archive("link", attachment.link);
  std::vector<std::string> touch_links(attachment.touch_links.begin(), attachment.touch_links.end());
  archive("touch_links", touch_links);
  if constexpr (Archive::reading) attachment.touch_links = {touch_links.begin(), touch_links.end()};
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, ObjectText> object) {
  archive("name", object.name);
  archive("shape", object.shape);
  archive("pose", object.pose);
  archive("padding", object.padding);
  archive("attached", object.attachment);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, AllowedText> pair) {
  archive("a", pair.a);
  archive("b", pair.b);
  archive("allowed", pair.allowed);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, GroupText> text) {
  archive("id", text.id);
  archive("objects", text.group.objects);
  archive("frame", text.group.frame);
  archive("subframes", text.group.subframes);
}

namespace {

RobotText robot_text(const RobotInstance& robot) {
  RobotText text{robot.model->self_contained_description(), robot.base, robot.q, {}, robot.padding};
  for (std::size_t i = 0; i < robot.model->other_joints().size(); ++i)
    text.other_joints[robot.model->other_joints()[i].name] = robot.other_positions[static_cast<Eigen::Index>(i)];
  return text;
}

ObjectText object_text(const Scene& scene, const Object& object) {
  const auto attached = scene.attachments().find(object.name);
  return {object.name, object.shape, object.pose, object.padding,
          attached == scene.attachments().end() ? std::nullopt : std::optional(attached->second)};
}

void add(Scene& scene, RobotText robot, const std::vector<std::string>& package_dirs) {
  std::vector<std::string>& directories = robot.description.package_dirs;
  directories.insert(directories.end(), package_dirs.begin(), package_dirs.end());
  const auto model = RobotModel::load(robot.description);
  scene.add_robot(model, robot.base);
  scene.set_qpos(model->name(), robot.q);
  scene.set_joint_positions(model->name(), robot.other_joints);
  scene.set_robot_padding(model->name(), robot.padding);
}

void add(Scene& scene, const ObjectText& object) {
  scene.add_object(object.name, object.shape, object.pose, object.padding);
  if (const auto& attachment = object.attachment)
    scene.attach_object(object.name, attachment->robot, attachment->link,
                        {attachment->touch_links.begin(), attachment->touch_links.end()}, object.pose);
}

/// Calls add(item) for each map of the list; its errors are reported for the map's place in the file.
template <class Item, class Add>
void read_each(JsonReader& reader, const char* key, Add&& add) {
  for (JsonReader& each : reader.items(key)) {
    Item item;
    describe(each, item);
    each.finish();
    each.guarded([&] { add(std::move(item)); });
  }
}

}  // namespace

void describe(JsonWriter& writer, const SceneText& text) {
  std::vector<RobotText> robots;
  for (const auto& [name, robot] : text.scene.robots()) robots.push_back(robot_text(robot));
  std::vector<ObjectText> objects;
  for (const auto& [name, object] : text.scene.objects()) objects.push_back(object_text(text.scene, object));
  std::vector<AllowedText> allowed;
  for (const auto& [pair, yes] : text.scene.allowed_settings()) allowed.push_back({pair.first, pair.second, yes});
  writer("robots", robots);
  writer("objects", objects);
  writer("allowed_collisions", allowed);
  std::vector<GroupText> groups;
  for (const auto& [id, group] : text.scene.groups()) groups.push_back({id, group});
  if (!groups.empty()) writer("object_groups", groups);
}

Scene read_scene(JsonReader reader, const std::vector<std::string>& package_dirs) {
  Scene scene;
  read_each<RobotText>(reader, "robots", [&](RobotText robot) { add(scene, std::move(robot), package_dirs); });
  read_each<ObjectText>(reader, "objects", [&](const ObjectText& object) { add(scene, object); });
  read_each<AllowedText>(reader, "allowed_collisions",
                         [&](const AllowedText& pair) { scene.set_allowed_collision(pair.a, pair.b, pair.allowed); });
  if (reader.has("object_groups"))
    read_each<GroupText>(reader, "object_groups", [&](const GroupText& text) { scene.set_group(text.id, text.group); });
  reader.finish();
  return scene;
}

void save_scene(const Scene& scene, const std::string& path) {
  JsonWriter writer(scene_format);
  writer("scene", SceneText{scene});
  writer.save(path);
}

Scene load_scene(const std::string& path, const std::vector<std::string>& package_dirs) {
  const JsonFile file(path, scene_formats);
  JsonReader root = file.root();
  Scene scene = read_scene(root.inner("scene"), package_dirs);
  if (file.format() == scene_format) root.finish();
  return scene;
}

}  // namespace srmp::io
