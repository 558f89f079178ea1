#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/facade/moveit_goals.hpp"
#include "srmp/facade/moveit_problem.hpp"
#include "srmp/trajectory/joint_torques.hpp"

namespace srmp {

namespace {

/// A request may name any group with the robot's planned joints. Without an SRDF, groups are not known.
void require_group(const io::RequestFile& request, const RobotModel& robot) {
  if (request.group_name.empty() || robot.groups().empty()) return;
  const auto group = robot.groups().find(request.group_name);
  if (group == robot.groups().end()) {
    std::vector<std::string> known;
    for (const auto& [name, joints] : robot.groups()) known.push_back(name);
    throw InvalidArgument(request.path + ": robot '" + robot.name() + "' has no group '" + request.group_name + "'" +
                          did_you_mean(request.group_name, known));
  }
  const auto require_all = [&](const std::vector<std::string>& joints, const std::vector<std::string>& among,
                               const std::string& what) {
    for (const std::string& joint : joints)
      if (std::find(among.begin(), among.end(), joint) == among.end())
        throw InvalidArgument(request.path + ": the request is for group '" + request.group_name + "', and joint '" +
                              joint + "' " + what + "; add the robot with this group");
  };
  require_all(group->second, robot.joint_names(), "of it is not planned for robot '" + robot.name() + "'");
  require_all(robot.joint_names(), group->second, "of robot '" + robot.name() + "' is not in it");
}

OptionMap options_of(const io::RequestFile& request) {
  OptionMap options;
  if (request.allowed_planning_time) options["time_limit"] = *request.allowed_planning_time;
  if (request.velocity_scaling != 1.0) options["velocity_scaling"] = request.velocity_scaling;
  if (request.acceleration_scaling != 1.0) options["acceleration_scaling"] = request.acceleration_scaling;
  for (const PlannerInfo& planner : available_planners())
    if (planner.id == request.planner_id) options["planner_id"] = planner.id;
  return options;
}

/// max_cartesian_speed, for a link that the robot has.
std::vector<LinkSpeedLimit> link_speeds_of(const io::RequestFile& request, const RobotModel& robot) {
  if (!(request.max_cartesian_speed > 0.0)) return {};
  MotionLimits limits = default_limits(robot);
  limits.link_speeds = {{.link = request.cartesian_speed_limited_link, .speed = request.max_cartesian_speed}};
  try {
    require_limits(limits, robot.joint_names());
    require_bounds_of_robot(limits, robot);
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(request.path + ": max_cartesian_speed: " + error.what());
  }
  return limits.link_speeds;
}

}  // namespace

MoveItProblem moveit_problem(const io::RequestFile& request, const std::string& robot, Scene& scene) {
  require_group(request, *scene.robot(robot).model);
  Scene changed = scene;
  io::StartState start = io::apply_start(request, changed, robot);
  io::FrameLookup frames(changed, {}, robot);
  frames.set_configuration(robot, start.q);
  if (request.workspace) frames.require(request.workspace->frame, request.path + ": the workspace");
  std::vector<LinkSpeedLimit> link_speeds = link_speeds_of(request, *changed.robot(robot).model);
  std::vector<GoalConstraint> goals = moveit_goals(request, changed, frames, robot, start.q);
  std::vector<PathConstraint> constraints = moveit_path_constraints(request, changed, frames, robot);
  scene = std::move(changed);
  return {.start = std::move(start.q),
          .goals = std::move(goals),
          .options = options_of(request),
          .ignored_joints = std::move(start.unused_joints),
          .constraints = std::move(constraints),
          .start_velocity = std::move(start.velocity),
          .link_speeds = std::move(link_speeds)};
}

}  // namespace srmp
