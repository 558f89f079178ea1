#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/io/moveit.hpp"

namespace srmp::io {

namespace {

/// Changes a copy of the scene, so that a refused file leaves the scene as it was.
class SceneUpdate {
 public:
  SceneUpdate(const std::string& path, const Scene& scene, const std::vector<FixedFrame>& frames,
              const Pose& planning_frame)
      : path_(path), scene_(scene), frames_(frames), planning_frame_(planning_frame) {}

  void add(const SceneObject& object) {
    added_.push_back(&object);
    scene_.add_object(object.name, object.shape, frame_pose(object) * object.pose);
  }

  void attach(const AttachedObject& attached) {
    const std::string robot = robot_of(attached.link);
    for (const SceneObject& object : attached.objects) {
      const bool in_link = object.frame == attached.link;
      add(object);
      scene_.attach_object(object.name, robot, attached.link, attached.touch_links,
                           in_link ? std::optional<Pose>(object.pose) : std::nullopt);
    }
  }

  void allow(const AllowedCollisionMatrix& matrix) {
    for (const auto& [name, allowed] : matrix.defaults)
      if (allowed && is_added(name))
        throw NotSupported(path_ + ": the allowed collision matrix allows object '" + name +
                           "' contact with everything, which is not supported; remove the object instead");
    for (std::size_t i = 0; i < matrix.names.size(); ++i)
      for (std::size_t k = 0; k < matrix.names.size(); ++k)
        if (matrix.entries[i][k] && i != k && (is_added(matrix.names[i]) || is_added(matrix.names[k])))
          for (const std::string& a : shapes_of(matrix.names[i]))
            for (const std::string& b : shapes_of(matrix.names[k])) scene_.set_allowed_collision(a, b);
  }

  Scene take() { return std::move(scene_); }

 private:
  /// The one robot that has the link.
  std::string robot_of(const std::string& link) const {
    std::vector<std::string> robots, links;
    for (const auto& [name, robot] : scene_.robots())
      for (const std::string& known : robot.model->link_names()) {
        links.push_back(known);
        if (known == link) robots.push_back(name);
      }
    if (robots.empty())
      throw InvalidArgument(path_ + ": an object is attached to the unknown link '" + link + "'" +
                            did_you_mean(link, links));
    if (robots.size() > 1)
      throw InvalidArgument(path_ + ": link '" + link + "' is in the robots " + quoted_list(robots) +
                            "; only one may have a link that objects are attached to");
    return robots[0];
  }

  Pose frame_pose(const SceneObject& object) const {
    if (object.frame.empty()) return planning_frame_;
    std::vector<std::string> known;
    for (const FixedFrame& frame : frames_) {
      if (frame.name == object.frame) return planning_frame_ * frame.pose;
      known.push_back(frame.name);
    }
    if (object.frame == "world") return planning_frame_;
    for (const auto& [name, robot] : scene_.robots()) {
      const std::vector<std::string>& links = robot.model->link_names();
      if (std::find(links.begin(), links.end(), object.frame) != links.end())
        return scene_.link_pose(name, object.frame);
      known.insert(known.end(), links.begin(), links.end());
    }
    throw InvalidArgument(path_ + ": object '" + object.id + "' is in the unknown frame '" + object.frame + "'" +
                          did_you_mean(object.frame, known));
  }

  bool is_added(const std::string& id) const {
    return std::any_of(added_.begin(), added_.end(), [&](const SceneObject* object) { return object->id == id; });
  }

  /// The names of all shapes of an object of the file; of others, the name itself.
  std::vector<std::string> shapes_of(const std::string& id) const {
    std::vector<std::string> names;
    for (const SceneObject* object : added_)
      if (object->id == id) names.push_back(object->name);
    return names.empty() ? std::vector<std::string>{id} : names;
  }

  std::string path_;
  Scene scene_;
  const std::vector<FixedFrame>& frames_;
  Pose planning_frame_;
  std::vector<const SceneObject*> added_;
};

}  // namespace

void apply(const SceneFile& file, Scene& scene, const Pose& planning_frame) {
  SceneUpdate update(file.path, scene, file.fixed_frames, planning_frame);
  for (const SceneObject& object : file.objects) update.add(object);
  for (const AttachedObject& attached : file.robot_state.attached) update.attach(attached);
  update.allow(file.allowed_collisions);
  scene = update.take();
}

void apply_attached(const RequestFile& file, Scene& scene, const Pose& planning_frame) {
  const std::vector<FixedFrame> no_frames;
  SceneUpdate update(file.path, scene, no_frames, planning_frame);
  for (const AttachedObject& attached : file.start_state.attached) update.attach(attached);
  scene = update.take();
}

}  // namespace srmp::io
