#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "srmp/planning/goal.hpp"
#include "srmp/planning/request.hpp"
#include "srmp/trajectory/path_constraint.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// What a segment of a sequence does.
enum class SegmentType {
  move,     ///< moves to one of several goals, as PlannerInterface::plan
  linear,   ///< moves a link along a straight line, as PlannerInterface::plan_linear
  follow,   ///< moves a link along poses, as PlannerInterface::follow
  attach,   ///< attaches an object, as PlannerInterface::attach_object
  detach,   ///< detaches an object, as PlannerInterface::detach_object
  allow,    ///< allows collisions of two, or forbids them again, as PlannerInterface::set_allowed_collision
  joints,   ///< sets joints that are not planned, such as a gripper's, as PlannerInterface::set_joint_positions
  wait,     ///< stands still
  gripper,  ///< moves an end effector of the SRDF to a state or an opening width
};

/// The name in messages: "move", "linear", "follow", "attach", "detach", "allow", "joints", "wait" or "gripper".
std::string_view to_string(SegmentType type);

/// A segment of a sequence (PlannerInterface::plan_sequence). Make one with the functions below, then set the fields
/// that are left.
struct Segment {
  SegmentType type{SegmentType::move};        ///< what it does
  std::vector<Goal> goals{};                  ///< move: any one of them is enough
  std::vector<PathConstraint> constraints{};  ///< of motions, at every instant, with those of `cartesian`
  /// move: [m] >= 0, at its end. Above 0, and with a move to follow, the motion does not stop there but passes its end
  /// at a distance of at most this, and of the planner's blend_deviation, of any point of the robot.
  double blend_radius{};
  std::vector<Pose> poses{};                  ///< linear: one; follow: in order; world frame
  std::optional<Eigen::Vector3d> offset{};    ///< linear: instead of a pose, by how far [m], world frame
  CartesianOptions cartesian{};               ///< linear, follow
  std::string object{};                       ///< attach, detach: its name; allow: the first of two objects or links
  std::string other{};                        ///< allow: the second
  bool allowed{true};                         ///< allow: false forbids
  std::string link{};                         ///< attach: to which
  std::vector<std::string> touch_links{};     ///< attach: links that the object may touch besides
  std::optional<Pose> pose_in_link{};         ///< attach: of the object; none: as it is then
  std::map<std::string, double> positions{};  ///< joints: by joint name [rad or m]
  double duration{};                          ///< joints, wait, gripper: [s] >= 0, in which the planned joints rest
  std::string end_effector{};                 ///< gripper: of the SRDF; "" = the only one
  std::string state{};                        ///< gripper: of its group in the SRDF
  std::optional<double> width{};              ///< gripper: instead of a state, its opening [m], see GripperOpening

  /// A motion to a goal.
  static Segment move(const Goal& goal);
  /// A straight line of the end effector to a pose in the world frame.
  static Segment linear(const Pose& goal);
  /// A straight line of the end effector by an offset [m] in the world frame, without a turn.
  static Segment linear(const Eigen::Vector3d& offset);
  /// The end effector passes poses in the world frame.
  static Segment follow(const std::vector<Pose>& poses);
  /// Attaches the object to a link, where it is then.
  static Segment attach(const std::string& object, const std::string& link,
                        const std::vector<std::string>& touch_links = {});
  /// Detaches the object: it stays where it is then.
  static Segment detach(const std::string& object);
  /// Two objects or links may touch from here on, such as an object and what it stands on, or may no longer.
  static Segment allow(const std::string& object, const std::string& other, bool allowed = true);
  /// Sets joints that are not planned, for which the robot rests this long [s].
  static Segment joints(const std::map<std::string, double>& positions, double duration = 0.5);
  /// The robot rests [s].
  static Segment wait(double duration);
  /// An end effector of the SRDF ("" = the only one) moves to a state of its group, while the robot rests this long
  /// [s]. "open" and "close" exist where it has an opening width, also without states of these names.
  static Segment gripper(const std::string& state, const std::string& end_effector = "", double duration = 0.5);
  /// The fingers of an end effector of the SRDF ("" = the only one) open to a width [m], see GripperOpening.
  static Segment gripper(double width, const std::string& end_effector = "", double duration = 0.5);

  /// Does the robot move?
  bool moves() const { return type <= SegmentType::follow; }
};

/// What a segment became.
struct SequencePart {
  SegmentType type{};     ///< of the segment
  double begin{}, end{};  ///< [s] of the whole motion; the same for what takes no time
  /// The motion by itself, with times from 0 and its own certificate, in the scene as it is then; no rows: none.
  Trajectory motion{};
};

/// The result of PlannerInterface::plan_sequence.
struct SequenceResult {
  /// All motions and rests in a row, with a certificate: the claims of each part in the scene as it is then.
  Trajectory trajectory;
  std::vector<SequencePart> parts;  ///< one for each segment
};

}  // namespace srmp
