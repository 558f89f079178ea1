#include "srmp/planner_interface.hpp"

#include <algorithm>
#include <thread>

#include "srmp/collision/self_filter.hpp"
#include "srmp/facade/moveit_problem.hpp"
#include "srmp/facade/planner_impl.hpp"
#include "srmp/io/joint_limits.hpp"
#include "srmp/io/scene_file.hpp"
#include "srmp/planning/certificates/verify_together.hpp"
#include "srmp/planning/obstacles/moving_obstacles.hpp"
#include "srmp/trajectory/joint_torques.hpp"

namespace srmp {

PlannerInterface::PlannerInterface() : impl_(std::make_unique<Impl>()) {}
PlannerInterface::~PlannerInterface() = default;
PlannerInterface::PlannerInterface(PlannerInterface&&) noexcept = default;
PlannerInterface& PlannerInterface::operator=(PlannerInterface&&) noexcept = default;

// --- robots

void PlannerInterface::add_articulation(const RobotDescription& description, const Pose& base) {
  if (!description.name.empty() && impl_->scene.robots().contains(description.name))
    throw InvalidArgument("there is a robot '" + description.name + "' already; give another name");
  auto model = RobotModel::load(description);
  impl_->change([&](Scene& scene) { scene.add_robot(std::move(model), base); });
}

void PlannerInterface::remove_articulation(const std::string& robot) {
  const std::string gone = robot;  // the caller's string may live in what is removed
  impl_->change([&](Scene& scene) { scene.remove_robot(robot); });
  impl_->forget([&](const std::string& name) { return name == gone; });
}

void PlannerInterface::set_base_pose(const std::string& robot, const Pose& pose) {
  impl_->change([&](Scene& scene) { scene.set_base_pose(robot, pose); });
}

void PlannerInterface::set_qpos(const std::string& robot, ConstVector q) {
  impl_->change([&](Scene& scene) { scene.set_qpos(robot, q); });
}

void PlannerInterface::set_joint_positions(const std::string& robot, const std::map<std::string, double>& positions) {
  impl_->change([&](Scene& scene) { scene.set_joint_positions(robot, positions); });
}

// --- objects

void PlannerInterface::add_box(const std::string& name, const Eigen::Vector3d& size, const Pose& pose, double padding) {
  impl_->change([&](Scene& scene) { scene.add_object(name, Box{size}, pose, padding); });
}

void PlannerInterface::add_sphere(const std::string& name, double radius, const Pose& pose, double padding) {
  impl_->change([&](Scene& scene) { scene.add_object(name, Sphere{radius}, pose, padding); });
}

void PlannerInterface::add_cylinder(const std::string& name, double radius, double length, const Pose& pose,
                                    double padding) {
  impl_->change([&](Scene& scene) { scene.add_object(name, Cylinder{radius, length}, pose, padding); });
}

void PlannerInterface::add_capsule(const std::string& name, double radius, double length, const Pose& pose,
                                   double padding) {
  impl_->change([&](Scene& scene) { scene.add_object(name, Capsule{radius, length}, pose, padding); });
}

void PlannerInterface::add_cone(const std::string& name, double radius, double length, const Pose& pose,
                                double padding) {
  impl_->change([&](Scene& scene) { scene.add_object(name, Cone{radius, length}, pose, padding); });
}

void PlannerInterface::add_mesh(const std::string& name, const std::string& path, const Pose& pose,
                                const Eigen::Vector3d& scale, bool convex, double padding) {
  add_mesh(name, Mesh::from_file(path, scale, convex), pose, padding);
}

void PlannerInterface::add_mesh(const std::string& name, const Mesh& mesh, const Pose& pose, double padding) {
  impl_->change([&](Scene& scene) { scene.add_object(name, mesh, pose, padding); });
}

void PlannerInterface::add_point_cloud(const std::string& name, const std::vector<Eigen::Vector3d>& points,
                                       double resolution, const Pose& pose, double padding,
                                       std::optional<double> self_filter_distance) {
  impl_->change([&](Scene& scene) {
    if (!self_filter_distance) return scene.add_object(name, PointCloud{points, resolution}, pose, padding);
    const auto kept = points_clear_of_robots(scene, points, pose, *self_filter_distance);
    if (kept.empty() && !points.empty())
      throw InvalidArgument("point cloud of object '" + name + "': all " + std::to_string(points.size()) +
                            " points are within self_filter_distance " + to_text(*self_filter_distance) +
                            " m of a robot or what it holds");
    scene.add_object(name, PointCloud{kept, resolution}, pose, padding);
  });
}

void PlannerInterface::remove_object(const std::string& name) {
  impl_->change([&](Scene& scene) { scene.remove_object(name); });
}

void PlannerInterface::set_object_pose(const std::string& name, const Pose& pose) {
  impl_->change([&](Scene& scene) { scene.set_object_pose(name, pose); });
}

void PlannerInterface::set_padding(const std::string& name, double padding) {
  impl_->change([&](Scene& scene) {
    if (scene.robots().contains(name))
      scene.set_robot_padding(name, padding);
    else
      scene.set_padding(name, padding);
  });
}

void PlannerInterface::attach_object(const std::string& object, const std::string& robot, const std::string& link,
                                     const std::vector<std::string>& touch_links,
                                     const std::optional<Pose>& pose_in_link) {
  impl_->change([&](Scene& scene) { scene.attach_object(object, robot, link, touch_links, pose_in_link); });
}

void PlannerInterface::detach_object(const std::string& object) {
  impl_->change([&](Scene& scene) { scene.detach_object(object); });
}

void PlannerInterface::set_allowed_collision(const std::string& a, const std::string& b, bool allowed) {
  impl_->change([&](Scene& scene) { scene.set_allowed_collision(a, b, allowed); });
}

std::vector<std::string> PlannerInterface::load_moveit_scene(const std::string& path) {
  std::vector<std::string> notes;
  impl_->change([&](Scene& scene) { notes = io::apply(io::read_moveit_scene(path), scene); });
  return notes;
}

MoveItProblem PlannerInterface::apply_moveit_request(const std::string& robot, const io::RequestFile& request) {
  MoveItProblem problem;
  impl_->change([&](Scene& scene) { problem = moveit_problem(request, robot, scene); });
  return problem;
}

void PlannerInterface::reset() {
  impl_->change([](Scene& scene) { scene.reset(); });
  impl_->checkers.clear();
  impl_->planners.clear();
  impl_->heuristics.clear();
  impl_->motion_limits.clear();
  impl_->request.reset();
  impl_->statistics = {};
}

// --- files

void PlannerInterface::save(const std::string& path) const {
  save_problem({impl_->scene, impl_->planners, impl_->motion_limits, impl_->request, impl_->result}, path);
}

PlannerInterface PlannerInterface::load(const std::string& path, const std::vector<std::string>& package_dirs) {
  Problem problem = load_problem(path, package_dirs);
  PlannerInterface planner;
  Impl& impl = *planner.impl_;
  impl.scene = std::move(problem.scene);
  impl.planners = std::move(problem.planners);
  impl.motion_limits = std::move(problem.motion_limits);
  impl.request = std::move(problem.request);
  impl.result = std::move(problem.result);
  if (impl.result) impl.statistics = std::visit([](const auto& result) { return result.statistics(); }, *impl.result);
  return planner;
}

void PlannerInterface::save_scene(const std::string& path) const { io::save_scene(impl_->scene, path); }

void PlannerInterface::load_scene(const std::string& path, const std::vector<std::string>& package_dirs) {
  set_scene(io::load_scene(path, package_dirs));
}

void PlannerInterface::set_scene(Scene loaded) {
  std::erase_if(impl_->motion_limits, [&](const auto& entry) {
    const auto same = loaded.robots().find(entry.first);
    return same == loaded.robots().end() ||
           same->second.model->joint_names() != impl_->model(entry.first).joint_names();
  });
  impl_->change([&](Scene& scene) { scene = std::move(loaded); });
  impl_->forget([&](const std::string& name) { return !impl_->scene.robots().contains(name); });
  impl_->request.reset();
}

// --- queries

const Scene& PlannerInterface::scene() const { return impl_->scene; }

const RobotModel& PlannerInterface::robot(const std::string& name) const { return impl_->model(name); }

std::vector<std::string> PlannerInterface::robot_names() const { return impl_->scene.robot_names(); }

std::vector<std::string> PlannerInterface::object_names() const { return impl_->scene.object_names(); }

std::vector<std::string> PlannerInterface::get_joint_names(const std::string& robot) const {
  return impl_->model(robot).joint_names();
}

std::vector<std::string> PlannerInterface::get_link_names(const std::string& robot) const {
  return impl_->model(robot).link_names();
}

Pose PlannerInterface::compute_fk(const std::string& robot, ConstVector q, const std::string& link) const {
  impl_->require_state(robot, q);
  const RobotInstance& instance = impl_->scene.robot(robot);
  return instance.base * instance.model->compute_fk(q, link, instance.other_positions);
}

Eigen::MatrixXd PlannerInterface::compute_jacobian(const std::string& robot, ConstVector q,
                                                   const std::string& link) const {
  impl_->require_state(robot, q);
  const RobotInstance& instance = impl_->scene.robot(robot);
  Eigen::MatrixXd jacobian = instance.model->compute_jacobian(q, link, instance.other_positions);
  const Eigen::Matrix3d rotation = instance.base.q.toRotationMatrix();
  jacobian.topRows<3>() = rotation * jacobian.topRows<3>().eval();
  jacobian.bottomRows<3>() = rotation * jacobian.bottomRows<3>().eval();
  return jacobian;
}

std::vector<Eigen::VectorXd> PlannerInterface::compute_ik(const std::string& robot, const Pose& target,
                                                          const std::optional<Eigen::VectorXd>& reference,
                                                          const IkOptions& options, const std::string& link) const {
  const RobotInstance& instance = impl_->scene.robot(robot);
  if (reference) instance.model->require_configuration(*reference, "reference of '" + robot + "'");
  IkOptions here = options;
  if (here.other_positions.size() == 0) here.other_positions = instance.other_positions;
  return inverse_kinematics(*instance.model, instance.base.inverse() * target, reference.value_or(instance.q), here,
                            link);
}

bool PlannerInterface::is_state_colliding(const std::string& robot, ConstVector q) const {
  const Checker& checker = impl_->checker(robot);
  impl_->require_state(robot, q);
  return !checker.is_free(q, *checker.make_workspace());
}

std::vector<Contact> PlannerInterface::contacts(const std::string& robot, ConstVector q) const {
  const Checker& checker = impl_->checker(robot);
  impl_->require_state(robot, q);
  return checker.contacts(q, *checker.make_workspace());
}

bool PlannerInterface::is_motion_free(const std::string& robot, ConstVector a, ConstVector b) const {
  const Checker& checker = impl_->checker(robot);
  impl_->require_state(robot, a);
  impl_->require_state(robot, b);
  return checker.is_motion_free(a, b, *checker.make_workspace());
}

std::optional<Contact> PlannerInterface::nearest(const std::string& robot, ConstVector q) const {
  const Checker& checker = impl_->checker(robot);
  impl_->require_state(robot, q);
  return nearer(checker.nearest(q, *checker.make_workspace()), checker.nearest_fixed());
}

double PlannerInterface::distance_to_collision(const std::string& robot, ConstVector q) const {
  const auto pair = nearest(robot, q);
  return pair ? pair->distance : std::numeric_limits<double>::infinity();
}

std::shared_ptr<const Checker> PlannerInterface::collision_checker(const std::string& robot, CheckMode mode) const {
  impl_->scene.robot(robot);  // throws with the nearest name
  return make_checker(impl_->scene, robot, impl_->checkers.options(mode));
}

std::shared_ptr<const TimedChecker> PlannerInterface::timed_collision_checker(
    const std::string& robot, const std::map<std::string, TimedPath>& others, CheckMode mode) const {
  impl_->scene.robot(robot);  // throws with the nearest name
  return std::make_shared<const TimedChecker>(impl_->scene, robot, others, impl_->checkers.options(mode));
}

void PlannerInterface::set_collision_backend(CheckerFactory backend) {
  if (!backend) throw InvalidArgument("the collision backend is an empty function; make_checker is the default");
  impl_->checkers.set_backend(std::move(backend));
  impl_->result.reset();
}

// --- heuristics of the user

void PlannerInterface::add_heuristic(const std::string& name, HeuristicFunction function, bool consistent) {
  UserHeuristic heuristic{std::move(function), consistent};
  require_new_heuristic(name, heuristic, impl_->heuristics);
  impl_->heuristics.emplace(name, std::move(heuristic));
}

void PlannerInterface::remove_heuristic(const std::string& name) {
  if (impl_->heuristics.erase(name) > 0) return;
  const std::vector<std::string> known = heuristic_names();
  throw InvalidArgument("there is no heuristic '" + name + "' of yours" + did_you_mean(name, known));
}

std::vector<std::string> PlannerInterface::heuristic_names() const { return impl_->heuristic_names(); }

// --- limits and proofs

MotionLimits PlannerInterface::motion_limits(const std::string& robot) const { return impl_->limits_of(robot); }

void PlannerInterface::set_motion_limits(const std::string& robot, MotionLimits limits) {
  const RobotModel& model = impl_->model(robot);
  require_limits(limits, model.joint_names());
  require_bounds_of_robot(limits, model);
  limits.continuous = default_limits(model).continuous;
  impl_->motion_limits.insert_or_assign(robot, std::move(limits));
  impl_->result.reset();
}

std::vector<std::string> PlannerInterface::load_joint_limits(const std::string& robot, const std::string& path) {
  io::JointLimitsFile file = io::read_joint_limits(path, impl_->model(robot));
  const MotionLimits now = impl_->limits_of(robot);  // such files say nothing of what follows
  file.limits.link_speeds = now.link_speeds;
  file.limits.torque = now.torque;
  file.limits.payload = now.payload;
  set_motion_limits(robot, std::move(file.limits));
  return file.unused;
}

Certificate PlannerInterface::verify(const std::string& robot, const Trajectory& trajectory,
                                     const VerifyOptions& options) const {
  const Checker& checker = impl_->checker(robot);
  if (!options.goals.empty())
    require_request(impl_->scene, robot, options.start.value_or(impl_->scene.robot(robot).q), options.goals);
  return srmp::verify(trajectory, checker, impl_->limits_of(robot), options, place(options, impl_->scene, robot));
}

std::map<std::string, Certificate> PlannerInterface::verify_multi(const MultiTrajectory& trajectory,
                                                                  const MultiVerifyOptions& options) const {
  const auto require_trajectory = [&](const auto& by_robot, const std::string& what) {
    for (const auto& [name, value] : by_robot)
      if (!trajectory.robots.contains(name))
        throw InvalidArgument("robot '" + name + "' has " + what + ", but no trajectory to verify");
  };
  require_trajectory(options.starts, "a start");
  require_trajectory(options.goals, "a goal");
  for (const auto& [name, own] : options.constraints) impl_->scene.robot(name);  // throws with the nearest name
  require_trajectory(options.constraints, "path constraints");
  std::map<std::string, Trajectory> motions = trajectory.robots;
  for (const auto& [name, motion] : options.obstacles)
    if (!motions.emplace(name, motion).second)
      throw InvalidArgument("robot '" + name + "' has a trajectory to verify and is an obstacle too");
  MotionsTogether together(impl_->scene, motions, {options.gap_tolerance, options.clearance});
  auto constraints = impl_->place_all(options, motions);
  std::map<std::string, Certificate> certificates;
  for (const auto& [name, motion] : trajectory.robots)
    certificates.emplace(name, together.verify(name, impl_->limits_of(name),
                                               impl_->verify_options(name, motion, options), constraints[name]));
  return certificates;
}

// --- planning

void PlannerInterface::make_planner(const std::vector<std::string>& robots, const OptionMap& options) {
  make_planner(robots, parse_options(options));
}

void PlannerInterface::make_planner(const std::vector<std::string>& robots, const PlannerOptions& options) {
  validate(options);
  require_heuristics(options, impl_->heuristic_names());
  std::vector<std::string> key = planner_key(impl_->scene, robots);
  require_planner_for(key, options);
  require_robots(options, key);
  impl_->checkers.prepare_in_background(impl_->scene);
  impl_->result.reset();
  impl_->planners.insert_or_assign(std::move(key), options);
}

void PlannerInterface::prepare(const PlanProgress& progress) { impl_->checkers.prepare(impl_->scene, progress); }

const PlannerOptions& PlannerInterface::planner_options(const std::vector<std::string>& robots) const {
  return impl_->planner_options(robots);
}

Trajectory PlannerInterface::plan(const std::string& robot, ConstVector start, const std::vector<GoalConstraint>& goals,
                                  const Interrupt& interrupt, const OnSolution& on_solution) {
  return plan(PlanRequest{robot, start, goals}, interrupt, on_solution);
}

Trajectory PlannerInterface::plan(const PlanRequest& given, const Interrupt& interrupt, const OnSolution& on_solution) {
  PlanRequest request = given;  // a copy: the caller's may be last_request
  if (request.options) validate(*request.options);
  const PlannerOptions options = request.options ? *request.options : planner_options({request.robot});
  const Deadline deadline(common_options(options).time_limit, interrupt);
  impl_->require_problem(request, options);
  impl_->begin(request);
  try {
    const OwnedProblem owned =
        impl_->make_checkers(deadline, [&] { return impl_->problem_of(request, options, on_solution); });
    MultiTrajectory motions = run_pipeline(*owned.problem, deadline, impl_->statistics);
    Trajectory trajectory = std::move(motions.robots.begin()->second);
    impl_->result = PlanResult(impl_->statistics, trajectory);
    return trajectory;
  } catch (const PlanningError&) {
    impl_->result = PlanResult(impl_->statistics);
    throw;
  }
}

std::vector<PlanResult> PlannerInterface::plan_many(const std::vector<PlanRequest>& requests,
                                                    std::optional<int> threads, const Interrupt& interrupt,
                                                    const Progress& progress) {
  if (threads.value_or(1) < 1)
    throw InvalidArgument("threads is " + std::to_string(*threads) + "; it must be at least 1");
  const auto make_problem = [this](const PlanRequest& request) {
    if (request.options) validate(*request.options);
    const PlannerOptions& options = request.options ? *request.options : planner_options({request.robot});
    impl_->require_problem(request, options);
    return impl_->problem_of(request, options);
  };
  impl_->checkers.prepare_in_background(impl_->scene);
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  return srmp::plan_many(requests, make_problem, static_cast<std::size_t>(threads.value_or(static_cast<int>(cores))),
                         interrupt, progress);
}

MultiTrajectory PlannerInterface::plan_multi(const std::map<std::string, Eigen::VectorXd>& starts,
                                             const std::map<std::string, GoalConstraint>& goals,
                                             const std::map<std::string, Trajectory>& obstacles,
                                             const Interrupt& interrupt) {
  return plan_multi(MultiPlanRequest{starts, goals, obstacles}, interrupt);
}

MultiTrajectory PlannerInterface::plan_multi(const MultiPlanRequest& given, const Interrupt& interrupt) {
  const MultiPlanRequest request = given;  // a copy: the caller's may be last_request
  require_multi_request(impl_->scene, request);
  impl_->require_constraints(request);
  const PlannerOptions& options = planner_options(names_of(request));
  const Deadline deadline(common_options(options).time_limit, interrupt);
  require_for_many(options);
  impl_->require_backend_keeps_clearance(options);
  require_clearance_for_many(options, request);
  require_constraints_for_many(options, request);
  require_heuristics(options, impl_->heuristic_names());
  if (!request.obstacles.empty())
    require_no_sample_rate(common_options(options), "a motion that waits for moving obstacles");
  Scene scene = impl_->scene;
  stand_at_ends(scene, request.starts, request.obstacles, common_options(options));
  impl_->begin(request);
  for (const RobotProblem& robot : impl_->robots_of(request, false))
    impl_->statistics.robot_cost_rad[robot.robot] = 0.0;
  try {
    MultiTrajectory result = impl_->solve(request, scene, options, deadline);
    impl_->result = MultiPlanResult(impl_->statistics, result);
    return result;
  } catch (const PlanningError&) {
    impl_->result = MultiPlanResult(impl_->statistics);
    throw;
  }
}

const PlanStatistics& PlannerInterface::get_planning_stats() const { return impl_->statistics; }

const std::optional<LastRequest>& PlannerInterface::last_request() const { return impl_->request; }

const std::optional<LastResult>& PlannerInterface::last_result() const { return impl_->result; }

}  // namespace srmp
