#include "srmp/io/moveit_objects.h"

#include <algorithm>

#include "srmp/core/error.hpp"

namespace srmp::io {

namespace {

bool is_identity(const Pose& pose) { return pose.p.isZero(0.0) && pose.q.vec().isZero(0.0); }

std::string named(const CollisionObject& object) { return "object '" + object.id + "'"; }

/// As MoveIt has it: where only the one shape is placed, its pose is that of the object.
CollisionObject with_own_frame(CollisionObject object) {
  if (object.shapes.size() != 1 || !is_identity(object.pose)) return object;
  std::swap(object.pose, object.shapes.front().pose);
  return object;
}

}  // namespace

std::vector<std::string> ObjectUpdate::shapes_of(const std::string& id) const {
  const auto group = scene_.groups().find(id);
  if (group != scene_.groups().end()) return group->second.objects;
  return scene_.objects().contains(id) ? std::vector<std::string>{id} : std::vector<std::string>{};
}

std::vector<std::string> ObjectUpdate::require_shapes(const std::string& id, const std::string& what) const {
  std::vector<std::string> shapes = shapes_of(id), known = scene_.object_names();
  for (const auto& [name, group] : scene_.groups()) known.push_back(name);
  if (shapes.empty())
    throw InvalidArgument(what + " object '" + id + "', which is not in the scene" + did_you_mean(id, known));
  return shapes;
}

bool ObjectUpdate::is_attached(const std::string& id) const {
  const std::vector<std::string> shapes = shapes_of(id);
  return !shapes.empty() && scene_.attachments().contains(shapes.front());
}

void ObjectUpdate::remove_all() {
  while (!scene_.groups().empty()) remove(scene_.groups().begin()->first);
}

void ObjectUpdate::remove(const std::string& id) {
  std::vector<std::string> shapes = shapes_of(id);
  std::reverse(shapes.begin(), shapes.end());  // a group goes with its first object
  for (const std::string& shape : shapes) scene_.remove_object(shape);
}

void ObjectUpdate::apply(const CollisionObject& object) {
  if (is_attached(object.id))
    throw InvalidArgument(named(object) + " is attached to a link; detach it before the world changes it");
  switch (object.operation) {
    case ObjectOperation::add: {
      const Frame frame = frames_.require(object.frame, named(object));
      if (scene_.groups().contains(object.id)) remove(object.id);
      return add(with_own_frame(object), frame.pose);
    }
    case ObjectOperation::append: return append(object);
    case ObjectOperation::move: return move(object);
    case ObjectOperation::remove:
      if (!object.id.empty()) {
        require_shapes(object.id, "the file removes");
        return remove(object.id);
      }
      std::vector<std::string> ids;
      for (const auto& [id, group] : scene_.groups())
        if (!is_attached(id)) ids.push_back(id);
      for (const std::string& id : ids) remove(id);
  }
}

/// `frame` is the header's, in the world.
void ObjectUpdate::add(const CollisionObject& object, const Pose& frame) {
  ObjectGroup group{{}, object.shapes.front().pose.inverse(), object.subframes};
  for (const PlacedShape& shape : object.shapes) group.objects.push_back(add_shape(object, shape, frame, group));
  scene_.set_group(object.id, group);
}

std::string ObjectUpdate::add_shape(const CollisionObject& object, const PlacedShape& shape, const Pose& frame,
                                    const ObjectGroup& group) {
  const std::size_t index = group.objects.size();
  const std::string name = index == 0 ? object.id : object.id + "_" + std::to_string(index);
  scene_.add_object(name, shape.shape, frame * (object.pose * shape.pose));
  return name;
}

void ObjectUpdate::append(const CollisionObject& object) {
  const auto known = scene_.groups().find(object.id);
  if (known == scene_.groups().end())
    return add(with_own_frame(object), frames_.require(object.frame, named(object)).pose);
  if (!is_identity(object.pose))
    throw NotSupported(
        named(object) +
        " is appended to and has a pose, which MoveIt does not use; shapes are placed in the object that "
        "is there");
  ObjectGroup group = known->second;
  const Pose frame = frames_.require(object.id, named(object)).pose;
  for (const PlacedShape& shape : object.shapes) group.objects.push_back(add_shape(object, shape, frame, group));
  for (const auto& [name, pose] : object.subframes) group.subframes.insert_or_assign(name, pose);
  scene_.set_group(object.id, group);
}

void ObjectUpdate::move(const CollisionObject& object) {
  const std::vector<std::string> shapes = require_shapes(object.id, "the file moves");
  const auto known = scene_.groups().find(object.id);
  ObjectGroup group = known == scene_.groups().end() ? ObjectGroup{shapes, {}, {}} : known->second;
  if (!object.shape_poses.empty() && object.shape_poses.size() != shapes.size())
    throw InvalidArgument(named(object) + " has " + std::to_string(shapes.size()) + " shapes, but is moved with " +
                          std::to_string(object.shape_poses.size()) + " poses of shapes");
  const Pose from = scene_.object_pose(shapes.front()) * group.frame;
  const Pose to = frames_.require(object.frame, named(object)).pose * object.pose;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    scene_.set_object_pose(shapes[i], to * (object.shape_poses.empty() ? from.inverse() * scene_.object_pose(shapes[i])
                                                                       : object.shape_poses[i]));
  if (known == scene_.groups().end()) return;
  if (!object.shape_poses.empty()) group.frame = object.shape_poses.front().inverse();
  scene_.set_group(object.id, group);
}

void ObjectUpdate::apply(const AttachedObject& attached) {
  const CollisionObject& object = attached.object;
  if (object.operation == ObjectOperation::remove) return detach(attached);
  if (object.operation == ObjectOperation::append && is_attached(object.id))
    throw NotSupported(named(object) + " is attached, and shapes cannot be appended to it; attach it anew");
  if (object.shapes.empty()) return attach_existing(attached);
  remove(object.id);  // MoveIt replaces an object of this id, in the world or attached
  attach(attached);
}

void ObjectUpdate::attach(const AttachedObject& attached) {
  const CollisionObject object = with_own_frame(attached.object);
  const std::string robot = frames_.robot_of(attached.link, named(object) + " is attached to");
  const std::string link = frames_.find(attached.link)->link;
  const Frame header = frames_.require(object.frame, named(object));
  add(object, header.pose);
  const bool in_link = object.frame == attached.link;  // then numbers stay as they are
  const Pose link_pose = frames_.link_pose(robot, link);
  const std::vector<std::string> shapes = shapes_of(object.id);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    scene_.attach_object(
        shapes[i], robot, link, attached.touch_links,
        in_link ? object.pose * object.shapes[i].pose : link_pose.inverse() * scene_.object_pose(shapes[i]));
}

void ObjectUpdate::attach_existing(const AttachedObject& attached) {
  const std::string what = "the file attaches";
  const std::string robot = frames_.robot_of(attached.link, what + " an object to");
  const std::string link = frames_.find(attached.link)->link;
  for (const std::string& shape : require_shapes(attached.object.id, what)) {
    const Pose pose = frames_.object_pose(shape);
    if (scene_.attachments().contains(shape)) scene_.detach_object(shape);
    scene_.attach_object(shape, robot, link, attached.touch_links, frames_.link_pose(robot, link).inverse() * pose);
  }
}

void ObjectUpdate::detach(const AttachedObject& attached) {
  std::vector<std::string> detached;
  if (!attached.object.id.empty()) {
    detached = require_shapes(attached.object.id, "the file detaches");
    if (!is_attached(attached.object.id)) throw InvalidArgument(named(attached.object) + " is not attached");
    const std::string& link = scene_.attachments().at(detached.front()).link;
    if (!attached.link.empty() && attached.link != link)
      throw InvalidArgument(named(attached.object) + " is attached to link '" + link + "', not to '" + attached.link +
                            "'");
  }
  if (attached.object.id.empty())
    for (const auto& [name, attachment] : scene_.attachments())
      if (attached.link.empty() || attachment.link == attached.link) detached.push_back(name);
  for (const std::string& name : detached) {
    const Pose pose = frames_.object_pose(name);
    scene_.detach_object(name);
    scene_.set_object_pose(name, pose);
  }
}

}  // namespace srmp::io
