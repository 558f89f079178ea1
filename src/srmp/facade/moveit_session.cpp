#include "srmp/moveit_session.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>

#include "srmp/core/interruption.hpp"
#include "srmp/facade/moveit_group.hpp"
#include "srmp/io/moveit_rules.h"

namespace srmp {

namespace {

using Code = MoveItErrorCode;
using Clock = std::chrono::steady_clock;

/// The first link that a goal is for; "" = goals are for joints.
std::string goal_link(const io::RequestFile& request) {
  for (const io::GoalAlternative& goal : request.goals) {
    if (!goal.positions.empty()) return goal.positions.front().link;
    if (!goal.orientations.empty()) return goal.orientations.front().link;
  }
  return "";
}

/// Refuses what is wrong in itself.
void require_valid(const io::SceneFile& scene, const io::RequestFile& request) {
  if (scene.is_diff)
    throw MoveItRefusal(Code::invalid_object_name, "the scene is a difference; a session needs whole scenes");
  refused_with(Code::invalid_object_name, Code::collision_checking_unavailable,
               "the scene: ", [&] { io::require_valid(scene); });
  if (request.goals.empty()) throw MoveItRefusal(Code::invalid_goal_constraints, "the request has no goal_constraints");
  refused_with(Code::planning_failed, Code::planning_failed, "the request: ", [&] { io::require_valid(request); });
  refused_with(Code::invalid_robot_state, Code::start_state_invalid,
               "the request: ", [&] { io::require_valid(request.start_state); });
  for (const io::GoalAlternative& goal : request.goals)
    refused_with(Code::invalid_goal_constraints, Code::invalid_goal_constraints,
                 "the request: ", [&] { io::require_valid(goal); });
}

/// What the start state attaches; an object of the world that it names without shapes is no longer in the world.
void attach(const io::AttachedObject& attached, io::SceneFile& scene) {
  std::vector<io::AttachedObject>& held = scene.robot_state.attached;
  const auto same_id = [&](const auto& other) { return other.object.id == attached.object.id; };
  const auto before = std::find_if(held.begin(), held.end(), same_id);
  if (attached.object.operation == io::ObjectOperation::append ||
      attached.object.operation == io::ObjectOperation::move)
    throw MoveItRefusal(Code::invalid_object_name, "the start state appends to object '" + attached.object.id +
                                                       "' or moves it, which is not supported; attach it anew");
  if (attached.object.operation == io::ObjectOperation::remove) {
    if (before == held.end())
      throw MoveItRefusal(Code::invalid_object_name,
                          "the start state detaches object '" + attached.object.id + "', which is not attached");
    held.erase(before);
    return;
  }
  if (before != held.end()) held.erase(before);
  held.push_back(attached);
  if (!attached.object.shapes.empty())
    std::erase_if(scene.objects, [&](const auto& object) { return object.id == attached.object.id; });
}

/// The scene as it is at the start: MoveIt's rules for a robot state on top of another one.
io::SceneFile with_start(io::SceneFile scene, const io::RobotState& start) {
  for (const auto& [joint, position] : start.joints) scene.robot_state.joints[joint] = position;
  for (const auto& [joint, pose] : start.multi_dof_joints) scene.robot_state.multi_dof_joints[joint] = pose;
  if (!start.multi_dof_joints.empty()) scene.robot_state.multi_dof_frame = start.multi_dof_frame;
  const bool whole = !start.is_diff && !(start.joints.empty() && start.multi_dof_joints.empty());
  if (whole) scene.robot_state.attached.clear();
  for (const io::AttachedObject& attached : start.attached) attach(attached, scene);
  for (const io::AttachedObject& attached : scene.robot_state.attached) {
    const std::string& id = attached.object.id;
    if (attached.object.shapes.empty() &&
        std::none_of(scene.objects.begin(), scene.objects.end(), [&](const auto& object) { return object.id == id; }))
      throw MoveItRefusal(Code::invalid_object_name,
                          "object '" + id + "' is attached without shapes and is not in the world");
  }
  return scene;
}

io::RequestFile named(io::RequestFile request) {
  if (request.path.empty()) request.path = "the request";
  const auto normalize = [](io::GoalAlternative& goal) {
    for (io::OrientationConstraint& constraint : goal.orientations) constraint.orientation.normalize();
  };
  std::for_each(request.goals.begin(), request.goals.end(), normalize);
  normalize(request.path_constraints);
  return request;
}

}  // namespace

std::string_view to_string(MoveItErrorCode code) {
  switch (code) {
    case Code::success: return "SUCCESS";
    case Code::failure: return "FAILURE";
    case Code::planning_failed: return "PLANNING_FAILED";
    case Code::timed_out: return "TIMED_OUT";
    case Code::preempted: return "PREEMPTED";
    case Code::start_state_in_collision: return "START_STATE_IN_COLLISION";
    case Code::start_violates_path_constraints: return "START_STATE_VIOLATES_PATH_CONSTRAINTS";
    case Code::start_state_invalid: return "START_STATE_INVALID";
    case Code::goal_in_collision: return "GOAL_IN_COLLISION";
    case Code::goal_violates_path_constraints: return "GOAL_VIOLATES_PATH_CONSTRAINTS";
    case Code::goal_state_invalid: return "GOAL_STATE_INVALID";
    case Code::invalid_group_name: return "INVALID_GROUP_NAME";
    case Code::invalid_goal_constraints: return "INVALID_GOAL_CONSTRAINTS";
    case Code::invalid_robot_state: return "INVALID_ROBOT_STATE";
    case Code::invalid_link_name: return "INVALID_LINK_NAME";
    case Code::invalid_object_name: return "INVALID_OBJECT_NAME";
    case Code::frame_transform_failure: return "FRAME_TRANSFORM_FAILURE";
    case Code::collision_checking_unavailable: return "COLLISION_CHECKING_UNAVAILABLE";
    case Code::no_ik_solution: return "NO_IK_SOLUTION";
  }
  return "FAILURE";
}

struct MoveItSession::Impl {
  explicit Impl(MoveItRobot given) : robot(std::move(given)) {}

  /// The options that a planner id of a request stands for.
  OptionMap options_of(const io::RequestFile& request) const {
    const auto configured = [&](const std::string& key) { return configurations.find(key); };
    OptionMap options;
    if (const auto own = configured(request.group_name); request.planner_id.empty() && own != configurations.end())
      options = own->second;
    else if (const auto full = configured(request.planner_id); full != configurations.end())
      options = full->second;
    else if (const auto local = configured(request.group_name + "[" + request.planner_id + "]");
             local != configurations.end())
      options = local->second;
    else if (!request.planner_id.empty())
      options["planner_id"] =
          refused_with(Code::planning_failed, Code::planning_failed,
                       "the request's planner_id: ", [&] { return planner_info(request.planner_id).id; });
    if (request.allowed_planning_time.value_or(0.0) > 0.0) options["time_limit"] = *request.allowed_planning_time;
    if (request.velocity_scaling > 0.0 && request.velocity_scaling != 1.0)
      options["velocity_scaling"] = request.velocity_scaling;
    if (request.acceleration_scaling > 0.0 && request.acceleration_scaling != 1.0)
      options["acceleration_scaling"] = request.acceleration_scaling;
    return options;
  }

  /// The groups that are planned as robots of their own: the subgroups of a group, by planners for many robots. A
  /// planner that plans for one robot too takes the whole group where arms depend on each other, and for what is
  /// supported for one robot only.
  std::vector<std::string> arms_of(const SrdfGroup& group, const PlannerInfo& planner,
                                   const io::RequestFile& request) const {
    const bool several =
        group.subgroups.size() > 1 && group.chains.empty() && group.joints.empty() && group.links.empty();
    if (planner.one_robot &&
        (!planner.many_robots || !several || needs_one_robot(request) || !model->move_apart(group.subgroups)))
      return {};
    if (!several)
      throw MoveItRefusal(Code::planning_failed, "planner '" + planner.id + "' plans for several robots, and group '" +
                                                     group.name + "' is not made of two or more subgroups");
    return group.subgroups;
  }

  /// What groups of several arms are refused for.
  static bool needs_one_robot(const io::RequestFile& request) {
    return !io::holds_nothing(request.path_constraints) || request.goals.size() > 1 ||
           io::is_moving(request.start_state);
  }

  MoveItGroup& group_of(const io::RequestFile& request, const PlannerInfo& planner) {
    if (!model) model = std::make_unique<const MoveItModel>(robot);
    const SrdfGroup& group = model->group(request.group_name);
    const std::vector<std::string> arms = arms_of(group, planner, request);
    const std::string end_effector = arms.empty() ? model->end_effector(group, goal_link(request)) : goal_link(request);
    std::unique_ptr<MoveItGroup>& known = groups[{group.name, end_effector, !arms.empty()}];
    if (!known) known = std::make_unique<MoveItGroup>(*model, group, end_effector, arms);
    return *known;
  }

  void respond(io::SceneFile scene, const io::RequestFile& given, const PlannerInterface::Interrupt& stop,
               MoveItResponse& response) {
    const io::RequestFile request = named(given);
    require_valid(scene, given);
    if (scene.path.empty()) scene.path = "the scene";
    const OptionMap options = options_of(request);
    const PlannerInfo& planner = planner_info(id_of(options));
    response.planner_id = planner.id;
    MoveItGroup& group = group_of(request, planner);
    response.notes = group.update(with_start(std::move(scene), request.start_state));
    try {
      response.trajectory = group.plan(request, options, stop);
      response.code = Code::success;
    } catch (const PlanningError& error) {
      response.code = group.code_of(error);
      response.message = error.what();
    }
    response.statistics = group.statistics();
  }

  static std::string id_of(const OptionMap& options) {
    const auto id = options.find("planner_id");
    return id == options.end() ? available_planners().front().id : std::get<std::string>(id->second);
  }

  MoveItRobot robot;
  std::unique_ptr<const MoveItModel> model;
  std::map<std::string, OptionMap> configurations;
  std::map<std::tuple<std::string, std::string, bool>, std::unique_ptr<MoveItGroup>> groups;  // name, link, arms
  std::timed_mutex one_at_a_time;
};

MoveItSession::MoveItSession(MoveItRobot robot) : impl_(std::make_unique<Impl>(std::move(robot))) {}
MoveItSession::~MoveItSession() = default;
MoveItSession::MoveItSession(MoveItSession&&) noexcept = default;

void MoveItSession::set_configurations(const std::map<std::string, OptionMap>& configurations) {
  for (const auto& [name, options] : configurations) try {
      parse_options(options);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("planner configuration '" + name + "': " + error.what());
    }
  const std::scoped_lock lock(impl_->one_at_a_time);
  impl_->configurations = configurations;
}

std::vector<std::string> MoveItSession::planner_ids() const {
  std::vector<std::string> ids;
  for (const PlannerInfo& planner : available_planners()) ids.push_back(planner.id);
  const std::scoped_lock lock(impl_->one_at_a_time);
  for (const auto& [name, options] : impl_->configurations) ids.push_back(name);
  return ids;
}

MoveItResponse MoveItSession::solve(const io::SceneFile& scene, const io::RequestFile& request,
                                    const std::atomic<bool>* stop) {
  const auto start = Clock::now();
  const auto stopped = [stop] { return stop && *stop; };
  MoveItResponse response;
  const auto refuse = [&](MoveItErrorCode code, const char* why) {
    response.code = code;
    response.message = why;
  };
  std::unique_lock lock(impl_->one_at_a_time, std::defer_lock);
  try {
    const InterruptionScope scope([&] {
      if (stopped()) throw PlanningError(Status::cancelled, "the request was stopped");
    });
    while (!lock.try_lock_for(std::chrono::milliseconds(5))) rare_interruption_point();
    impl_->respond(scene, request, stopped, response);
  } catch (const MoveItRefusal& refusal) {
    refuse(refusal.code, refusal.what());
  } catch (const PlanningError& error) {
    refuse(error.status() == Status::cancelled ? Code::preempted : Code::planning_failed, error.what());
  } catch (const FileError& error) {
    refuse(Code::failure, error.what());
  } catch (const Error& error) {
    refuse(Code::planning_failed, error.what());
  }
  response.planning_time = std::chrono::duration<double>(Clock::now() - start).count();
  return response;
}

}  // namespace srmp
