#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/scene/shape.hpp"

namespace srmp {

class DistanceField;
class PrimitiveBvh;

/// What a checker asks before a geometry, or in its place.
struct GeometryParts {
  std::shared_ptr<const coal::CollisionGeometry> hull;  ///< outer_hull(geometry)
  std::shared_ptr<const PrimitiveBvh> pieces;           ///< make_primitive_bvh(geometry)
};

/// Something in the world that is not a robot.
struct Object {
  std::string name;
  Shape shape;
  std::shared_ptr<const coal::CollisionGeometry> geometry;  ///< of shape
  GeometryParts parts;                                      ///< of geometry
  std::shared_ptr<const DistanceField> field;               ///< of geometry; nullptr where the distance is a formula
  Pose pose;                                                ///< in the world; once attached: in the link's frame
  double padding{0.0};                                      ///< [m], >= 0: kept clear around the object
};

/// An object that moves with a link.
struct Attachment {
  std::string robot;
  std::string link;
  std::set<std::string> touch_links;  ///< links of that robot it may touch (always holds `link`)
};

/// A robot in the world.
struct RobotInstance {
  std::shared_ptr<const RobotModel> model;
  Pose base;                         ///< of the URDF's root link, in the world
  Eigen::VectorXd q;                 ///< planned joints, where the robot stands now
  Eigen::VectorXd other_positions;   ///< RobotModel::other_joints
  double padding{0.0};               ///< [m] around every link, towards everything but the robot itself
  std::vector<GeometryParts> parts;  ///< of each of model->geometries()
  /// Of each that no planned joint moves; nullptr of the others, and where the distance is a formula.
  std::vector<std::shared_ptr<const DistanceField>> fields;
};

/// Robots, objects, attachments and allowed collisions: the planning world. Every mutator checks first and changes
/// after, so a refused call leaves the scene as it was. Copies are cheap enough to serve as snapshots: models and
/// geometry are shared and const.
///
/// Bodies are named: an object by its name, a link as "robot/link" or, where only one robot has it, "link"; a robot's
/// name stands for all its links. Objects and robots share one set of names, and those come before a bare link name.
class Scene {
 public:
  /// The robot starts with every planned joint at the value nearest to 0 within its limits.
  void add_robot(std::shared_ptr<const RobotModel> model, const Pose& base = {});
  void remove_robot(const std::string& robot);  ///< lets go of what it holds; forgets its allowed collisions
  void set_base_pose(const std::string& robot, const Pose& base);
  /// Planned joints, checked for size, NaN and limits.
  void set_qpos(const std::string& robot, ConstVector q);
  /// Any scalar joint of the robot by name, planned or not.
  void set_joint_positions(const std::string& robot, const std::map<std::string, double>& positions);
  void set_robot_padding(const std::string& robot, double padding);

  void add_object(const std::string& name, const Shape& shape, const Pose& pose, double padding = 0.0);
  void remove_object(const std::string& name);  ///< detaches it first; forgets its allowed collisions
  void set_object_pose(const std::string& name, const Pose& pose);  ///< not while attached
  void set_padding(const std::string& name, double padding);

  /// The object keeps its pose in the hand: `pose_in_link` when given, else where it is now (robot at its set_qpos).
  void attach_object(const std::string& object, const std::string& robot, const std::string& link,
                     const std::vector<std::string>& touch_links = {}, const std::optional<Pose>& pose_in_link = {});
  void detach_object(const std::string& object);  ///< stays in the world where the hand holds it now

  /// Overrides every other rule for the two bodies, either way. A later call wins over the earlier ones it covers: a
  /// setting for a whole robot replaces those of its links. Where two settings of equal reach differ, contact counts.
  void set_allowed_collision(const std::string& a, const std::string& b, bool allowed = true);
  /// Is contact between the two bodies ignored? The calls above, else the robot's self-collision rules and touch links.
  /// With a robot's name: for all its links.
  bool allowed_collision(const std::string& a, const std::string& b) const;

  /// What set_allowed_collision said and is still in force, by names as find the bodies: setting them anew in this
  /// order says the same again.
  const std::map<std::pair<std::string, std::string>, bool>& allowed_settings() const { return allowed_; }

  const std::map<std::string, RobotInstance>& robots() const { return robots_; }
  const std::map<std::string, Object>& objects() const { return objects_; }
  const std::map<std::string, Attachment>& attachments() const { return attachments_; }
  const RobotInstance& robot(const std::string& name) const;  ///< throws InvalidArgument with the nearest name
  const Object& object(const std::string& name) const;        ///< throws InvalidArgument with the nearest name
  std::vector<std::string> robot_names() const;
  std::vector<std::string> object_names() const;
  Pose link_pose(const std::string& robot, const std::string& link) const;  ///< in the world, robot at its set_qpos
  Pose object_pose(const std::string& object) const;                        ///< in the world, attached or not

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
  std::map<std::string, Attachment> attachments_;
  std::map<std::pair<std::string, std::string>, bool> allowed_;  // ordered pair of resolved names
};

}  // namespace srmp
