#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "srmp/core/matrix.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/scene/geometry_parts.hpp"
#include "srmp/scene/shape.hpp"

namespace srmp {

class DistanceField;

/// A body of the scene that is not part of a robot.
struct Object {
  std::string name;                                         ///< unique in the scene
  Shape shape;                                              ///< as it was added
  std::shared_ptr<const coal::CollisionGeometry> geometry;  ///< of shape
  GeometryParts parts;                                      ///< of geometry
  std::shared_ptr<const DistanceField> field;               ///< of geometry; nullptr if the distance is a formula
  Pose pose;                                                ///< in the world; while attached, in the link's frame
  double padding{0.0};                                      ///< [m], >= 0: required clearance around the object
};

/// Objects that are one to a file (the shapes of a MoveIt collision object), and the frames that are fixed to them.
struct ObjectGroup {
  std::vector<std::string> objects;       ///< names of its objects, at least one
  Pose frame;                             ///< its frame, in the frame of the first of them
  std::map<std::string, Pose> subframes;  ///< further frames by name, in its frame
};

/// The link that an attached object moves with.
struct Attachment {
  std::string robot;                  ///< name of the robot that holds it
  std::string link;                   ///< the link that it moves with
  std::set<std::string> touch_links;  ///< links of this robot that may touch the object; `link` is always one
};

/// A robot in the scene.
struct RobotInstance {
  std::shared_ptr<const RobotModel> model;  ///< not null
  Pose base;                                ///< of the URDF's root link, in the world
  Eigen::VectorXd q;                        ///< positions of the planned joints, shape (dof,) [rad or m]
  Eigen::VectorXd other_positions;          ///< positions of RobotModel::other_joints [rad or m]
  double padding{0.0};                      ///< [m], >= 0: required clearance to other robots and objects
  std::vector<GeometryParts> parts;         ///< by geometry, in the order of model->geometries()
  /// By geometry: nullptr if a planned joint moves it or if its distance is a formula.
  std::vector<std::shared_ptr<const DistanceField>> fields;
};

/// The planning scene: robots, objects, attachments and the allowed collision matrix. A call that throws leaves the
/// scene unchanged. Copies are cheap enough to serve as snapshots, because models and geometry are shared and const. A
/// scene may be read by several threads, but not while one of them changes it.
///
/// Bodies have names: an object its own, a link "robot/link" or, if only one robot has such a link, "link"; the name of
/// a robot stands for all its links. Objects and robots share one namespace, which takes precedence over link names.
///
/// All functions with names throw InvalidArgument for unknown ones, with the nearest known name. Those with poses throw
/// it for NaN, infinity and zero quaternions; other quaternions are normalised.
class Scene {
 public:
  /// Adds a robot under model->name(), which must be new, with its base (the frame of the URDF's root link) at this
  /// pose in the world. Every planned joint starts at the value nearest to 0 within its limits.
  void add_robot(std::shared_ptr<const RobotModel> model, const Pose& base = {});
  /// Also detaches the objects of the robot and removes its entries of the allowed collision matrix.
  void remove_robot(const std::string& robot);
  /// Sets the pose of the base in the world.
  void set_base_pose(const std::string& robot, const Pose& base);
  /// Sets the planned joints, q of shape (dof,) [rad or m]. Throws InvalidArgument for another size, NaN, and positions
  /// outside of limits.
  void set_qpos(const std::string& robot, ConstVector q);
  /// Sets joints by name [rad or m], planned or not. Throws InvalidArgument for NaN and positions outside of limits.
  void set_joint_positions(const std::string& robot, const std::map<std::string, double>& positions);
  /// Sets RobotInstance::padding [m]. Throws InvalidArgument unless it is finite and >= 0.
  void set_robot_padding(const std::string& robot, double padding);

  /// Adds an object under a new name at `pose` in the world, with Object::padding. Throws InvalidArgument for a shape
  /// without volume or surface, sizes that are not positive and finite, and a padding out of range.
  void add_object(const std::string& name, const Shape& shape, const Pose& pose, double padding = 0.0);
  /// Also detaches the object and removes its entries of the allowed collision matrix.
  void remove_object(const std::string& name);
  /// Sets the pose in the world. Throws InvalidArgument while the object is attached.
  void set_object_pose(const std::string& name, const Pose& pose);
  /// Sets Object::padding [m]. Throws InvalidArgument unless it is finite and >= 0.
  void set_padding(const std::string& name, double padding);

  /// Makes objects one group under an id of its own, in place of an earlier group of this id. A group goes with its
  /// first object. Throws InvalidArgument for an unknown object or none.
  void set_group(const std::string& id, const ObjectGroup& group);

  /// Attaches an object to a link, so that it moves with it: at `pose_in_link` if given, otherwise at its current pose
  /// relative to the link (with the robot at its set_qpos). Contact with `link` and `touch_links` is allowed. Throws
  /// InvalidArgument when the object is already attached.
  void attach_object(const std::string& object, const std::string& robot, const std::string& link,
                     const std::vector<std::string>& touch_links = {}, const std::optional<Pose>& pose_in_link = {});
  /// Detaches an object, which stays at its current pose in the world. Throws InvalidArgument when it is not attached.
  void detach_object(const std::string& object);

  /// Sets whether contact between two bodies is allowed, in either order; this overrides all other rules. A setting for
  /// a whole robot replaces the earlier ones of its links. If a setting for a pair of robot and link contradicts one
  /// for the corresponding pair of link and robot, contact is not allowed. The name of a robot twice stands for all
  /// pairs of its links. Throws InvalidArgument for an object or link twice.
  void set_allowed_collision(const std::string& a, const std::string& b, bool allowed = true);
  /// Forgets all settings of set_allowed_collision.
  void clear_allowed_collisions() { allowed_.clear(); }
  /// Is contact between the two bodies ignored? Decided by set_allowed_collision, otherwise by the robot's
  /// self-collision rules and the touch links. For the name of a robot: is it ignored for all links?
  bool allowed_collision(const std::string& a, const std::string& b) const;

  /// The settings of set_allowed_collision that are in force, by names of bodies. Repeating these calls in this order
  /// in an equal scene gives equal settings.
  const std::map<std::pair<std::string, std::string>, bool>& allowed_settings() const { return allowed_; }

  /// Objects of these names become what they are in `other`: added, changed or removed. All groups and allowed
  /// collisions become those of `other`; robots and attachments stay. Throws InvalidArgument for an object that is
  /// attached in one of them.
  void follow_objects(const Scene& other, const std::set<std::string>& names);

  // --- the content, by name
  /// The robots by name.
  const std::map<std::string, RobotInstance>& robots() const { return robots_; }
  /// The objects by name, attached ones too.
  const std::map<std::string, Object>& objects() const { return objects_; }
  /// The groups of objects by id.
  const std::map<std::string, ObjectGroup>& groups() const { return groups_; }
  /// The attachments by object name.
  const std::map<std::string, Attachment>& attachments() const { return attachments_; }
  const RobotInstance& robot(const std::string& name) const;  ///< throws InvalidArgument with the nearest name
  const Object& object(const std::string& name) const;        ///< throws InvalidArgument with the nearest name
  std::vector<std::string> robot_names() const;               ///< in alphabetical order
  std::vector<std::string> object_names() const;              ///< in alphabetical order
  /// The pose of a link in the world, with the robot at its set_qpos.
  Pose link_pose(const std::string& robot, const std::string& link) const;
  /// The pose of an object in the world, attached or not.
  Pose object_pose(const std::string& object) const;

  void reset();  ///< removes everything

 private:
  struct Body;  // an object, a robot, or a link of a robot

  RobotInstance& find_robot(const std::string& name);
  Object& find_object(const std::string& name);
  void require_new_name(const std::string& name, const char* what) const;
  Body find_body(const std::string& name) const;            // throws with the nearest name or the candidates
  std::string resolve_body(const std::string& name) const;  // "robot/link", robot or object name, or throws
  std::optional<bool> explicit_setting(const Body& a, const Body& b) const;
  bool is_link_of(const std::string& robot, const std::string& key) const;
  bool allowed_by_rule(const Body& a, const Body& b) const;
  void forget_allowed(const std::string& body);

  std::map<std::string, RobotInstance> robots_;
  std::map<std::string, Object> objects_;
  std::map<std::string, ObjectGroup> groups_;
  std::map<std::string, Attachment> attachments_;
  std::map<std::pair<std::string, std::string>, bool> allowed_;  // ordered pair of resolved names
};

}  // namespace srmp
