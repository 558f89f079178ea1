#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "srmp/io/moveit.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// The codes of moveit_msgs/MoveItErrorCodes that a MoveItSession returns, with their numbers.
enum class MoveItErrorCode {
  success = 1,                            ///< there is a trajectory
  failure = 99999,                        ///< the robot's files cannot be read
  planning_failed = -1,                   ///< no path exists in the searched graph, or the request is not supported
  timed_out = -6,                         ///< the allowed planning time passed
  preempted = -7,                         ///< the caller stopped the plan
  start_state_in_collision = -10,         ///< the start is in collision
  start_violates_path_constraints = -11,  ///< the start breaks a path constraint
  start_state_invalid = -26,              ///< the start is outside of limits, incomplete, or too fast
  goal_in_collision = -12,                ///< every configuration that meets a goal is in collision
  goal_violates_path_constraints = -13,   ///< a configuration that meets a goal breaks a path constraint
  goal_state_invalid = -27,               ///< a joint goal is outside of limits
  invalid_group_name = -15,               ///< the robot has no such planning group
  invalid_goal_constraints = -16,         ///< a goal is wrong in itself, or not supported
  invalid_robot_state = -17,              ///< the scene's robot state is wrong
  invalid_link_name = -18,                ///< the robot has no such link
  invalid_object_name = -19,              ///< an object of the scene is wrong, or not there
  frame_transform_failure = -21,          ///< a frame is not known
  collision_checking_unavailable = -22,   ///< the scene holds what is not supported
  no_ik_solution = -31,                   ///< no configuration within limits meets a goal
};

/// The name in moveit_msgs/MoveItErrorCodes, such as "GOAL_IN_COLLISION".
std::string_view to_string(MoveItErrorCode code);

/// Limits of a joint of MoveIt's robot model, which joint_limits.yaml may have changed; what is missing is as in the
/// URDF.
struct MoveItJointBounds {
  std::optional<double> lower, upper;  ///< position [rad or m]
  std::optional<double> velocity;      ///< [rad/s or m/s], > 0
  std::optional<double> acceleration;  ///< [rad/s^2 or m/s^2], > 0
  std::optional<double> jerk;          ///< [rad/s^3 or m/s^3], > 0
};

/// MoveIt's robot model: the texts that it was made of, and its limits.
struct MoveItRobot {
  std::string urdf_text;                            ///< content of the parameter robot_description
  std::string srdf_text;                            ///< content of the parameter robot_description_semantic
  std::vector<std::string> package_dirs;            ///< searched for package:// meshes, after ROS's own directories
  std::map<std::string, MoveItJointBounds> bounds;  ///< by joint
};

/// The response to a motion plan request.
struct MoveItResponse {
  MoveItErrorCode code{MoveItErrorCode::failure};  ///< success: there is a trajectory
  std::string message;                             ///< why there is none, as a sentence; "" where there is one
  Trajectory trajectory;                           ///< of the group's joints, with times, velocities and accelerations
  PlanStatistics statistics;                       ///< what the plan did, and how long each phase took
  double planning_time{};                          ///< [s] from call to return
  std::string planner_id;                          ///< the planner of this library that was used
  std::vector<std::string> notes;                  ///< what the scene said and had no effect, as sentences
};

/// Plans MoveIt's requests in MoveIt's scenes for one robot; the plugin for MoveIt is a thin layer around it.
///
/// Robot models and their sphere covers are kept, and the scene is kept and changed only where a request's scene
/// differs from the last one: a request in an unchanged scene costs what PlannerInterface::plan costs. docs/moveit.md
/// says of every field of scene and request what it means and with which code it is refused. May be used by several
/// threads; requests wait for each other.
class MoveItSession {
 public:
  explicit MoveItSession(MoveItRobot robot);
  ~MoveItSession();
  MoveItSession(MoveItSession&&) noexcept;

  /// Sets the planner configurations, as in srmp_planning.yaml: options by name, "group[configuration]" or "group" for
  /// the group's default. Throws InvalidArgument, with the configuration's name, as parse_options does.
  void set_configurations(const std::map<std::string, OptionMap>& configurations);
  /// All ids that a request may name: those of the library, and "group[configuration]".
  std::vector<std::string> planner_ids() const;

  /// Plans. `scene` is a whole scene, not a difference. The start is the scene's robot state with the request's start
  /// state in place of what that names; a start state that is not a difference also says all that the robot holds. Once
  /// `stop` is true, which another thread may set, the plan ends within 20 ms with `preempted`. Bad requests are
  /// answered, not thrown.
  MoveItResponse solve(const io::SceneFile& scene, const io::RequestFile& request,
                       const std::atomic<bool>* stop = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srmp
