#include "srmp/scene/scene.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/core/run_interruptibly.hpp"
#include "srmp/core/utf8.hpp"
#include "srmp/geometry/distance_field.hpp"
#include "srmp/robot/joint_names.hpp"
#include "srmp/scene/shape_geometry.hpp"

namespace srmp {

namespace {

using Key = std::pair<std::string, std::string>;

Key ordered(const std::string& a, const std::string& b) { return a < b ? Key{a, b} : Key{b, a}; }

template <class Map>
std::vector<std::string> keys(const Map& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

double checked_padding(double padding, const std::string& owner) {
  if (!(std::isfinite(padding) && padding >= 0.0))
    throw InvalidArgument("padding of " + owner + " is " + to_text(padding) +
                          "; it must be a finite number, 0 or above [m]");
  if (padding > max_length)
    throw InvalidArgument("padding of " + owner + " is " + to_text(padding) + " m" + length_rule());
  return padding;
}

Eigen::VectorXd nearest_to_zero(const RobotModel& model) {
  Eigen::VectorXd q(model.dof());
  for (std::size_t i = 0; i < model.dof(); ++i)
    q[i] = std::clamp(0.0, model.joints()[i].lower, model.joints()[i].upper);
  return q;
}

bool has_link(const RobotModel& model, const std::string& link) {
  const std::vector<std::string>& names = model.link_names();
  return std::find(names.begin(), names.end(), link) != names.end();
}

void require_within_limits(const Joint& joint, double value, const std::string& robot) {
  if (!std::isfinite(value))
    throw InvalidArgument("robot '" + robot + "': joint '" + joint.name + "' is " + to_text(value) +
                          "; only finite numbers are allowed");
  constexpr double tolerance = 1e-9;
  if (value < joint.lower - tolerance || value > joint.upper + tolerance)
    throw InvalidArgument("robot '" + robot + "': joint '" + joint.name + "' = " + to_text(value) +
                          " is outside its limits [" + to_text(joint.lower) + ", " + to_text(joint.upper) + "]" +
                          degrees_hint(joint, value));
}

/// Sets the position of the joint of this name; false if there is none in `joints`.
bool assign_joint(const std::vector<Joint>& joints, const std::string& name, double value, const std::string& robot,
                  Eigen::VectorXd& positions) {
  const Joint* joint = find_joint(joints, name);
  if (!joint) return false;
  require_within_limits(*joint, value, robot);
  positions[joint - joints.data()] = value;
  return true;
}

/// Throws InvalidArgument with the nearest known name, or with all known names.
[[noreturn]] void refuse_unknown(const std::string& what, const std::string& name,
                                 const std::vector<std::string>& known) {
  const std::string guess = did_you_mean(name, known);
  throw InvalidArgument("unknown " + what + " '" + name + "'" +
                        (guess.empty() ? "; known: " + quoted_list(known) : guess));
}

/// Makes the geometry of the object's shape. Large meshes and clouds take seconds.
void build_geometry(Object& object) {
  auto build = [](Object built) {
    built.geometry = make_geometry(built.shape, built.name);
    built.parts = parts_of(built.geometry);
    built.field = make_distance_field(*built.geometry, built.parts.bvh.get());
    return built;
  };
  const bool is_large = std::holds_alternative<Mesh>(object.shape) || std::holds_alternative<PointCloud>(object.shape);
  object = is_large ? run_interruptibly([build, own = std::move(object)]() mutable { return build(std::move(own)); })
                    : build(std::move(object));
}

}  // namespace

/// An object (robot empty), a whole robot (object and link empty) or one link.
struct Scene::Body {
  std::string object, robot, link;

  bool whole_robot() const { return object.empty() && link.empty(); }
  bool is_link() const { return !link.empty(); }
  std::string key() const { return !object.empty() ? object : link.empty() ? robot : robot + "/" + link; }
};

// --- robots

void Scene::require_new_name(const std::string& name, const char* what) const {
  if (name.empty()) throw InvalidArgument(std::string(what) + " name is empty; give it a name");
  if (!is_utf8(name)) throw InvalidArgument(std::string(what) + " name '" + name + "' is not UTF-8; names must be");
  if (robots_.contains(name))
    throw InvalidArgument(std::string(what) + " name '" + name + "' is taken by a robot; names are unique in a scene");
  if (objects_.contains(name))
    throw InvalidArgument(std::string(what) + " name '" + name +
                          "' is taken by an object; remove it first or choose another name");
}

void Scene::add_robot(std::shared_ptr<const RobotModel> model, const Pose& base) {
  if (!model) throw InvalidArgument("add_robot: the model is null; load one with RobotModel::load");
  const std::string& name = model->name();
  require_new_name(name, "robot");
  for (const std::string& link : model->link_names())
    if (objects_.contains(name + "/" + link))
      throw InvalidArgument("robot '" + name + "' has a link '" + link + "', and an object is named '" + name + "/" +
                            link + "'; rename one of them");
  RobotInstance instance{model,
                         checked_pose(base, "base of robot '" + name + "'"),
                         nearest_to_zero(*model),
                         model->default_other_positions(),
                         0.0,
                         {},
                         {}};
  for (const LinkGeometry& geometry : model->geometries()) {
    const bool moves = geometry.support != 0;
    auto [parts, field] = run_interruptibly([shape = geometry.shape, moves] {
      GeometryParts made = parts_of(shape);
      auto made_field = moves ? nullptr : make_distance_field(*shape, made.bvh.get());
      return std::pair(std::move(made), std::move(made_field));
    });
    instance.parts.push_back(std::move(parts));
    instance.fields.push_back(std::move(field));
  }
  robots_.emplace(name, std::move(instance));
}

void Scene::remove_robot(const std::string& robot) {
  find_robot(robot);
  const std::string name = robot;  // a copy, because the caller's string may be part of what is removed
  std::vector<std::string> attached;
  for (const auto& [object, attachment] : attachments_)
    if (attachment.robot == name) attached.push_back(object);
  for (const std::string& object : attached) detach_object(object);
  forget_allowed(name);
  robots_.erase(name);
}

void Scene::set_base_pose(const std::string& robot, const Pose& base) {
  find_robot(robot).base = checked_pose(base, "base of robot '" + robot + "'");
}

void Scene::set_qpos(const std::string& robot, ConstVector q) {
  RobotInstance& instance = find_robot(robot);
  instance.model->require_configuration(q, "qpos of robot '" + robot + "'");
  if (const auto violation = instance.model->limit_violation(q))
    throw InvalidArgument("qpos of robot '" + robot + "': " + *violation);
  instance.q = q;
}

void Scene::set_joint_positions(const std::string& robot, const std::map<std::string, double>& positions) {
  RobotInstance& instance = find_robot(robot);
  const RobotModel& model = *instance.model;
  Eigen::VectorXd q = instance.q, others = instance.other_positions;
  for (const auto& [joint, value] : positions) {
    if (assign_joint(model.joints(), joint, value, robot, q)) continue;
    if (assign_joint(model.other_joints(), joint, value, robot, others)) continue;
    model.refuse_joint(joint);
  }
  instance.q = std::move(q);
  instance.other_positions = std::move(others);
}

void Scene::set_robot_padding(const std::string& robot, double padding) {
  find_robot(robot).padding = checked_padding(padding, "robot '" + robot + "'");
}

const RobotInstance& Scene::robot(const std::string& name) const {
  const auto it = robots_.find(name);
  if (it == robots_.end()) refuse_unknown("robot", name, robot_names());
  return it->second;
}

RobotInstance& Scene::find_robot(const std::string& name) {
  return const_cast<RobotInstance&>(std::as_const(*this).robot(name));
}

std::vector<std::string> Scene::robot_names() const { return keys(robots_); }

Pose Scene::link_pose(const std::string& robot_name, const std::string& link) const {
  const RobotInstance& instance = robot(robot_name);
  const std::size_t index = instance.model->link_index(link);
  const RobotDataPtr data = instance.model->make_data(instance.other_positions);
  instance.model->forward(*data, instance.q);
  return instance.base * Pose::from_isometry(instance.model->link_pose(*data, index));
}

// --- objects

void Scene::add_object(const std::string& name, const Shape& shape, const Pose& pose, double padding) {
  require_new_name(name, "object");
  for (const auto& [robot, instance] : robots_)
    if (name.starts_with(robot + "/") && has_link(*instance.model, name.substr(robot.size() + 1)))
      throw InvalidArgument("object name '" + name + "' is the name of a link of robot '" + robot +
                            "'; choose another name");
  const std::string owner = "object '" + name + "'";
  Object object{
      name, shape, nullptr, {}, nullptr, checked_pose(pose, "pose of " + owner), checked_padding(padding, owner)};
  build_geometry(object);
  objects_.emplace(name, std::move(object));
}

void Scene::remove_object(const std::string& name) {
  find_object(name);
  const std::string copy = name;  // because the caller's string may be part of what is removed
  attachments_.erase(copy);
  forget_allowed(copy);
  objects_.erase(copy);
  std::erase_if(groups_, [&](const auto& entry) { return entry.second.objects.front() == copy; });
  for (auto& [id, group] : groups_) std::erase(group.objects, copy);
}

void Scene::set_object_pose(const std::string& name, const Pose& pose) {
  Object& object = find_object(name);
  if (const auto it = attachments_.find(name); it != attachments_.end())
    throw InvalidArgument("object '" + name + "' is attached to link '" + it->second.link + "' of robot '" +
                          it->second.robot + "'; detach it before moving it");
  object.pose = checked_pose(pose, "pose of object '" + name + "'");
}

void Scene::set_padding(const std::string& name, double padding) {
  find_object(name).padding = checked_padding(padding, "object '" + name + "'");
}

const Object& Scene::object(const std::string& name) const {
  const auto it = objects_.find(name);
  if (it == objects_.end()) refuse_unknown("object", name, object_names());
  return it->second;
}

Object& Scene::find_object(const std::string& name) { return const_cast<Object&>(std::as_const(*this).object(name)); }

std::vector<std::string> Scene::object_names() const { return keys(objects_); }

Pose Scene::object_pose(const std::string& name) const {
  const Object& body = object(name);
  const auto it = attachments_.find(name);
  return it == attachments_.end() ? body.pose : link_pose(it->second.robot, it->second.link) * body.pose;
}

void Scene::set_group(const std::string& id, const ObjectGroup& group) {
  const std::string owner = "group '" + id + "'";
  if (group.objects.empty()) throw InvalidArgument(owner + " has no objects; give at least one");
  for (const std::string& name : group.objects) object(name);
  ObjectGroup checked{group.objects, checked_pose(group.frame, "frame of " + owner), {}};
  for (const auto& [name, pose] : group.subframes)
    checked.subframes.emplace(name, checked_pose(pose, "subframe '" + name + "' of " + owner));
  groups_.insert_or_assign(id, std::move(checked));
}

// --- attachments

void Scene::attach_object(const std::string& name, const std::string& robot_name, const std::string& link,
                          const std::vector<std::string>& touch_links, const std::optional<Pose>& pose_in_link) {
  Object& body = find_object(name);
  if (const auto it = attachments_.find(name); it != attachments_.end())
    throw InvalidArgument("object '" + name + "' is already attached to link '" + it->second.link + "' of robot '" +
                          it->second.robot + "'; detach it first");
  const RobotModel& model = *robot(robot_name).model;
  model.link_index(link);
  for (const std::string& touched : touch_links) model.link_index(touched);
  Attachment attachment{robot_name, link, {touch_links.begin(), touch_links.end()}};
  attachment.touch_links.insert(link);
  const Pose pose = pose_in_link ? checked_pose(*pose_in_link, "pose of object '" + name + "' in link '" + link + "'")
                                 : link_pose(robot_name, link).inverse() * body.pose;
  attachments_.emplace(name, std::move(attachment));
  body.pose = pose;
}

void Scene::detach_object(const std::string& name) {
  Object& body = find_object(name);
  if (!attachments_.contains(name))
    throw InvalidArgument("object '" + name + "' is not attached; attached are " + quoted_list(keys(attachments_)));
  body.pose = object_pose(name);
  attachments_.erase(name);
}

// --- allowed collisions

Scene::Body Scene::find_body(const std::string& name) const {
  if (objects_.contains(name)) return {name, "", ""};
  if (robots_.contains(name)) return {"", name, ""};
  for (std::size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    const auto it = robots_.find(name.substr(0, slash));
    if (it != robots_.end() && has_link(*it->second.model, name.substr(slash + 1)))
      return {"", it->first, name.substr(slash + 1)};
  }
  std::vector<Body> candidates;
  std::vector<std::string> known = object_names();
  for (const auto& [robot, instance] : robots_) {
    known.push_back(robot);
    for (const std::string& link : instance.model->link_names()) {
      if (link == name) candidates.push_back({"", robot, link});
      known.push_back(name.find('/') == std::string::npos ? link : robot + "/" + link);
    }
  }
  if (candidates.size() == 1) return candidates.front();
  if (candidates.empty())
    throw InvalidArgument("unknown object, robot or link '" + name + "'" + did_you_mean(name, known));
  std::vector<std::string> full_names;
  for (const Body& candidate : candidates) full_names.push_back(candidate.key());
  throw InvalidArgument("link name '" + name + "' is ambiguous: " + quoted_list(full_names) +
                        " have it; give the full name");
}

std::string Scene::resolve_body(const std::string& name) const { return find_body(name).key(); }

void Scene::set_allowed_collision(const std::string& name_a, const std::string& name_b, bool allowed) {
  const Body a = find_body(name_a), b = find_body(name_b);
  if (a.key() == b.key() && !a.whole_robot())
    throw InvalidArgument("set_allowed_collision: '" + name_a + "' and '" + name_b + "' are the same body");
  // The call replaces settings of the bodies themselves and, for a whole robot, of its links.
  const auto replaces = [&](const Body& body, const std::string& key) {
    return key == body.key() || (body.whole_robot() && is_link_of(body.robot, key));
  };
  std::erase_if(allowed_, [&](const auto& entry) {
    const auto& [first, second] = entry.first;
    return (replaces(a, first) && replaces(b, second)) || (replaces(a, second) && replaces(b, first));
  });
  allowed_.emplace(ordered(a.key(), b.key()), allowed);
}

std::optional<bool> Scene::explicit_setting(const Body& a, const Body& b) const {
  const auto find = [&](const std::string& first, const std::string& second) -> std::optional<bool> {
    const auto it = allowed_.find(ordered(first, second));
    return it == allowed_.end() ? std::nullopt : std::optional(it->second);
  };
  if (allowed_.empty()) return std::nullopt;
  if (const auto exact = find(a.key(), b.key())) return exact;
  std::optional<bool> setting_a, setting_b;
  if (a.is_link()) setting_a = find(a.robot, b.key());
  if (b.is_link()) setting_b = find(a.key(), b.robot);
  if (setting_a && setting_b) return *setting_a && *setting_b;
  if (setting_a) return setting_a;
  if (setting_b) return setting_b;
  if (a.is_link() && b.is_link()) return find(a.robot, b.robot);
  return std::nullopt;
}

bool Scene::allowed_by_rule(const Body& a, const Body& b) const {
  if (a.is_link() && b.is_link()) return a.robot == b.robot && robot(a.robot).model->allowed(a.link, b.link);
  if (a.is_link() == b.is_link()) return false;
  const Body& link = a.is_link() ? a : b;
  const auto it = attachments_.find(a.is_link() ? b.object : a.object);
  return it != attachments_.end() && it->second.robot == link.robot && it->second.touch_links.contains(link.link);
}

bool Scene::allowed_collision(const std::string& name_a, const std::string& name_b) const {
  const Body a = find_body(name_a), b = find_body(name_b);
  const auto parts = [&](const Body& body) {
    if (!body.whole_robot()) return std::vector<Body>{body};
    std::vector<Body> links;
    for (const std::string& link : robot(body.robot).model->link_names()) links.push_back({"", body.robot, link});
    return links;
  };
  for (const Body& part_a : parts(a))
    for (const Body& part_b : parts(b)) {
      if (part_a.key() == part_b.key()) continue;  // a body never collides with itself
      if (!explicit_setting(part_a, part_b).value_or(allowed_by_rule(part_a, part_b))) return false;
    }
  return true;
}

bool Scene::is_link_of(const std::string& robot, const std::string& key) const {
  return key.starts_with(robot + "/") && robots_.contains(robot) && !objects_.contains(key);
}

void Scene::forget_allowed(const std::string& body) {
  const auto mentions = [&](const std::string& key) { return key == body || is_link_of(body, key); };
  std::erase_if(allowed_,
                [&](const auto& entry) { return mentions(entry.first.first) || mentions(entry.first.second); });
}

void Scene::follow_objects(const Scene& other, const std::set<std::string>& names) {
  for (const std::string& name : names)
    if (attachments_.contains(name) || other.attachments_.contains(name))
      throw InvalidArgument("object '" + name + "' is attached; a scene follows only objects that no robot holds");
  for (const std::string& name : names)
    if (const auto found = other.objects_.find(name); found == other.objects_.end()) {
      objects_.erase(name);
    } else if (const auto own = objects_.find(name);
               own != objects_.end() && own->second.geometry == found->second.geometry) {
      own->second.pose = found->second.pose;  // not the shape, which may be large
      own->second.padding = found->second.padding;
    } else {
      objects_.insert_or_assign(name, found->second);
    }
  groups_ = other.groups_;
  allowed_ = other.allowed_;
}

void Scene::reset() { *this = Scene(); }

}  // namespace srmp
