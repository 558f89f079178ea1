#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "srmp/collision/timed_checker.hpp"
#include "srmp/core/error.hpp"
#include "srmp/planning/goal.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/planning/request.hpp"
#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/planning/user_heuristic.hpp"
#include "srmp/planning/verify.hpp"
#include "srmp/robot/inverse_kinematics.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/trajectory/multi_trajectory.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

namespace io {
struct RequestFile;
}

/// The door to everything: a world of robots and objects, and planners for them. The Python class has the same words.
///
/// All poses are in the world frame, lengths in metres, angles in radians; objects are solid. A refused call throws
/// InvalidArgument and changes nothing. Not thread-safe: one thread at a time.
class PlannerInterface {
 public:
  PlannerInterface();
  ~PlannerInterface();
  PlannerInterface(PlannerInterface&&) noexcept;
  PlannerInterface& operator=(PlannerInterface&&) noexcept;

  // --- robots
  void add_articulation(const RobotDescription& description, const Pose& base = {});
  void remove_articulation(const std::string& robot);
  void set_base_pose(const std::string& robot, const Pose& pose);
  void set_qpos(const std::string& robot, ConstVector q);
  void set_joint_positions(const std::string& robot, const std::map<std::string, double>& positions);

  // --- objects
  void add_box(const std::string& name, const Eigen::Vector3d& size, const Pose& pose, double padding = 0.0);
  void add_sphere(const std::string& name, double radius, const Pose& pose, double padding = 0.0);
  void add_cylinder(const std::string& name, double radius, double length, const Pose& pose, double padding = 0.0);
  void add_capsule(const std::string& name, double radius, double length, const Pose& pose, double padding = 0.0);
  void add_cone(const std::string& name, double radius, double length, const Pose& pose, double padding = 0.0);
  void add_mesh(const std::string& name, const std::string& path, const Pose& pose,
                const Eigen::Vector3d& scale = {1, 1, 1}, bool convex = false, double padding = 0.0);
  void add_mesh(const std::string& name, const Mesh& mesh, const Pose& pose, double padding = 0.0);
  /// Every point fills a voxel with edges of `resolution`. With `self_filter_distance` [m], points no farther than that
  /// from a robot, where set_qpos put it, or from what it holds are left out (points_clear_of_robots).
  void add_point_cloud(const std::string& name, const std::vector<Eigen::Vector3d>& points, double resolution,
                       const Pose& pose = {}, double padding = 0.0, std::optional<double> self_filter_distance = {});
  void remove_object(const std::string& name);
  void set_object_pose(const std::string& name, const Pose& pose);
  void set_padding(const std::string& name, double padding);
  void attach_object(const std::string& object, const std::string& robot, const std::string& link,
                     const std::vector<std::string>& touch_links = {}, const std::optional<Pose>& pose_in_link = {});
  void detach_object(const std::string& object);
  void set_allowed_collision(const std::string& a, const std::string& b, bool allowed = true);
  /// Adds the collision objects of a MoveIt scene file, all or none.
  void load_moveit_scene(const std::string& path);
  /// Adds and attaches the objects that a request's start state holds, all or none.
  void attach_moveit_objects(const io::RequestFile& request);
  void reset();  ///< removes robots, objects, planners and heuristics

  // --- files (docs/files.md): JSON, written whole or not at all; numbers read back bit for bit
  /// Writes the whole problem: the scene with its robots, planners, motion limits that were set, and the request of
  /// the last plan or plan_multi with its result, if nothing was changed since. Throws FileError when it cannot be
  /// written, and InvalidArgument when a planner names a heuristic of add_heuristic.
  void save(const std::string& path) const;
  /// As it was saved: planning again gives the same trajectory, get_planning_stats and last_result are the saved ones.
  /// Of a scene file: the scene.
  /// Only meshes of robots are other files: they are looked for where they were, and in `package_dirs`. Throws
  /// FileError, with file and line, for anything missing, misspelt or wrong, another format, and newer versions.
  static PlannerInterface load(const std::string& path, const std::vector<std::string>& package_dirs = {});
  /// Writes the scene alone. Throws FileError.
  void save_scene(const std::string& path) const;
  /// Puts the scene of a scene or problem file in place of this one, or throws FileError, as load, and changes nothing.
  /// Planners and motion limits of robots that it has too stay; limits, if the joints are the same.
  void load_scene(const std::string& path, const std::vector<std::string>& package_dirs = {});

  // --- questions
  const Scene& scene() const;
  const RobotModel& robot(const std::string& name) const;
  std::vector<std::string> robot_names() const;
  std::vector<std::string> object_names() const;
  std::vector<std::string> get_joint_names(const std::string& robot) const;
  std::vector<std::string> get_link_names(const std::string& robot) const;
  Pose compute_fk(const std::string& robot, ConstVector q, const std::string& link = "") const;  ///< world frame
  /// 6 x dof, rows vx vy vz wx wy wz of the link's origin, world axes.
  Eigen::MatrixXd compute_jacobian(const std::string& robot, ConstVector q, const std::string& link = "") const;
  /// Within limits, nearest to `reference` (default: set_qpos) first; collisions are not looked at.
  std::vector<Eigen::VectorXd> compute_ik(const std::string& robot, const Pose& target,
                                          const std::optional<Eigen::VectorXd>& reference = {},
                                          const IkOptions& options = {}, const std::string& link = "") const;
  bool is_state_colliding(const std::string& robot, ConstVector q) const;
  std::vector<Contact> contacts(const std::string& robot, ConstVector q) const;
  bool is_motion_free(const std::string& robot, ConstVector a, ConstVector b) const;
  /// Distance of the nearest pair [m], negative in collision; infinity when there is nothing to collide with.
  double distance_to_collision(const std::string& robot, ConstVector q) const;
  std::optional<Contact> nearest(const std::string& robot, ConstVector q) const;
  /// A checker of the scene as it is now, for many questions; later changes of the scene do not reach it.
  std::shared_ptr<const Checker> collision_checker(const std::string& robot, CheckMode mode = CheckMode::exact) const;
  /// The same among other robots whose motions are known; robots not named stand still.
  std::shared_ptr<const TimedChecker> timed_collision_checker(const std::string& robot,
                                                              const std::map<std::string, TimedPath>& others,
                                                              CheckMode mode = CheckMode::exact) const;

  // --- limits and proofs
  /// What the joints may do: velocities of the URDF, and default_limits for the rest, until set_motion_limits.
  MotionLimits motion_limits(const std::string& robot) const;
  /// Velocities, accelerations and jerks of every joint, for all plans that follow; which joints are continuous is
  /// known from the model.
  void set_motion_limits(const std::string& robot, MotionLimits limits);
  /// Limits of a MoveIt joint_limits.yaml in place of those that were set (io/joint_limits.hpp, which says what is read
  /// and what is refused). Returns the joints in it that are no planned ones: they were not used.
  std::vector<std::string> load_joint_limits(const std::string& robot, const std::string& path);
  /// Looks over any trajectory of the robot, in the scene as it is: limits at every instant, collisions between rows
  /// too, start and goals (certify). Faults are found, not thrown. Throws InvalidArgument for options that do not suit
  /// the robot.
  Certificate verify(const std::string& robot, const Trajectory& trajectory, const VerifyOptions& options = {}) const;
  /// The same of many robots that move on one clock, by name: each is held against the others too, which rest where
  /// their motions end. Robots not named stand still. Throws InvalidArgument for options that do not suit the robots.
  std::map<std::string, Certificate> verify_multi(const MultiTrajectory& trajectory,
                                                  const MultiVerifyOptions& options = {}) const;

  // --- heuristics of the user
  /// From now on `name` may stand where options ask for a heuristic, for any robot. With it, bounds are proven only if
  /// it is said to be `consistent`. It must not use this PlannerInterface, which is planning when it is asked.
  void add_heuristic(const std::string& name, HeuristicFunction function, bool consistent = false);
  void remove_heuristic(const std::string& name);  ///< planners that name it refuse to plan
  std::vector<std::string> heuristic_names() const;

  // --- planning
  /// Chooses the planner for these robots from the paper's dictionary ("planner_id", "time_limit", …) or typed options.
  void make_planner(const std::vector<std::string>& robots, const OptionMap& options);
  void make_planner(const std::vector<std::string>& robots, const PlannerOptions& options);
  const PlannerOptions& planner_options(const std::vector<std::string>& robots) const;

  /// Asked during a plan, at most every 10 ms: true stops it with Status::cancelled.
  using Interrupt = Deadline::Interrupt;

  /// A timed, collision-free trajectory of one robot from `start` to any of `goals`; other robots stand still. Throws
  /// PlanningError with a typed status and a sentence when there is none.
  Trajectory plan(const std::string& robot, ConstVector start, const std::vector<GoalConstraint>& goals,
                  const Interrupt& interrupt = {}, const OnSolution& on_solution = {});
  Trajectory plan(const std::string& robot, ConstVector start, const GoalConstraint& goal,
                  const Interrupt& interrupt = {}, const OnSolution& on_solution = {});
  using Progress = PlanProgress;

  /// Many plans at once in the scene as it is, each by itself; `threads` (> 0; default: one a core) share them out.
  ///
  /// Results are in the order of the requests, and each is what plan alone would have found, bit for bit, for any
  /// number of threads. A request that has no trajectory does not disturb the others. Every request has its own time
  /// limit, which begins with its own plan; only a limit that cuts a plan short can make a difference, the sooner the
  /// more threads share a core. Once `interrupt` says so, all that is not finished ends with Status::cancelled.
  /// `progress` and `interrupt` are called in the caller's thread; what they throw ends the call. Throws
  /// InvalidArgument, before anything is planned where it can, for wrong requests (with their number).
  /// get_planning_stats stays as it was.
  std::vector<PlanResult> plan_many(const std::vector<PlanRequest>& requests, std::optional<int> threads = {},
                                    const Interrupt& interrupt = {}, const Progress& progress = {});

  /// Motions of many robots together, on one clock, from `starts` to `goals`, both by robot name: collision-free among
  /// each other too. A robot with a start and no goal holds still, as with GoalConstraint::hold; robots without a start
  /// stand where set_qpos put them. Every trajectory has a certificate that covers the others, those of robots that
  /// hold too. Planned by the planner that make_planner chose for the robots of `starts`. Throws
  /// PlanningError with a typed status and a sentence when there are none, InvalidArgument for a goal without a start,
  /// and when no robot is to move.
  ///
  /// `obstacles`: timed motions that other robots of the scene are committed to. They begin at time 0 too, the robots
  /// rest where they end, and are not asked to move. The planned motions end among them so. They begin, all together,
  /// as soon as they get by; or, where that fails or is late, each robot moves and waits as suits the others. Every
  /// wait is explicit (planner/multi_arm/committed.hpp, which says what is refused). Starts where a committed motion
  /// begins are `start_invalid` (where one ends too, unless the robot can leave before), goals where one ends
  /// `goal_invalid`; `exhausted` names links and time when no motions are found.
  MultiTrajectory plan_multi(const std::map<std::string, Eigen::VectorXd>& starts,
                             const std::map<std::string, GoalConstraint>& goals,
                             const std::map<std::string, Trajectory>& obstacles = {}, const Interrupt& interrupt = {});
  /// Of the last plan, solved or not; status `exhausted` with zeros before the first.
  const PlanStatistics& get_planning_stats() const;
  /// What the last plan or plan_multi was asked, without options: those of make_planner count. None before the first,
  /// and once one of its robots or the scene was replaced.
  const std::optional<LastRequest>& last_request() const;
  /// What became of it: a PlanResult of a PlanRequest, a MultiPlanResult of a MultiPlanRequest. None before the first,
  /// and once scene or planner were changed: then it may be another one.
  const std::optional<LastResult>& last_result() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srmp
