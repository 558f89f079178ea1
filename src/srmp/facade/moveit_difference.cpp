#include "srmp/facade/moveit_difference.hpp"

#include <algorithm>

namespace srmp {

namespace {

using io::AttachedObject;
using io::CollisionObject;
using io::SceneFile;

bool same(const Pose& a, const Pose& b) { return a == b; }

bool same(const Box& a, const Box& b) { return a.size == b.size; }
bool same(const Sphere& a, const Sphere& b) { return a.radius == b.radius; }
bool same(const Mesh& a, const Mesh& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles && a.convex == b.convex;
}
bool same(const PointCloud& a, const PointCloud& b) { return a.points == b.points && a.resolution == b.resolution; }
template <class Round>  // cylinders, capsules and cones
bool same(const Round& a, const Round& b) {
  return a.radius == b.radius && a.length == b.length;
}

bool same(const io::PlacedShape& a, const io::PlacedShape& b) {
  return same(a.pose, b.pose) && a.shape.index() == b.shape.index() &&
         std::visit([&](const auto& shape) { return same(shape, std::get<std::decay_t<decltype(shape)>>(b.shape)); },
                    a.shape);
}

bool same(const io::FixedFrame& a, const io::FixedFrame& b) {
  return a.frame == b.frame && a.child == b.child && same(a.pose, b.pose);
}

/// Maps and lists of what `same` compares.
template <class Value>
bool same(const std::map<std::string, Value>& a, const std::map<std::string, Value>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.first == other.first && same(one.second, other.second);
  });
}
template <class Value>
bool same(const std::vector<Value>& a, const std::vector<Value>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Value& one, const Value& other) { return same(one, other); });
}

bool same(const CollisionObject& a, const CollisionObject& b) {
  return a.id == b.id && a.frame == b.frame && same(a.pose, b.pose) && same(a.shapes, b.shapes) &&
         same(a.subframes, b.subframes);
}

bool same(const AttachedObject& a, const AttachedObject& b) {
  return a.link == b.link && a.touch_links == b.touch_links && same(a.object, b.object);
}

bool same(const io::AllowedCollisionMatrix& a, const io::AllowedCollisionMatrix& b) {
  return a.names == b.names && a.entries == b.entries && a.defaults == b.defaults;
}

/// The positions of the joints that are not planned.
std::map<std::string, double> other_joints(const SceneFile& scene, const std::vector<std::string>& planned) {
  std::map<std::string, double> joints = scene.robot_state.joints;
  for (const std::string& joint : planned) joints.erase(joint);
  return joints;
}

const CollisionObject* find(const std::vector<CollisionObject>& objects, const std::string& id) {
  const auto it = std::find_if(objects.begin(), objects.end(), [&](const auto& object) { return object.id == id; });
  return it == objects.end() ? nullptr : &*it;
}

const AttachedObject* find(const std::vector<AttachedObject>& all, const std::string& id) {
  const auto it = std::find_if(all.begin(), all.end(), [&](const auto& attached) { return attached.object.id == id; });
  return it == all.end() ? nullptr : &*it;
}

/// Is the frame one of these objects, or a subframe of one?
bool is_in_one(const std::string& frame, const std::vector<CollisionObject>& objects) {
  return std::any_of(objects.begin(), objects.end(), [&](const CollisionObject& object) {
    return frame == object.id || frame.starts_with(object.id + "/");
  });
}

/// The positions of the planned joints.
std::map<std::string, double> planned_positions(const SceneFile& scene, const std::vector<std::string>& planned) {
  std::map<std::string, double> joints;
  for (const std::string& joint : planned)
    if (const auto position = scene.robot_state.joints.find(joint); position != scene.robot_state.joints.end())
      joints.insert(*position);
  return joints;
}

/// Detaches what is no longer attached as it was; it then is in the world. `stays`: an object that is given as it was
/// is where it was.
template <class Stays>
SceneFile detachments(const SceneFile& held, const SceneFile& target, const Stays& stays) {
  SceneFile change;
  change.path = target.path;
  change.robot_model_name = target.robot_model_name;
  change.is_diff = true;
  for (const AttachedObject& attached : held.robot_state.attached) {
    const AttachedObject* still = find(target.robot_state.attached, attached.object.id);
    if (still && same(attached, *still) && stays(attached)) continue;
    AttachedObject detached;
    detached.object.id = attached.object.id;
    detached.object.operation = io::ObjectOperation::remove;
    change.robot_state.attached.push_back(std::move(detached));
  }
  return change;
}

/// Removes the objects that are gone.
void remove_gone(const SceneFile& held, const SceneFile& target, SceneFile& change) {
  const auto remove = [&](const std::string& id) {
    if (find(target.objects, id) || find(target.robot_state.attached, id)) return;
    CollisionObject gone;
    gone.id = id;
    gone.operation = io::ObjectOperation::remove;
    change.objects.push_back(std::move(gone));
  };
  for (const CollisionObject& object : held.objects) remove(object.id);
  for (const AttachedObject& attached : held.robot_state.attached) remove(attached.object.id);
}

}  // namespace

std::vector<SceneFile> scene_difference(const SceneFile& held, const SceneFile& target,
                                        const std::vector<std::string>& planned,
                                        const std::function<bool(const std::string&)>& moves) {
  const bool frames_stay = same(held.fixed_frames, target.fixed_frames);
  // What is placed in a frame that the planned joints move is elsewhere when they are.
  const bool joints_stay = planned_positions(held, planned) == planned_positions(target, planned);
  const auto stays_attached = [&](const AttachedObject& attached) {
    const bool in_link = !attached.object.shapes.empty() && attached.object.frame == attached.link;
    return joints_stay || in_link || !(moves(attached.link) || moves(attached.object.frame));
  };
  SceneFile change = target;  // what is set anew costs nothing: joints, frames, allowed collisions, padding
  change.is_diff = true;
  change.objects.clear();
  change.robot_state.attached.clear();
  remove_gone(held, target, change);
  SceneFile before = detachments(held, target, stays_attached);
  for (const CollisionObject& object : target.objects) {
    const CollisionObject* earlier = find(held.objects, object.id);
    const bool moved = find(before.robot_state.attached, object.id) || !(frames_stay || object.frame.empty()) ||
                       !(joints_stay || !moves(object.frame)) || is_in_one(object.frame, change.objects);
    if (!earlier || moved || !same(*earlier, object)) change.objects.push_back(object);
  }
  for (const AttachedObject& attached : target.robot_state.attached) {
    const AttachedObject* earlier = find(held.robot_state.attached, attached.object.id);
    if (!earlier || !same(*earlier, attached) || !stays_attached(attached))
      change.robot_state.attached.push_back(attached);
  }
  const bool stays =
      frames_stay && change.objects.empty() && change.robot_state.attached.empty() &&
      before.robot_state.attached.empty() && other_joints(held, planned) == other_joints(target, planned) &&
      same(held.robot_state.multi_dof_joints, target.robot_state.multi_dof_joints) &&
      held.robot_state.multi_dof_frame == target.robot_state.multi_dof_frame &&
      same(held.allowed_collisions, target.allowed_collisions) && held.link_padding == target.link_padding;
  if (stays) return {};
  if (before.robot_state.attached.empty()) return {std::move(change)};
  return {std::move(before), std::move(change)};
}

}  // namespace srmp
