#include "srmp/facade/moveit_group.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "srmp/facade/moveit_difference.hpp"
#include "srmp/facade/moveit_goals.hpp"
#include "srmp/facade/start_in_motion.hpp"
#include "srmp/io/moveit_rules.h"
#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"
#include "srmp/robot/joint_names.hpp"
#include "srmp/robot/urdf_edit.hpp"

namespace srmp {

namespace {

using Names = std::vector<std::string>;
using Code = MoveItErrorCode;

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::map<std::string, JointLimitEdit> limit_edits(const std::map<std::string, MoveItJointBounds>& bounds) {
  std::map<std::string, JointLimitEdit> edits;
  for (const auto& [joint, limits] : bounds) edits[joint] = {limits.lower, limits.upper, limits.velocity};
  return edits;
}

/// Joints that are not planned, moved onto a limit that they miss by as little as a sensor does.
io::SceneFile within_limits(io::SceneFile scene, const RobotModel& robot) {
  constexpr double sensor_error = 0.01;  // [rad or m]
  for (const Joint& joint : robot.other_joints()) {
    const auto given = scene.robot_state.joints.find(joint.name);
    if (given == scene.robot_state.joints.end()) continue;
    const double inside = std::clamp(given->second, joint.lower, joint.upper);
    if (std::abs(inside - given->second) > sensor_error)
      throw MoveItRefusal(Code::start_state_invalid, "the start is invalid: " + joint.name + ": " +
                                                         to_text(given->second) + " is outside of its limits " +
                                                         to_text(joint.lower) + " … " + to_text(joint.upper));
    given->second = inside;
  }
  return scene;
}

/// Why a scene cannot be applied: the first kind of name in it that does not exist.
Code scene_code(const io::SceneFile& target, const Scene& scene, const std::string& robot) {
  io::FrameLookup frames(scene, {}, robot);
  const auto known = [&](const std::string& frame) {
    const auto defines = [&](const io::FixedFrame& fixed) { return fixed.frame == frame || fixed.child == frame; };
    const auto is_in = [&](const io::CollisionObject& object) { return frame.starts_with(object.id); };
    return frames.find(frame) || std::any_of(target.fixed_frames.begin(), target.fixed_frames.end(), defines) ||
           std::any_of(target.objects.begin(), target.objects.end(), is_in);
  };
  for (const io::CollisionObject& object : target.objects)
    if (!known(object.frame)) return Code::frame_transform_failure;
  for (const io::AttachedObject& attached : target.robot_state.attached) {
    const auto link = frames.find(attached.link);
    if (!link || link->link.empty()) return Code::invalid_link_name;
    if (!attached.object.shapes.empty() && !known(attached.object.frame)) return Code::frame_transform_failure;
  }
  for (const auto& [link, padding] : target.link_padding)
    if (const auto frame = frames.find(link); !frame || frame->link.empty()) return Code::invalid_link_name;
  if (!target.robot_state.multi_dof_joints.empty() && !known(target.robot_state.multi_dof_frame))
    return Code::frame_transform_failure;
  return Code::invalid_object_name;
}

/// Why constraints cannot be read: the first kind of name in them that does not exist, or else `otherwise`.
Code constraints_code(const std::vector<io::GoalAlternative>& alternatives, const io::FrameLookup& frames,
                      Code otherwise) {
  const auto check = [&](const auto& constraints) {
    for (const auto& constraint : constraints) {
      if (!frames.find(constraint.frame)) return Code::frame_transform_failure;
      const auto link = frames.find(constraint.link);
      if (!link || link->link.empty()) return Code::invalid_link_name;
    }
    return otherwise;
  };
  for (const io::GoalAlternative& goal : alternatives)
    for (const Code code : {check(goal.positions), check(goal.orientations)})
      if (code != otherwise) return code;
  return otherwise;
}

/// One goal with the targets of all; plan_multi takes one for each robot.
GoalConstraint one_goal(const std::vector<GoalConstraint>& goals) {
  if (goals.empty()) return GoalConstraint::any();
  GoalConstraint all = goals.front();
  for (std::size_t i = 1; i < goals.size(); ++i) {
    if (goals[i].type != all.type || !(goals[i].position_tolerance == all.position_tolerance) ||
        !(goals[i].rotation_tolerance == all.rotation_tolerance))
      throw NotSupported("several regions of different sizes in one goal are not supported for groups of several arms");
    all.targets.insert(all.targets.end(), goals[i].targets.begin(), goals[i].targets.end());
  }
  return all;
}

/// The joints as the URDF names them.
Trajectory without_robot_names(Trajectory trajectory) {
  for (std::string& joint : trajectory.joint_names) joint.erase(0, joint.find('/') + 1);
  return trajectory;
}

}  // namespace

// --- the robot model

MoveItModel::MoveItModel(MoveItRobot given)
    : robot(std::move(given)),
      urdf_text(with_limits(robot.urdf_text, limit_edits(robot.bounds))),
      urdf(Urdf::parse(urdf_text)),
      srdf(Srdf::parse(robot.srdf_text, urdf)) {}

const SrdfGroup& MoveItModel::group(const std::string& name) const {
  const SrdfGroup* group = srdf.find_group(name);
  if (!group)
    throw MoveItRefusal(Code::invalid_group_name, "robot '" + urdf.name + "' has no group '" + name + "'" +
                                                      did_you_mean(name, srdf.group_names()));
  if (!group->fault.empty())
    throw MoveItRefusal(Code::invalid_group_name, "group '" + name + "' cannot be used: " + group->fault);
  if (joints_of(*group).empty())
    throw MoveItRefusal(Code::invalid_group_name, "group '" + name + "' has no movable joint");
  return *group;
}

Names MoveItModel::joints_of(const SrdfGroup& group) const {
  Names joints;
  for (const std::size_t joint : srdf.joints_of(group, urdf)) joints.push_back(urdf.joints[joint].name);
  return joints;
}

std::vector<std::size_t> MoveItModel::support(const std::string& link) const {
  std::vector<std::size_t> joints = urdf.chain_to(*urdf.find_link(link));
  std::erase_if(joints, [&](std::size_t joint) { return urdf.joints[joint].type == UrdfJointType::fixed; });
  return joints;
}

std::string MoveItModel::end_effector(const SrdfGroup& group, const std::string& link) const {
  const std::vector<std::size_t> joints = srdf.joints_of(group, urdf);
  const std::string last =
      group.chains.size() == 1 ? group.chains[0].second : urdf.links[urdf.joints[joints.back()].child].name;
  if (link.empty() || !urdf.find_link(link) || support(link) == support(last)) return last;
  const std::vector<std::size_t> above = support(link);
  const bool moves = std::any_of(joints.begin(), joints.end(), [&](std::size_t joint) {
    return std::find(above.begin(), above.end(), joint) != above.end();
  });
  return moves ? link : last;
}

std::map<std::string, std::set<std::string>> MoveItModel::moved_links(const Names& groups) const {
  std::map<std::string, std::set<std::string>> moved;
  for (const std::string& name : groups) {
    const Names joints = joints_of(group(name));
    for (const UrdfLink& link : urdf.links)
      for (const std::size_t joint : support(link.name))
        if (contains(joints, urdf.joints[joint].name)) moved[name].insert(link.name);
  }
  return moved;
}

bool MoveItModel::move_apart(const Names& groups) const {
  std::set<std::string> all;
  std::size_t sum = 0;
  for (const auto& [group, links] : moved_links(groups)) {
    all.insert(links.begin(), links.end());
    sum += links.size();
  }
  return sum == all.size();
}

// --- the robots of a group

MoveItGroup::MoveItGroup(const MoveItModel& model, const SrdfGroup& group, const std::string& end_effector,
                         const Names& arms) {
  RobotDescription description;
  description.urdf_text = model.urdf_text;
  description.srdf_text = model.robot.srdf_text;
  description.package_dirs = model.robot.package_dirs;
  description.name = model.urdf.name;
  description.group = group.name;
  description.end_effector = end_effector;
  if (arms.empty()) {
    add_robot(model, description);
    return;
  }
  // Each arm takes the links that it moves; the first one all others too.
  std::map<std::string, std::set<std::string>> moved = model.moved_links(arms);
  for (const std::string& arm : arms) {
    std::set<std::string> gone, bare;
    for (const UrdfLink& link : model.urdf.links) {
      const bool own = moved[arm].contains(link.name);
      const bool of_other = std::any_of(arms.begin(), arms.end(), [&](const std::string& other) {
        return other != arm && moved[other].contains(link.name);
      });
      if (own && of_other)
        throw MoveItRefusal(Code::invalid_group_name,
                            "link '" + link.name + "' is moved by more than one of the groups " + quoted_list(arms) +
                                ", so that they cannot be planned as several arms");
      if (of_other) gone.insert(link.name);
      if (!own && arm != arms.front()) bare.insert(link.name);
    }
    description.urdf_text = without_links(model.urdf_text, gone, bare);
    description.name = arm;
    description.group = arm;
    description.end_effector = model.end_effector(model.group(arm), end_effector);
    add_robot(model, description);
  }
  allow_between(model);
}

void MoveItGroup::add_robot(const MoveItModel& model, RobotDescription description) {
  planner_.add_articulation(description);
  const std::string& name = description.name;
  arms_.push_back({name});
  MotionLimits limits = default_limits(planner_.robot(name));
  const Names& joints = planner_.robot(name).joint_names();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto bounds = model.robot.bounds.find(joints[i]);
    if (bounds == model.robot.bounds.end()) continue;
    const auto k = static_cast<Eigen::Index>(i);
    if (bounds->second.velocity) limits.velocity[k] = *bounds->second.velocity;
    if (bounds->second.acceleration) limits.acceleration[k] = *bounds->second.acceleration;
    if (bounds->second.jerk) limits.jerk[k] = *bounds->second.jerk;
  }
  planner_.set_motion_limits(name, limits);
}

/// What the SRDF allows between links of different arms.
void MoveItGroup::allow_between(const MoveItModel& model) {
  const auto allow = [&](const std::string& a, const std::string& b) {
    for (const Arm& one : arms_)
      for (const Arm& other : arms_) {
        const auto has = [&](const Arm& arm, const std::string& link) {
          const auto& geometries = planner_.robot(arm.robot).geometries();
          return std::any_of(geometries.begin(), geometries.end(), [&](const auto& g) { return g.link == link; });
        };
        if (one.robot != other.robot && has(one, a) && has(other, b))
          between_[{one.robot + "/" + a, other.robot + "/" + b}] = true;
      }
  };
  for (const auto& [a, b] : model.srdf.disabled) allow(a, b);
  for (const UrdfJoint& joint : model.urdf.joints)
    allow(model.urdf.links[joint.parent].name, model.urdf.links[joint.child].name);
}

Names MoveItGroup::planned_joints() const {
  Names joints;
  for (const Arm& arm : arms_) {
    const Names& own = planner_.robot(arm.robot).joint_names();
    joints.insert(joints.end(), own.begin(), own.end());
  }
  return joints;
}

// --- the scene

std::vector<std::string> MoveItGroup::update(const io::SceneFile& given) {
  io::SceneFile target = given;
  target.robot_model_name = arms_.front().robot;  // where several arms have a link, the first one has its geometry
  for (const Arm& arm : arms_) target = within_limits(std::move(target), planner_.robot(arm.robot));
  const io::FrameLookup frames(planner_.scene(), {}, arms_.front().robot);
  const auto moves = [&](const std::string& name) {
    const auto frame = frames.find(name);
    return frame && frames.moves(*frame);
  };
  const std::vector<io::SceneFile> changes = scene_difference(held_, target, planned_joints(), moves);
  if (!changes.empty()) {
    Scene scene = planner_.scene();
    scene.clear_allowed_collisions();
    for (const auto& [pair, allowed] : between_) scene.set_allowed_collision(pair.first, pair.second, allowed);
    for (const Arm& arm : arms_) scene.set_robot_padding(arm.robot, 0.0);
    Names notes;
    try {
      for (const io::SceneFile& change : changes) notes = io::apply(change, scene);
    } catch (const InvalidArgument& error) {
      throw MoveItRefusal(scene_code(target, planner_.scene(), arms_.front().robot), error.what());
    } catch (const NotSupported& error) {
      throw MoveItRefusal(Code::collision_checking_unavailable, error.what());
    }
    place_arms(target, scene);
    planner_.set_scene(std::move(scene));
    notes_ = std::move(notes);
  }
  held_ = std::move(target);
  return notes_;
}

/// io::apply moves one robot for each name; the arms of one robot have a base and joints in common.
void MoveItGroup::place_arms(const io::SceneFile& target, Scene& scene) const {
  const Pose base = scene.robot(arms_.front().robot).base;
  for (std::size_t i = 1; i < arms_.size(); ++i) {
    const std::string& robot = arms_[i].robot;
    scene.set_base_pose(robot, base);
    scene.set_robot_padding(robot, scene.robot(arms_.front().robot).padding);
    std::map<std::string, double> joints;
    for (const Joint& joint : scene.robot(robot).model->other_joints())
      if (const auto given = target.robot_state.joints.find(joint.name); given != target.robot_state.joints.end())
        joints.insert(*given);
    scene.set_joint_positions(robot, joints);
  }
}

// --- the request

Eigen::VectorXd MoveItGroup::start_of(const std::string& robot) const {
  const Names& names = planner_.robot(robot).joint_names();
  Eigen::VectorXd start(static_cast<Eigen::Index>(names.size()));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto given = held_.robot_state.joints.find(names[i]);
    if (given == held_.robot_state.joints.end())
      throw MoveItRefusal(Code::start_state_invalid,
                          "neither the start state nor the scene's robot state says where "
                          "joint '" +
                              names[i] + "' is");
    start[static_cast<Eigen::Index>(i)] = given->second;
  }
  return start;
}

/// The constraints of the request that are for this arm.
io::RequestFile MoveItGroup::part_of(const io::RequestFile& request, const Arm& arm,
                                     const io::FrameLookup& frames) const {
  io::RequestFile part = request;
  const auto of_other = [&](const auto& constraint) {
    const auto frame = frames.find(constraint.link);
    return frame ? frame->robot != arm.robot : &arm != &arms_.front();
  };
  for (io::GoalAlternative& goal : part.goals) {
    std::erase_if(goal.joints, [&](const io::JointConstraint& constraint) {
      for (const Arm& other : arms_)
        if (contains(planner_.robot(other.robot).joint_names(), constraint.joint)) return other.robot != arm.robot;
      return &arm != &arms_.front();
    });
    std::erase_if(goal.positions, of_other);
    std::erase_if(goal.orientations, of_other);
  }
  std::erase_if(part.goals, [](const io::GoalAlternative& goal) {
    return goal.joints.empty() && goal.positions.empty() && goal.orientations.empty();
  });
  return part;
}

void MoveItGroup::read_goals(const io::RequestFile& request) {
  if (arms_.size() > 1 && request.goals.size() > 1)
    throw MoveItRefusal(Code::invalid_goal_constraints,
                        "several alternative goals are not supported for groups of several arms");
  for (Arm& arm : arms_) {
    arm.start = start_of(arm.robot);
    arm.goals.clear();
  }
  for (Arm& arm : arms_) {
    io::FrameLookup frames(planner_.scene(), {}, arm.robot);
    for (const Arm& other : arms_) frames.set_configuration(other.robot, other.start);
    frames.define(held_.fixed_frames);
    if (request.workspace && !frames.find(request.workspace->frame))
      throw MoveItRefusal(Code::frame_transform_failure,
                          "the workspace is in the unknown frame '" + request.workspace->frame + "'");
    const io::RequestFile part = arms_.size() == 1 ? request : part_of(request, arm, frames);
    try {
      arm.goals = moveit_goals(part, planner_.scene(), frames, arm.robot, arm.start);
      if (arms_.size() > 1) arm.goals = {one_goal(arm.goals)};
    } catch (const InvalidArgument& error) {
      throw MoveItRefusal(constraints_code(part.goals, frames, Code::invalid_goal_constraints), error.what());
    } catch (const NotSupported& error) {
      throw MoveItRefusal(Code::invalid_goal_constraints, error.what());
    }
    read_path_constraints(request, frames, arm);
  }
}

void MoveItGroup::read_path_constraints(const io::RequestFile& request, const io::FrameLookup& frames, Arm& arm) const {
  arm.constraints.clear();
  if (io::holds_nothing(request.path_constraints)) return;
  if (arms_.size() > 1)
    throw MoveItRefusal(Code::planning_failed, "path_constraints are not supported for groups of several arms");
  try {
    arm.constraints = moveit_path_constraints(request, planner_.scene(), frames, arm.robot);
    place_constraints(planner_.scene(), arm.robot, arm.constraints);
  } catch (const InvalidArgument& error) {
    throw MoveItRefusal(constraints_code({request.path_constraints}, frames, Code::planning_failed), error.what());
  }
}

Eigen::VectorXd MoveItGroup::start_velocity_of(const io::RequestFile& request) const {
  return refused_with(Code::start_state_invalid, Code::start_state_invalid, "the request: ", [&] {
    Eigen::VectorXd velocity;
    for (const Arm& arm : arms_) {
      velocity = io::start_velocity(request.start_state, planner_.robot(arm.robot));
      if (arms_.size() > 1 && velocity.size())
        throw NotSupported("starts in motion are not supported for groups of several arms");
    }
    return velocity;
  });
}

Trajectory MoveItGroup::plan_one(const io::RequestFile& request, const PlannerInterface::Interrupt& stop) {
  const Arm& arm = arms_.front();
  const PlanRequest wanted{.robot = arm.robot,
                           .start = arm.start,
                           .goals = arm.goals,
                           .constraints = arm.constraints,
                           .start_velocity = start_velocity_of(request)};
  in_motion_ = wanted.start_velocity.size() > 0;
  if (in_motion_) {
    const CommonOptions common = common_options(planner_.planner_options({arm.robot}));
    refused_with(Code::planning_failed, Code::planning_failed, "the request's planner: ", [&] {
      timing_in_motion(common);
      require_no_sample_rate(common, "a motion that begins in motion");
    });
    const RobotInstance& instance = planner_.scene().robot(arm.robot);
    refused_with(Code::start_state_invalid, Code::start_state_invalid, "the request: ", [&] {
      require_start_in_motion(wanted, {instance.model, instance.base, instance.other_positions},
                              scaled(planner_.motion_limits(arm.robot), common), common);
    });
  }
  return planner_.plan(wanted, stop);
}

/// max_cartesian_speed, of the arms that move its link.
void MoveItGroup::limit_speed(const io::RequestFile& request) {
  const std::string& link = request.cartesian_speed_limited_link;
  const bool limited = request.max_cartesian_speed > 0.0;
  std::size_t found = 0;
  for (const Arm& arm : arms_) {
    const RobotModel& robot = planner_.robot(arm.robot);
    const Names& links = robot.link_names();
    MotionLimits limits = planner_.motion_limits(arm.robot);
    limits.link_speeds.clear();
    if (limited && (link.empty() || (contains(links, link) && robot.link_support(robot.link_index(link)) != 0))) {
      limits.link_speeds = {{.link = link, .speed = request.max_cartesian_speed}};
      ++found;
    }
    planner_.set_motion_limits(arm.robot, std::move(limits));
  }
  if (limited && found == 0)
    throw MoveItRefusal(Code::invalid_link_name,
                        "the request's cartesian_speed_limited_link '" + link + "' is no link that the group moves");
}

Trajectory MoveItGroup::plan(const io::RequestFile& request, const OptionMap& options,
                             const PlannerInterface::Interrupt& stop) {
  in_motion_ = false;
  read_goals(request);
  Names robots;
  for (const Arm& arm : arms_) robots.push_back(arm.robot);
  planner_.make_planner(robots, options);
  limit_speed(request);
  if (arms_.size() == 1) return plan_one(request, stop);
  start_velocity_of(request);
  std::map<std::string, Eigen::VectorXd> starts;
  std::map<std::string, GoalConstraint> goals;
  for (const Arm& arm : arms_) {
    starts.emplace(arm.robot, arm.start);
    goals.emplace(arm.robot, arm.goals[0]);
  }
  return without_robot_names(planner_.plan_multi(starts, goals, {}, stop).merged());
}

// --- failures

MoveItErrorCode MoveItGroup::code_of(const PlanningError& error) const {
  switch (error.status()) {
    case Status::timed_out: return Code::timed_out;
    case Status::cancelled: return Code::preempted;
    case Status::start_invalid:
      for (const Arm& arm : arms_) {
        if (planner_.robot(arm.robot).limit_violation(arm.start)) return Code::start_state_invalid;
        if (breaks_path_constraints(arm, arm.start)) return Code::start_violates_path_constraints;
      }
      // A start that is free itself, but from whose velocity the robot cannot stop in time.
      if (in_motion_ && !planner_.is_state_colliding(arms_.front().robot, arms_.front().start))
        return Code::start_state_invalid;
      return Code::start_state_in_collision;
    case Status::goal_invalid:
      for (const Arm& arm : arms_)
        if (const Code code = goal_failure(arm); code != Code::goal_in_collision) return code;
      return Code::goal_in_collision;
    default: return Code::planning_failed;
  }
}

bool MoveItGroup::breaks_path_constraints(const Arm& arm, const Eigen::VectorXd& q) const {
  const auto placed = place_constraints(planner_.scene(), arm.robot, arm.constraints);
  return placed && ConstraintChecker(*placed).deviation(q) > 1.0;
}

/// Why a configuration within limits that meets a goal cannot be reached.
MoveItErrorCode MoveItGroup::goal_failure_at(const Arm& arm, const Eigen::VectorXd& q) const {
  const bool breaks = breaks_path_constraints(arm, q) && !planner_.is_state_colliding(arm.robot, q);
  return breaks ? Code::goal_violates_path_constraints : Code::goal_in_collision;
}

/// Of the first configuration within limits that meets a goal.
MoveItErrorCode MoveItGroup::goal_failure(const Arm& arm) const {
  Code code = Code::goal_in_collision;
  for (const GoalConstraint& goal : arm.goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      if (goal.type == GoalType::joints) {
        code =
            planner_.robot(arm.robot).limit_violation(target) ? Code::goal_state_invalid : goal_failure_at(arm, target);
      } else {
        IkOptions options;
        options.max_solutions = 1;
        options.position_tolerance = goal.position_tolerance;
        options.rotation_tolerance = goal.type == GoalType::pose
                                         ? goal.rotation_tolerance
                                         : AxisTolerance(std::numeric_limits<double>::infinity());
        const Pose pose = goal.type == GoalType::pose ? Pose::from_list({target.data(), 7}) : Pose{target.head<3>()};
        const std::vector<Eigen::VectorXd> found = planner_.compute_ik(arm.robot, pose, arm.start, options);
        code = found.empty() ? Code::no_ik_solution : goal_failure_at(arm, found.front());
      }
      if (code == Code::goal_in_collision || code == Code::goal_violates_path_constraints) return code;
    }
  return code;
}

}  // namespace srmp
