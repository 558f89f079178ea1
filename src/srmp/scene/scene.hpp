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

/// Something in the world that is not a robot.
struct Object {
  std::string name;
  Shape shape;
  std::shared_ptr<const coal::CollisionGeometry> geometry;  ///< of shape
  Pose pose;            ///< in the world; once attached: in the link's frame
  double padding{0.0};  ///< [m], >= 0: kept clear around the object
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
  Pose base;                       ///< of the URDF's root link, in the world
  Eigen::VectorXd q;               ///< planned joints, where the robot stands now
  Eigen::VectorXd other_positions; ///< RobotModel::other_joints
  double padding{0.0};             ///< [m] around every link
};

/// Robots, objects, attachments and allowed collisions: the planning world. Every mutator checks first and changes
/// after, so a refused call leaves the scene as it was. Copies are cheap enough to serve as snapshots: models and
/// geometry are shared and const.
///
/// Bodies are named: an object by its name, a link as "robot/link" or, where only one robot has it, "link".
class Scene {
 public:
  void add_robot(std::shared_ptr<const RobotModel> model, const Pose& base = {});
  void remove_robot(const std::string& robot);
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

  void set_allowed_collision(const std::string& a, const std::string& b, bool allowed = true);
  /// Is contact between the two bodies ignored? Robot self-collision rules, touch links and the calls above, together.
  bool allowed_collision(const std::string& a, const std::string& b) const;

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
  std::string resolve_body(const std::string& name) const;  // "robot/link" or object name, or throws

  std::map<std::string, RobotInstance> robots_;
  std::map<std::string, Object> objects_;
  std::map<std::string, Attachment> attachments_;
  std::map<std::pair<std::string, std::string>, bool> allowed_;  // ordered pair of resolved names
};

}  // namespace srmp
