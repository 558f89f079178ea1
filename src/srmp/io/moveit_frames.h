#pragma once

// Internal: what the names of frames and links in MoveIt's files mean in a scene.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "srmp/io/moveit.hpp"

namespace srmp::io {

/// A frame, as it is placed now.
struct Frame {
  Pose pose;                ///< in the world
  std::string robot, link;  ///< the link that it moves with; "" = it stands still
};

/// Finds frames by name, the first of: a link of `robot`, the link of the only robot that has it, or "robot/link"; an
/// object group's id or "id/subframe"; another object; a frame that the file defines; and the planning frame, which is
/// called "", "world" or by the parent frame of a virtual joint. A leading '/' is left out, as early ROS 1 has it.
class FrameLookup {
 public:
  /// `robot` is preferred where several have a link; "" = none is. The scene must outlive this and may change.
  FrameLookup(const Scene& scene, const Pose& planning_frame, std::string robot = "");

  /// From now on this robot stands at q, whose limits are not checked, instead of its set_qpos.
  void set_configuration(const std::string& robot, const Eigen::VectorXd& q);
  /// Defines the file's frames, in this order. Throws InvalidArgument for one between frames that are both unknown.
  void define(const std::vector<FixedFrame>& frames);

  const Pose& planning_frame() const { return planning_frame_; }
  /// nullopt: there is none of this name. Throws InvalidArgument for a link that several robots have.
  std::optional<Frame> find(const std::string& name) const;
  /// The same; throws InvalidArgument, which begins with `what`, with the nearest known name.
  Frame require(const std::string& name, const std::string& what) const;
  /// Does the frame move when the planned joints of its robot do?
  bool moves(const Frame& frame) const;

  /// The robot that a file's link belongs to; throws InvalidArgument, which begins with `what`.
  std::string robot_of(const std::string& link, const std::string& what) const;
  Pose link_pose(const std::string& robot, const std::string& link) const;
  /// Of an object, attached or not.
  Pose object_pose(const std::string& object) const;

 private:
  std::optional<Frame> find_link(const std::string& name) const;
  std::optional<Frame> find_in_objects(const std::string& name) const;
  Frame of_object(const std::string& object, const Pose& in_object) const;
  bool is_planning_frame(const std::string& name) const;
  void define(const FixedFrame& frame);
  std::vector<std::string> known_names() const;

  const Scene& scene_;
  Pose planning_frame_;
  std::string robot_;
  std::map<std::string, Eigen::VectorXd> configurations_;  // by robot
  std::map<std::string, Pose> fixed_;                      // in the world
};

}  // namespace srmp::io
