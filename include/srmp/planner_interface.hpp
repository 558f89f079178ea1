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
#include "srmp/planning/sequence.hpp"
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
struct MoveItProblem;
class MoveItGroup;

/// A world of robots and objects, and the planners for them: the entry point of the library. The Python class has the
/// same methods.
///
/// Poses are in the world frame; lengths are in metres, angles in radians, times in seconds; objects are solid. A
/// configuration q has the robot's dof entries [rad or m], in the order of get_joint_names. A call that is refused
/// throws InvalidArgument and changes nothing: for unknown robots, objects or links (with the nearest known name),
/// wrong sizes, NaN and infinity. Not thread-safe: one thread at a time. One that was moved from may be assigned to and
/// destroyed, nothing else.
class PlannerInterface {
 public:
  PlannerInterface();
  ~PlannerInterface();
  PlannerInterface(PlannerInterface&&) noexcept;
  PlannerInterface& operator=(PlannerInterface&&) noexcept;

  // --- robots

  /// Adds a robot from a URDF and, where there is one, an SRDF; `base` is the pose of its root link in the world. The
  /// planned joints stand at the values nearest to 0 within their limits. Without an SRDF, adjacent links may touch,
  /// and so may links that touch with all joints at 0 and in more than 95 % of the sampled configurations
  /// (RobotModel::always_colliding). What was read but not used is in warnings(). Throws FileError (missing or broken
  /// file: line and place; a missing mesh lists every place tried) and InvalidArgument (a name in use; unknown group,
  /// joint or link).
  void add_articulation(const RobotDescription& description, const Pose& base = {});
  /// What was read but not used when the robot was added, as sentences: RobotModel::warnings.
  const std::vector<std::string>& warnings(const std::string& robot) const;
  /// Removes a robot, its planners and its attachments: what it held stays in the world.
  void remove_articulation(const std::string& robot);
  /// Makes one robot, `name`, of several that stand in the scene, to plan what they do together, such as holding one
  /// object in two hands: its joints and links are theirs, called "<robot>_<joint>" and "<robot>_<link>", one robot
  /// after the other. It stands as they did, holds what they held, may touch what they might, and has their motion
  /// limits; goals name their link. Planners of the robots are forgotten. Trajectory::of_joints gives each controller
  /// its part of a motion. Throws InvalidArgument for fewer than two robots, unknown or repeated ones, a name that
  /// another robot or an object has, joined names that are the same, different paddings, and more than one payload.
  void join_robots(const std::string& name, const std::vector<std::string>& robots);
  /// Places the robot's root link at its pose in the world.
  void set_base_pose(const std::string& robot, const Pose& pose);
  /// Sets the planned joints (dof,) [rad or m]: the robot stands there while others plan, and attach_object and
  /// detach_object use it. Throws InvalidArgument for a wrong size, NaN, or a joint outside its limits.
  void set_qpos(const std::string& robot, ConstVector q);
  /// Sets positions [rad or m] of any joints by name, planned or not (a gripper's, say); joints not named stay. Throws
  /// InvalidArgument for an unknown joint, NaN, or a joint outside its limits.
  void set_joint_positions(const std::string& robot, const std::map<std::string, double>& positions);

  // --- objects

  /// Adds a box with full edge lengths `size` (3,) [m]. For this and the other shapes: `pose` is that of the centre in
  /// the world, `padding` [m] is kept clear around the object, and InvalidArgument is thrown for a name in use and for
  /// sizes that are not positive and finite.
  void add_box(const std::string& name, const Eigen::Vector3d& size, const Pose& pose, double padding = 0.0);
  /// Adds a sphere of `radius` [m]; see add_box.
  void add_sphere(const std::string& name, double radius, const Pose& pose, double padding = 0.0);
  /// Adds a cylinder along z, `radius` and `length` [m]; see add_box.
  void add_cylinder(const std::string& name, double radius, double length, const Pose& pose, double padding = 0.0);
  /// Adds a capsule along z: a cylinder of `length` with a half sphere on each end [m]; see add_box.
  void add_capsule(const std::string& name, double radius, double length, const Pose& pose, double padding = 0.0);
  /// Adds a cone along z, base at -length/2, apex at +length/2 [m]; see add_box.
  void add_cone(const std::string& name, double radius, double length, const Pose& pose, double padding = 0.0);
  /// Adds a triangle mesh from the file `path`, multiplied by `scale` (3,); `pose` is that of its origin in the world,
  /// `padding` [m] is kept clear around it. A mesh is its surface; `convex` takes its solid convex hull instead. Throws
  /// FileError (missing, unreadable or empty file) and InvalidArgument (name in use, a scale that is not above 0).
  void add_mesh(const std::string& name, const std::string& path, const Pose& pose,
                const Eigen::Vector3d& scale = {1, 1, 1}, bool convex = false, double padding = 0.0);
  /// The same from vertices [m] and triangles of vertex numbers. Throws InvalidArgument for a name in use, NaN, and
  /// vertex numbers that do not exist.
  void add_mesh(const std::string& name, const Mesh& mesh, const Pose& pose, double padding = 0.0);
  /// Adds a point cloud (n, 3) [m]; every point fills a voxel with edges of `resolution` [m]. `pose` is that of its
  /// origin in the world; `padding` [m] is kept clear around it. With `self_filter_distance` [m], points no farther
  /// than that from a robot at its set_qpos, or from what it holds, are left out: a camera sees the robots too. Throws
  /// InvalidArgument for a name in use, no points (or none left), NaN, or a resolution or distance that is not above 0.
  void add_point_cloud(const std::string& name, const std::vector<Eigen::Vector3d>& points, double resolution,
                       const Pose& pose = {}, double padding = 0.0, std::optional<double> self_filter_distance = {});
  /// Removes an object, attached or not.
  void remove_object(const std::string& name);
  /// Moves an object to its pose in the world. Throws InvalidArgument while it is attached.
  void set_object_pose(const std::string& name, const Pose& pose);
  /// Keeps `padding` [m], >= 0, clear around an object, or around every link of a robot.
  void set_padding(const std::string& name, double padding);
  /// Attaches the object to a link, with which it moves from now on. It keeps its pose relative to the link (robot at
  /// its set_qpos), or takes `pose_in_link`. It may touch `link` and `touch_links`. Throws InvalidArgument for unknown
  /// names or an object that is attached already.
  void attach_object(const std::string& object, const std::string& robot, const std::string& link,
                     const std::vector<std::string>& touch_links = {}, const std::optional<Pose>& pose_in_link = {});
  /// Detaches the object; it stays in the world where the robot (at its set_qpos) holds it. Throws InvalidArgument when
  /// it is not attached.
  void detach_object(const std::string& object);
  /// Allows (or, with false, forbids again) contact of two bodies: objects, links ("link" or "robot/link"), whole
  /// robots. A later call replaces earlier ones that it covers.
  void set_allowed_collision(const std::string& a, const std::string& b, bool allowed = true);
  /// Changes the scene by a MoveIt scene file (YAML), wholly or not at all: robot states, objects, attached objects,
  /// allowed collisions, padding; io::apply says how. The planning frame of the file is the world. Returns what was not
  /// used, as sentences. Throws FileError with the line, and as io::apply.
  std::vector<std::string> load_moveit_scene(const std::string& path);
  /// Converts a MoveIt motion plan request (moveit_request.hpp) to a problem of `robot`. Its start state is set in this
  /// world: the base (by the virtual joint), movable joints that are not planned (a gripper's), and attached objects.
  ///
  /// Goals keep within MoveIt's tolerances: every state that meets a goal of the result meets the request's
  /// constraints. They may be for the end effector, any link or attached object that is rigidly joined to it, subframes
  /// of these, and points beside them.
  ///
  /// Throws InvalidArgument for names of frames, links, joints and groups that do not exist (with the nearest known
  /// one); and NotSupported for goals that cannot be stated here: some of the joints only, joints together with links,
  /// several constraints of one kind, links that are not joined to the end effector, frames that move with the planned
  /// joints, and points beside the end effector's origin without an orientation. It then changes nothing. Goals that
  /// cannot be reached are reported by plan.
  MoveItProblem apply_moveit_request(const std::string& robot, const io::RequestFile& request);
  /// Removes all robots, objects, planners and heuristics.
  void reset();

  // --- files (docs/files.md): JSON, written completely or not at all; numbers read back bit for bit

  /// Writes the whole problem: the scene with its robots, planners, motion limits that were set, and the request of
  /// the last plan or plan_multi with its result, if nothing was changed since. Throws FileError when it cannot be
  /// written, and InvalidArgument when a planner names a heuristic of add_heuristic.
  void save(const std::string& path) const;
  /// Reads a problem that was saved: planning again gives the same trajectory, get_planning_stats and last_result are
  /// the saved ones. A scene file gives the scene alone. Only meshes of robots are other files: they are looked for
  /// where they were, and in `package_dirs`. Throws FileError, with file and line, for anything missing, misspelt or
  /// wrong, another format, and newer versions.
  static PlannerInterface load(const std::string& path, const std::vector<std::string>& package_dirs = {});
  /// Writes the scene alone: robots, objects, attachments, allowed collisions. Throws FileError.
  void save_scene(const std::string& path) const;
  /// Replaces this scene by that of a scene or problem file. Planners and motion limits of robots that both have stay;
  /// limits only if the joints are the same. Throws FileError, as load, and changes nothing.
  void load_scene(const std::string& path, const std::vector<std::string>& package_dirs = {});

  // --- queries

  /// The scene as it is now; the reference stays valid, and follows later changes.
  const Scene& scene() const;
  /// The model of a robot, valid while the robot is here. Throws InvalidArgument for an unknown robot.
  const RobotModel& robot(const std::string& name) const;
  /// Names of the robots, sorted.
  std::vector<std::string> robot_names() const;
  /// The name of the only robot. Throws InvalidArgument where there is not exactly one.
  std::string only_robot() const;
  /// Names of the objects, attached ones too, sorted.
  std::vector<std::string> object_names() const;
  /// Names of the planned joints, in the order of q.
  std::vector<std::string> get_joint_names(const std::string& robot) const;
  /// Names of all links, the root first.
  std::vector<std::string> get_link_names(const std::string& robot) const;
  /// World pose of a link ("" = the end effector) at q (dof,) [rad or m]. Joint limits are not checked.
  Pose compute_fk(const std::string& robot, ConstVector q, const std::string& link = "") const;
  /// Jacobian (6, dof) of a link ("" = the end effector) at q (dof,): velocity vx, vy, vz of its origin and angular
  /// velocity wx, wy, wz, in world axes, per joint velocity.
  Eigen::MatrixXd compute_jacobian(const std::string& robot, ConstVector q, const std::string& link = "") const;
  /// Configurations that bring `link` ("" = the end effector) to the world pose `target`: within limits, nearest to
  /// `reference` (dof,) (default: set_qpos) first; empty when none was found. The same every time. Collisions are not
  /// checked. Damped least squares from several seeds (Sugihara 2011): see inverse_kinematics. Throws InvalidArgument
  /// for an unknown link, a wrong size, or counts that are not above 0.
  std::vector<Eigen::VectorXd> compute_ik(const std::string& robot, const Pose& target,
                                          const std::optional<Eigen::VectorXd>& reference = {},
                                          const IkOptions& options = {}, const std::string& link = "") const;
  /// Returns whether the robot at q (dof,) [rad or m] touches itself or anything else. Joint limits are not checked.
  bool is_state_colliding(const std::string& robot, ConstVector q) const;
  /// Every pair in contact at q (dof,) [rad or m], deepest first.
  std::vector<Contact> contacts(const std::string& robot, ConstVector q) const;
  /// Returns whether the straight joint-space motion from a (dof,) to b (dof,) is proved free, between samples too;
  /// continuous joints take the short way round. Conservative advancement (Schwarzer, Saha, Latombe 2004).
  bool is_motion_free(const std::string& robot, ConstVector a, ConstVector b) const;
  /// Distance of the nearest pair at q (dof,) [m]; negative is the depth of penetration; infinity when there is nothing
  /// to collide with. The base and other links that no planned joint moves count too, unless they stand on the other
  /// (within 10 µm).
  double distance_to_collision(const std::string& robot, ConstVector q) const;
  /// The pair of distance_to_collision; nullopt when there is nothing to collide with.
  std::optional<Contact> nearest(const std::string& robot, ConstVector q) const;
  /// A checker of the scene as it is now, for many queries; later changes of the scene do not reach it. The first use
  /// of a robot computes sphere covers of its links, which may take many seconds; later ones load them from the cache
  /// directory.
  std::shared_ptr<const Checker> collision_checker(const std::string& robot, CheckMode mode = CheckMode::exact) const;
  /// A checker of one robot among others whose motions are known: straight between the configurations of `others`, at
  /// rest before and after. Robots not named stand still. Throws InvalidArgument for unknown robots, times that do not
  /// increase, wrong sizes and NaN.
  std::shared_ptr<const TimedChecker> timed_collision_checker(const std::string& robot,
                                                              const std::map<std::string, TimedPath>& others,
                                                              CheckMode mode = CheckMode::exact) const;

  /// From now on plans check collisions by the checkers that `backend` makes (collision/checker.hpp says what they must
  /// keep to); they are made per scene, robot and group of robots, possibly in several threads. Certificates and single
  /// queries stay with the library's own checker, so that a wrong backend cannot make a path in collision look valid.
  /// Throws InvalidArgument for an empty function; make_checker is the default.
  void set_collision_backend(CheckerFactory backend);

  // --- motion limits and verification

  /// The limits of the robot's joints: velocities of the URDF, and default_limits for the others, until
  /// set_motion_limits.
  MotionLimits motion_limits(const std::string& robot) const;
  /// Sets the limits of all plans that follow, dof entries each: velocity [rad/s or m/s], acceleration [rad/s^2 or
  /// m/s^2], jerk [rad/s^3 or m/s^3]. Which joints are continuous is known from the model. Throws InvalidArgument for a
  /// wrong size, and limits that are not above 0 and finite.
  void set_motion_limits(const std::string& robot, MotionLimits limits);
  /// Replaces the limits that were set by those of a MoveIt joint_limits.yaml (io/joint_limits.hpp says what is read
  /// and what is refused). What the file does not say is as in default_limits. Returns the joints in it that are not
  /// planned ones: they were not used. Throws FileError, with the line, and NotSupported.
  std::vector<std::string> load_joint_limits(const std::string& robot, const std::string& path);
  /// A certificate of any trajectory of the robot, whoever planned it, in the scene as it is, made by code that plans
  /// nothing: limits at every instant, collisions between rows too, whether it is at rest at both ends, start and
  /// goals, path constraints, clearance. Faults are reported, not thrown. Throws InvalidArgument for an unknown robot,
  /// constraints as plan does, and options out of range.
  Certificate verify(const std::string& robot, const Trajectory& trajectory, const VerifyOptions& options = {}) const;
  /// verify for many robots that move on one clock, by name: a certificate of each, verified against the others too,
  /// which rest where their motions end. Robots not named stand still. Throws InvalidArgument for an unknown robot,
  /// starts and goals of robots without a trajectory, and options out of range.
  std::map<std::string, Certificate> verify_multi(const MultiTrajectory& trajectory,
                                                  const MultiVerifyOptions& options = {}) const;

  // --- heuristics of the user

  /// Registers a heuristic: from now on `name` may stand where options name one, for any robot. Bounds that depend on
  /// it are proven only if it is declared `consistent`. The function must not use this PlannerInterface, which is
  /// planning when it calls it. Throws InvalidArgument for a name in use, empty, or with spaces, commas or brackets;
  /// plan throws it for values that are not finite and >= 0, with the value and the configuration.
  void add_heuristic(const std::string& name, HeuristicFunction function, bool consistent = false);
  /// Removes a heuristic of add_heuristic; planners that name it refuse to plan. Throws InvalidArgument for an unknown
  /// name.
  void remove_heuristic(const std::string& name);
  /// Names of the heuristics of add_heuristic, sorted.
  std::vector<std::string> heuristic_names() const;

  // --- planning

  /// Chooses the planner of these robots, from a dictionary ("planner_id", "time_limit", …) or typed options. Options
  /// left out have their defaults. Throws InvalidArgument for an unknown robot, planner or option (with the nearest
  /// name) or a value out of range.
  void make_planner(const std::vector<std::string>& robots, const OptionMap& options);
  void make_planner(const std::vector<std::string>& robots, const PlannerOptions& options);
  /// Computes now, on all cores, what makes collision checks of the scene's robots faster: sphere covers, and tables of
  /// pairs of links. It takes seconds to minutes for a robot seen for the first time; later it comes from the cache
  /// directory. Without this call it happens in the background, from the first plan on. No result depends on it, only
  /// the time that plans take. `progress` is called often, in the caller's thread; what it throws ends the call within
  /// 0.1 s and passes through.
  void prepare(const PlanProgress& progress = {});
  /// The options that make_planner was given for these robots; the defaults of `auto` when it was not called.
  const PlannerOptions& planner_options(const std::vector<std::string>& robots) const;

  /// Called during a plan, at most every 5 ms; when it returns true, the plan stops with Status::cancelled.
  using Interrupt = Deadline::Interrupt;

  /// A goal in any form as a GoalConstraint for this robot. Joints that a goal by joint names leaves out are as in
  /// `start` (default: set_qpos). Throws InvalidArgument for an unknown robot, joint or state, with the nearest name.
  GoalConstraint goal(const std::string& robot, const Goal& goal,
                      const std::optional<Eigen::VectorXd>& start = {}) const;

  /// A timed, collision-free trajectory of one robot from `start` (dof,) [rad or m] to any one of `goals`, or to a goal
  /// in any form (Goal), by the planner of make_planner, or by `auto`; other robots stand still. The robot's name may
  /// be left out where it is the only one. The same request gives the same result, bit for bit. `on_solution` receives
  /// every path that is better than those before, while planners that improve theirs run; when it returns false, that
  /// path is good enough. Throws PlanningError when there is none: its status is timed_out, exhausted, start_invalid,
  /// goal_invalid or cancelled, its text says why. Throws InvalidArgument for an invalid request: unknown robot, wrong
  /// size, NaN.
  Trajectory plan(const std::string& robot, ConstVector start, const std::vector<GoalConstraint>& goals,
                  const Interrupt& interrupt = {}, const OnSolution& on_solution = {});
  Trajectory plan(const std::string& robot, ConstVector start, const Goal& goal, const Interrupt& interrupt = {},
                  const OnSolution& on_solution = {});
  Trajectory plan(ConstVector start, const Goal& goal, const Interrupt& interrupt = {},
                  const OnSolution& on_solution = {});
  /// The same for a request, which may have path constraints: they hold at every instant of the motion, which is
  /// proved, and Certificate::constraints has the proved values. A start or goals that break one are start_invalid or
  /// goal_invalid, with the amount. Configurations of the search are projected onto the constraints by Newton's method
  /// (CBiRRT: Berenson et al. 2009; lattices likewise). Throws InvalidArgument also for constraints that
  /// PathConstraint::validate refuses, links and frames that do not exist (with the nearest name) and constraints that
  /// no planned joint can change.
  ///
  /// A request with a start_velocity begins in motion, straight ahead until the robot could stop; from there the path
  /// is searched, and where the two meet the corner is rounded as others are. The statistics' costs are without that
  /// lead. Where the robot cannot stop straight ahead, the status is start_invalid, with what is in the way. Throws
  /// InvalidArgument for velocities and accelerations above their limits, and for the timing `none`.
  Trajectory plan(const PlanRequest& request, const Interrupt& interrupt = {}, const OnSolution& on_solution = {});
  /// A timed, collision-free trajectory on which a link (CartesianOptions: default the end effector) moves in a
  /// straight line from where it is at `start` (dof,) [rad or m] to `goal`, a pose in the world frame, turning evenly
  /// (slerp). The same as `follow` with one pose.
  Trajectory plan_linear(const std::string& robot, ConstVector start, const Pose& goal,
                         const CartesianOptions& options = {}, const Interrupt& interrupt = {});
  /// A timed, collision-free trajectory on which a link passes `poses` (world frame, at least one) in order, straight
  /// from each to the next, beginning where it is at `start` (dof,) [rad or m]; other robots stand still. The joints
  /// that are not needed for this avoid obstacles and limits: configurations along the path are searched by weighted
  /// A* (Pohl 1970) in a graph of poses times redundancy, from the configuration at the start on, without jumps. The
  /// link leaves the path by no more than max_deviation and max_rotation, at every instant of the timed motion; this is
  /// proved, and Certificate::cartesian_deviation has the proved values. Where the path has a corner, the motion slows
  /// down, or stops if the tolerance is too small to round it.
  ///
  /// Path constraints of the options hold at every instant besides, as those of plan. A start that breaks one is
  /// start_invalid; a last pose at which all configurations that are found break one is goal_invalid.
  ///
  /// Time limit, timing, limits, clearance and certificate are those of make_planner; its search options do not apply.
  /// A start or an end may be closer to something than the clearance: on the way from there, no pair that is closer
  /// comes closer still. Throws PlanningError: start_invalid; goal_invalid; timed_out; cancelled; or exhausted, with
  /// how far the link came and what stopped it (a contact, the clearance, a constraint, the joint limits, a
  /// singularity). Throws InvalidArgument for an unknown robot or link (with the nearest name), a link that no planned
  /// joint moves, constraints as plan, a wrong size, NaN, no poses, poses or a path beyond 1000 m, and tolerances that
  /// are not above 0 and at most 0.1 m and 0.5 rad. last_request and last_result are none afterwards.
  Trajectory follow(const std::string& robot, ConstVector start, const std::vector<Pose>& poses,
                    const CartesianOptions& options = {}, const Interrupt& interrupt = {});
  /// Motions, grasps and waits in a row, from `start` (dof,) [rad or m]: each segment begins where the one before ends,
  /// in the scene as it is then. Where a later segment fails, earlier moves end elsewhere, at another target or another
  /// solution of inverse kinematics, those near their starts first: a grasp takes a configuration from which the lift
  /// works. Moves with a blend_radius are passed without a stop. Joints that are set are looked at in ten steps on
  /// their way for contacts; attach an object before a gripper closes around it.
  ///
  /// The scene is as before afterwards, whether there is a sequence or not; last_request and last_result are none.
  /// Planner, timing, limits and clearance are those of make_planner; the time limit is for each motion, and so many
  /// times as there are segments for all. Every motion keeps the clearance, and may begin and end closer, as those of
  /// plan and follow do. Throws PlanningError with the segment that was reached and why it failed, and
  /// InvalidArgument, with the number of the segment, for segments that cannot be: unknown objects, links and joints,
  /// goals as plan, poses as follow, no segments, negative times and radii.
  SequenceResult plan_sequence(const std::string& robot, ConstVector start, const std::vector<Segment>& segments,
                               const Interrupt& interrupt = {});
  SequenceResult plan_sequence(ConstVector start, const std::vector<Segment>& segments,
                               const Interrupt& interrupt = {});
  /// The fastest certified stop on the path of a motion, from the instant t [s] of it on: the robot brakes as hard as
  /// the velocity and acceleration limits allow at every instant, and stops at the earliest place of the path where it
  /// can. With the timing `ruckig` the jerk limits are kept too; the path must be straight there, as such motions are.
  /// Times begin at 0, with the position, velocity and, with `ruckig`, acceleration of the motion at t, or at its row
  /// that is within 1 µs of t. Timing, limits and time limit are those of make_planner. Throws PlanningError,
  /// exhausted, when the stop touches what is in the scene now; and InvalidArgument for an unknown robot, other joints,
  /// a motion without times or velocities, one that ends in motion before the robot can stop, and a t outside it.
  Trajectory stop(const std::string& robot, const Trajectory& motion, double t, const Interrupt& interrupt = {}) const;
  Trajectory stop(const Trajectory& motion, double t, const Interrupt& interrupt = {}) const;
  /// A new motion to another goal that leaves a motion at its instant t [s] without a stop: it begins with the
  /// position, velocity and, with the timing `ruckig`, acceleration that the motion has there, at time 0, as a plan
  /// with PlanRequest::start_velocity does. Where the robot could not stop straight ahead, because something is in the
  /// way, the motion is left at its next row at which it can. The request's start, start_velocity and
  /// start_acceleration are not used. Path constraints hold from t on, and the motion must be left there. Throws as
  /// plan, and InvalidArgument for other joints, a motion without times or velocities, and a t outside it.
  Trajectory replan(const Trajectory& motion, double t, PlanRequest request, const Interrupt& interrupt = {});
  Trajectory replan(const std::string& robot, const Trajectory& motion, double t, const Goal& goal,
                    const Interrupt& interrupt = {});
  Trajectory replan(const Trajectory& motion, double t, const Goal& goal, const Interrupt& interrupt = {});
  /// Called by plan_many in the caller's thread, with the number of requests done and of all.
  using Progress = PlanProgress;

  /// Plans many requests in the scene as it is, independently of each other, on `threads` threads (> 0; default: one
  /// for each core).
  ///
  /// Results are in the order of the requests, and each is what plan alone would have found, bit for bit, for any
  /// number of threads. A request that has no trajectory does not disturb the others: its PlanResult says why. Every
  /// request has its own time limit, which begins with its own plan; only a limit that stops a plan can make a
  /// difference, and it does so earlier the more threads share a core. Once `interrupt` returns true, all that is not
  /// finished ends with Status::cancelled. `progress` and `interrupt` are called in the caller's thread; what they
  /// throw ends the call. get_planning_stats stays as it was. Throws InvalidArgument for an invalid request, as plan
  /// does, with its number; before anything is planned where it can.
  std::vector<PlanResult> plan_many(const std::vector<PlanRequest>& requests, std::optional<int> threads = {},
                                    const Interrupt& interrupt = {}, const Progress& progress = {});

  /// Motions of many robots together, on one clock, collision-free among each other too, from `starts` (dof,) [rad or
  /// m] to `goals`, both by robot name. A robot with a start and no goal holds still, as with GoalConstraint::hold; one
  /// with GoalConstraint::any may move out of the others' way; robots without a start stand where set_qpos put them.
  /// Every trajectory has a certificate that covers the others, those of robots that hold too. Planned by the planner
  /// that make_planner chose for the robots of `starts`, or by `auto`.
  ///
  /// `obstacles`: timed trajectories by robot name, that other robots of the scene are committed to. They begin at time
  /// 0 too, and the robots rest where they end and are not planned for. The planned motions begin together, as early as
  /// they pass the obstacles, in steps of 0.1 s, at rest at the starts until then; or, where that fails or begins late,
  /// each robot moves and waits as suits the others (not complete). Certificates cover the obstacles.
  ///
  /// Throws PlanningError, with a status and a reason, when there are none: a start where an obstacle begins is
  /// `start_invalid` (one where it ends too, unless the robot can leave before), a goal where one ends is
  /// `goal_invalid`; `exhausted` names links and time when no motions are found. Throws InvalidArgument for a goal
  /// without a start, wrong sizes and NaN, when no robot is to move, and for an obstacle that has a start, has no
  /// times, does not begin at time 0, leaves the joint limits or does not have the robot's joints.
  MultiTrajectory plan_multi(const std::map<std::string, Eigen::VectorXd>& starts,
                             const std::map<std::string, GoalConstraint>& goals,
                             const std::map<std::string, Trajectory>& obstacles = {}, const Interrupt& interrupt = {});
  /// The same, with path constraints of each robot. Throws as it, and InvalidArgument as plan for constraints, for
  /// those of a robot without a start, and for a frame of a robot that moves or of what it holds. A start that breaks a
  /// constraint is `start_invalid`, a goal `goal_invalid`.
  MultiTrajectory plan_multi(const MultiPlanRequest& request, const Interrupt& interrupt = {});
  /// Statistics of the last plan, solved or not; status `exhausted` with zeros before the first.
  const PlanStatistics& get_planning_stats() const;
  /// The request of the last plan (without options: those of make_planner apply) or plan_multi; none before the first,
  /// and once one of its robots or the scene was replaced.
  const std::optional<LastRequest>& last_request() const;
  /// The result of it: a PlanResult, or a MultiPlanResult of plan_multi; none before the first, and once scene or
  /// planner were changed: then the same request may have another one.
  const std::optional<LastResult>& last_result() const;

 private:
  friend class MoveItGroup;
  // As load_scene.
  void set_scene(Scene scene);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srmp
