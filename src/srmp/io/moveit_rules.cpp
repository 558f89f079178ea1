#include "srmp/io/moveit_rules.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/robot/joint_names.hpp"

namespace srmp::io {

namespace {

void refuse_if(const std::string& fault) {
  if (!fault.empty()) throw InvalidArgument(fault);
}

void require_finite_number(double value, const std::string& what) {
  if (!std::isfinite(value)) throw InvalidArgument(what + " is " + to_text(value) + "; it must be finite");
}

void require_finite_pose(const Pose& pose, const std::string& what) {
  if (!pose.p.allFinite() || !pose.q.coeffs().allFinite())
    throw InvalidArgument(what + " holds NaN or infinity; it must be finite");
}

void require_valid(const JointConstraint& constraint) {
  require_finite_number(constraint.position, constraint.joint + "'s position");
  refuse_if(tolerance_fault("tolerance_above", constraint.tolerance_above));
  refuse_if(tolerance_fault("tolerance_below", constraint.tolerance_below));
}

void require_valid(const PositionConstraint& constraint) {
  if (constraint.mesh_regions > 0)
    throw NotSupported("a constraint region has meshes, which are not supported; use boxes, spheres or cylinders");
  if (constraint.regions.empty()) throw InvalidArgument("a constraint region has no primitives");
  if (!constraint.offset.allFinite())
    throw InvalidArgument("target_point_offset holds NaN or infinity; it must be finite");
  for (const PlacedShape& region : constraint.regions) {
    require_finite_pose(region.pose, "a constraint region's pose");
    const bool known = std::holds_alternative<Box>(region.shape) || std::holds_alternative<Sphere>(region.shape) ||
                       std::holds_alternative<Cylinder>(region.shape);
    if (!known)
      throw NotSupported("a constraint region that is a " + shape_kind(region.shape) +
                         " is not supported; use boxes, spheres or cylinders");
  }
}

void require_valid(const OrientationConstraint& constraint) {
  refuse_if(length_fault(constraint.orientation.norm()));
  const char* const fields[] = {"absolute_x_axis_tolerance", "absolute_y_axis_tolerance", "absolute_z_axis_tolerance"};
  for (int axis = 0; axis < 3; ++axis) refuse_if(tolerance_fault(fields[axis], constraint.tolerance[axis]));
}

void require_valid(const CollisionObject& object, bool shapes_may_be_absent) {
  const std::string what = "object '" + object.id + "'";
  if (object.planes > 0) throw NotSupported(what + " has planes" + plane_fault);
  require_finite_pose(object.pose, what + "'s pose");
  if (object.operation < ObjectOperation::add || object.operation > ObjectOperation::move)
    throw InvalidArgument(what + " has the unknown operation " + std::to_string(static_cast<int>(object.operation)));
  if (object.operation == ObjectOperation::remove || object.operation == ObjectOperation::move) return;
  if (object.id.empty()) throw InvalidArgument("a collision object's id is empty");
  if (object.shapes.empty() && !shapes_may_be_absent)
    throw InvalidArgument(what + " has no shape: neither primitives nor meshes");
  for (const PlacedShape& shape : object.shapes) require_finite_pose(shape.pose, what + "'s pose");
}

}  // namespace

std::string scaling_fault(const std::string& field, double value) {
  if (value >= 0.0 && value <= 1.0) return "";
  return field + " is " + to_text(value) + "; it must be in 0 … 1 (0 means 1)";
}

std::string tolerance_fault(const std::string& field, double value) {
  return value >= 0.0 ? "" : field + " is " + to_text(value) + "; it must be 0 or above";
}

std::string time_fault(double time) {
  if (time >= 0.0 && std::isfinite(time)) return "";
  return "allowed_planning_time is " + to_text(time) + "; it must be 0 (not said) or above";
}

std::string attempts_fault(double attempts) {
  if (attempts >= 0.0 && attempts == std::floor(attempts)) return "";
  return "num_planning_attempts is " + to_text(attempts) + "; it must be a whole number, 0 or above";
}

std::string workspace_fault(const WorkspaceBounds& bounds) {
  for (int i = 0; i < 3; ++i)
    if (!(bounds.min_corner[i] <= bounds.max_corner[i]))
      return "the workspace's min_corner " + to_text(bounds.min_corner[i]) + " is above its max_corner " +
             to_text(bounds.max_corner[i]) + " along " + "xyz"[i];
  return "";
}

std::string length_fault(double length) {
  if (std::abs(length - 1.0) <= 1e-3) return "";
  return "an orientation constraint's quaternion has the length " + to_text(length) + "; it must be 1";
}

std::string padding_fault(const std::string& link, double padding) {
  if (padding >= 0.0 && std::isfinite(padding)) return "";
  return "the padding of link '" + link + "' is " + to_text(padding) + "; it must be 0 or above";
}

std::string cartesian_speed_fault(double speed) {
  if (std::isfinite(speed)) return "";
  return "max_cartesian_speed is " + to_text(speed) + "; it must be a finite number [m/s], 0 or below for no limit";
}

std::string unsupported(const std::string& field) { return field + " are not supported"; }

std::string twice_fault(const std::string& joint) { return "joint '" + joint + "' is constrained twice in one goal"; }

std::string scale_fault(const std::string& link) {
  return "the scene sets the scale of link '" + link + "', which is not supported; set a padding";
}

void require_valid(const RobotState& start) {
  for (const auto& [joint, position] : start.joints)
    require_finite_number(position, "the start state's position of joint '" + joint + "'");
  for (const auto& [joint, pose] : start.multi_dof_joints)
    require_finite_pose(pose, "the start state's transform of joint '" + joint + "'");
  for (const auto& [joint, velocity] : start.velocities)
    require_finite_number(velocity, "the start state's velocity of joint '" + joint + "'");
  for (const AttachedObject& attached : start.attached) require_valid(attached.object, true);
  if (!(std::abs(start.speed) <= rest_speed))
    throw NotSupported("the start state has a twist of " + to_text(start.speed) +
                       "; bases must be at rest at the start");
}

void require_valid(const GoalAlternative& goal) {
  if (goal.visibilities > 0) throw NotSupported(unsupported("visibility_constraints"));
  if (goal.joints.empty() && goal.positions.empty() && goal.orientations.empty())
    throw InvalidArgument("a goal holds no constraints");
  std::set<std::string> joints;
  for (const JointConstraint& constraint : goal.joints) {
    require_valid(constraint);
    if (!joints.insert(constraint.joint).second) throw InvalidArgument(twice_fault(constraint.joint));
  }
  for (const PositionConstraint& constraint : goal.positions) require_valid(constraint);
  for (const OrientationConstraint& constraint : goal.orientations) require_valid(constraint);
}

void require_valid(const RequestFile& request) {
  refuse_if(scaling_fault("max_velocity_scaling_factor", request.velocity_scaling));
  refuse_if(scaling_fault("max_acceleration_scaling_factor", request.acceleration_scaling));
  refuse_if(time_fault(request.allowed_planning_time.value_or(0.0)));
  refuse_if(attempts_fault(request.attempts));
  if (request.workspace) refuse_if(workspace_fault(*request.workspace));
  const GoalAlternative& path = request.path_constraints;
  for (const PositionConstraint& constraint : path.positions) require_valid(constraint);
  for (const OrientationConstraint& constraint : path.orientations) require_valid(constraint);
  if (const std::string fault = path_constraints_fault(path); !fault.empty()) throw NotSupported(fault);
  if (request.trajectory_constraints > 0) throw NotSupported(unsupported("trajectory_constraints"));
  if (request.reference_trajectories > 0) throw NotSupported(unsupported("reference_trajectories"));
  refuse_if(cartesian_speed_fault(request.max_cartesian_speed));
  if (request.goals.empty()) throw InvalidArgument("a motion plan request has no goal_constraints");
}

void require_valid(const SceneFile& scene) {
  std::set<std::string> added;
  for (const CollisionObject& object : scene.objects) {
    require_valid(object, false);
    if (object.operation == ObjectOperation::add && !added.insert(object.id).second)
      throw InvalidArgument("there are two objects named '" + object.id + "'; names must be unique");
  }
  for (const AttachedObject& attached : scene.robot_state.attached) require_valid(attached.object, true);
  for (const auto& [link, padding] : scene.link_padding) refuse_if(padding_fault(link, padding));
  for (const auto& [link, scale] : scene.link_scale)
    if (scale != 1.0) throw NotSupported(scale_fault(link));
  const std::size_t names = scene.allowed_collisions.names.size();
  const auto wrong_row = [&](const std::vector<bool>& row) { return row.size() != names; };
  if (scene.allowed_collisions.entries.size() != names ||
      std::any_of(scene.allowed_collisions.entries.begin(), scene.allowed_collisions.entries.end(), wrong_row))
    throw InvalidArgument(
        "the allowed collision matrix is not square: it must have a row and a column for each of its " +
        std::to_string(names) + " names");
}

std::string path_constraints_fault(const GoalAlternative& path) {
  if (!path.joints.empty()) return "joint_constraints in path_constraints are not supported; narrow the joints' limits";
  if (path.visibilities > 0) return "visibility_constraints in path_constraints are not supported";
  for (const PositionConstraint& constraint : path.positions) {
    if (constraint.regions.size() > 1)
      return "several primitives in one region of path_constraints, which are alternatives, are not supported";
    for (const PlacedShape& region : constraint.regions)
      if (!std::holds_alternative<Box>(region.shape) && !std::holds_alternative<Sphere>(region.shape))
        return "a region of path_constraints that is a " + shape_kind(region.shape) +
               " is not supported; use a box or a sphere";
  }
  return "";
}

bool holds_nothing(const GoalAlternative& constraints) {
  return constraints.joints.empty() && constraints.positions.empty() && constraints.orientations.empty() &&
         constraints.visibilities == 0;
}

bool is_moving(const RobotState& start) {
  return std::any_of(start.velocities.begin(), start.velocities.end(),
                     [](const auto& joint) { return std::abs(joint.second) > rest_speed; });
}

Eigen::VectorXd start_velocity(const RobotState& start, const RobotModel& robot) {
  const std::vector<std::string>& planned = robot.joint_names();
  Eigen::VectorXd velocity = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(planned.size()));
  for (const auto& [joint, value] : start.velocities) {
    if (const auto it = std::find(planned.begin(), planned.end(), joint); it != planned.end())
      velocity[it - planned.begin()] = value;
    else if (std::abs(value) > rest_speed && find_joint(robot.other_joints(), joint))
      throw NotSupported("the start state has a velocity of " + to_text(value) + " of joint '" + joint +
                         "', which is not planned; only planned joints may move at the start");
  }
  return velocity.size() && velocity.cwiseAbs().maxCoeff() > rest_speed ? velocity : Eigen::VectorXd();
}

Shape solid_primitive(int type, const std::vector<double>& dimensions) {
  if (type == 5) throw NotSupported(prism_fault);
  if (type < 1 || type > 4)
    throw InvalidArgument("has the unknown type " + std::to_string(type) +
                          "; known are 1 (box), 2 (sphere), 3 (cylinder) and 4 (cone)");
  const std::size_t count = type == 1 ? 3 : type == 2 ? 1 : 2;
  if (dimensions.size() < count)
    throw InvalidArgument("has " + std::to_string(dimensions.size()) + " dimensions; it must have " +
                          std::to_string(count));
  for (std::size_t i = 0; i < count; ++i)
    if (!(dimensions[i] > 0.0 && std::isfinite(dimensions[i])))
      throw InvalidArgument("has the dimension " + to_text(dimensions[i]) + "; all must be above 0");
  switch (type) {
    case 1: return Box{{dimensions[0], dimensions[1], dimensions[2]}};
    case 2: return Sphere{dimensions[0]};
    case 3: return Cylinder{.radius = dimensions[1], .length = dimensions[0]};  // the message has the height first
    default: return Cone{.radius = dimensions[1], .length = dimensions[0]};
  }
}

}  // namespace srmp::io
