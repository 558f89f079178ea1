#include "messages.hpp"

#include <geometric_shapes/shapes.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>
#include <srmp/core/error.hpp>

namespace srmp_moveit {

namespace {

using srmp::Pose;
using Code = srmp::MoveItErrorCode;

/// With which codes a shape is refused.
struct ShapeCodes {
  Code invalid, unsupported;
};
constexpr ShapeCodes of_object{Code::invalid_object_name, Code::collision_checking_unavailable};

template <class Vector>
Eigen::Vector3d vector_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

/// A quaternion of four zeros, as in an unset ROS 1 message, is the identity.
template <class Quaternion>
Pose pose_of(const Eigen::Vector3d& p, const Quaternion& q) {
  if (q.x == 0.0 && q.y == 0.0 && q.z == 0.0 && q.w == 0.0) return Pose{p};
  return Pose{p, Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized()};
}
Pose pose_of(const geometry_messages::Pose& pose) { return pose_of(vector_of(pose.position), pose.orientation); }
Pose pose_of(const geometry_messages::Transform& t) { return pose_of(vector_of(t.translation), t.rotation); }

srmp::Shape shape_of(const Library& library, const shape_messages::SolidPrimitive& primitive, const std::string& what,
                     const ShapeCodes& codes) {
  try {
    return library.solid_primitive(primitive.type, {primitive.dimensions.begin(), primitive.dimensions.end()});
  } catch (const srmp::NotSupported& error) {
    throw Refusal(codes.unsupported, what + " " + error.what());
  } catch (const srmp::Error& error) {
    throw Refusal(codes.invalid, what + " " + error.what());
  }
}

srmp::Shape shape_of(const shape_messages::Mesh& message, const std::string& what) {
  srmp::Mesh mesh;
  for (const auto& vertex : message.vertices) mesh.vertices.push_back(vector_of(vertex));
  for (const auto& triangle : message.triangles) {
    const auto& i = triangle.vertex_indices;
    for (const auto index : i)
      if (index >= mesh.vertices.size())
        throw Refusal(of_object.invalid, "a mesh of " + what + " has the index " + std::to_string(index) + ", but " +
                                             std::to_string(mesh.vertices.size()) + " vertices");
    mesh.triangles.push_back({static_cast<int>(i[0]), static_cast<int>(i[1]), static_cast<int>(i[2])});
  }
  return mesh;
}

/// MoveIt places a shape without a pose at the object's.
template <class Poses>
Pose nth(const Poses& poses, std::size_t i) {
  return i < poses.size() ? pose_of(poses[i]) : Pose{};
}

std::vector<srmp::io::PlacedShape> shapes_of(const Library& library, const moveit_messages::CollisionObject& message) {
  const std::string what = "object '" + message.id + "'";
  std::vector<srmp::io::PlacedShape> shapes;
  for (std::size_t i = 0; i < message.primitives.size(); ++i)
    shapes.push_back({shape_of(library, message.primitives[i], what, of_object), nth(message.primitive_poses, i)});
  for (std::size_t i = 0; i < message.meshes.size(); ++i)
    shapes.push_back({shape_of(message.meshes[i], what), nth(message.mesh_poses, i)});
  return shapes;
}

srmp::io::CollisionObject object_of(const Library& library, const moveit_messages::CollisionObject& message) {
  srmp::io::CollisionObject object;
  object.id = message.id;
  object.frame = message.header.frame_id;
  object.pose = pose_of(message.pose);
  object.planes = message.planes.size();
  if (message.operation < moveit_messages::CollisionObject::ADD ||
      message.operation > moveit_messages::CollisionObject::MOVE)
    throw Refusal(Code::invalid_object_name, "object '" + message.id + "' has the unknown operation " +
                                                 std::to_string(message.operation) +
                                                 "; known are 0 (add), 1 (remove), 2 (append) and 3 (move)");
  object.operation = static_cast<srmp::io::ObjectOperation>(message.operation);  // the same numbers
  object.shapes = shapes_of(library, message);
  for (std::size_t i = 0; i < message.subframe_names.size(); ++i)
    object.subframes[message.subframe_names[i]] = nth(message.subframe_poses, i);
  return object;
}

template <class Twist>
double speed_of(const Twist& twist) {
  return std::max(vector_of(twist.linear).norm(), vector_of(twist.angular).norm());
}

double speed_of(const moveit_messages::RobotState& message) {
  double speed = 0.0;
  for (const auto& twist : message.multi_dof_joint_state.twist) speed = std::max(speed, speed_of(twist));
  return speed;
}

std::vector<srmp::io::AttachedObject> attached_of(const Library& library, const moveit_messages::RobotState& message) {
  std::vector<srmp::io::AttachedObject> objects;
  for (const auto& attached : message.attached_collision_objects)
    objects.push_back({attached.link_name,
                       object_of(library, attached.object),
                       {attached.touch_links.begin(), attached.touch_links.end()}});
  return objects;
}

/// A list of a state must have an entry for each name.
void require_one_each(const std::string& state, std::size_t names, std::size_t values, const std::string& what) {
  if (names != values)
    throw Refusal(Code::invalid_robot_state, state + " names " + std::to_string(names) + " joints, but has " +
                                                 std::to_string(values) + " " + what);
}

/// MoveIt passes over what it does not understand of a start state, and plans from elsewhere; here it is refused.
void require_understood(const moveit_messages::RobotState& start, const planning_scene::PlanningScene& scene) {
  const auto& joints = start.joint_state;
  require_one_each("the start state's joint_state", joints.name.size(), joints.position.size(), "positions");
  if (!joints.velocity.empty())
    require_one_each("the start state's joint_state", joints.name.size(), joints.velocity.size(), "velocities");
  const auto& variables = scene.getRobotModel()->getVariableNames();
  for (const std::string& joint : joints.name)
    if (std::find(variables.begin(), variables.end(), joint) == variables.end())
      throw Refusal(Code::start_state_invalid,
                    "the start state names joint '" + joint + "', which is no movable joint of the robot model");
  const auto& others = start.multi_dof_joint_state;
  require_one_each("the start state's multi_dof_joint_state", others.joint_names.size(), others.transforms.size(),
                   "transforms");
  for (const std::string& joint : others.joint_names)
    if (!scene.getRobotModel()->hasJointModel(joint))
      throw Refusal(Code::start_state_invalid,
                    "the start state names joint '" + joint + "', which is no joint of the robot model");
  const std::string& frame = others.header.frame_id;
  if (!others.joint_names.empty() && !frame.empty() && !scene.knowsFrameTransform(frame))
    throw Refusal(Code::frame_transform_failure,
                  "the start state's multi_dof_joint_state is in the unknown frame '" + frame + "'");
}

/// `message` was written by MoveIt.
srmp::io::RobotState state_of(const Library& library, const moveit_messages::RobotState& message) {
  srmp::io::RobotState state;
  state.is_diff = message.is_diff;
  const auto& joints = message.joint_state;
  for (std::size_t i = 0; i < joints.name.size(); ++i) state.joints[joints.name[i]] = joints.position.at(i);
  for (std::size_t i = 0; i < joints.velocity.size(); ++i) state.velocities[joints.name[i]] = joints.velocity[i];
  const auto& others = message.multi_dof_joint_state;
  state.multi_dof_frame = others.header.frame_id;
  for (std::size_t i = 0; i < others.joint_names.size() && i < others.transforms.size(); ++i)
    state.multi_dof_joints[others.joint_names[i]] = pose_of(others.transforms[i]);
  state.attached = attached_of(library, message);
  return state;
}

srmp::io::AllowedCollisionMatrix matrix_of(const moveit_messages::AllowedCollisionMatrix& message) {
  srmp::io::AllowedCollisionMatrix matrix;
  matrix.names = {message.entry_names.begin(), message.entry_names.end()};
  for (const auto& row : message.entry_values) matrix.entries.emplace_back(row.enabled.begin(), row.enabled.end());
  if (message.default_entry_names.size() != message.default_entry_values.size())
    throw Refusal(Code::invalid_object_name,
                  "the allowed collision matrix has " + std::to_string(message.default_entry_names.size()) +
                      " default_entry_names, but " + std::to_string(message.default_entry_values.size()) +
                      " default_entry_values");
  for (std::size_t i = 0; i < message.default_entry_names.size(); ++i)
    matrix.defaults[message.default_entry_names[i]] = message.default_entry_values[i];
  return matrix;
}

/// The occupied cells of the scene's octomap; larger cells as several of the smallest.
void add_octomap(const planning_scene::PlanningScene& scene, srmp::io::SceneFile& result) {
  const auto object = scene.getWorld()->getObject(planning_scene::PlanningScene::OCTOMAP_NS);
  if (!object) return;
  for (std::size_t i = 0; i < object->shapes_.size(); ++i) {
    const auto* tree_shape = dynamic_cast<const shapes::OcTree*>(object->shapes_[i].get());
    if (!tree_shape || !tree_shape->octree) continue;
    const octomap::OcTree& tree = *tree_shape->octree;
    srmp::PointCloud cloud{{}, tree.getResolution()};
    for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
      if (!tree.isNodeOccupied(*leaf)) continue;
      const int cells = static_cast<int>(std::lround(leaf.getSize() / tree.getResolution()));
      const Eigen::Vector3d corner =
          Eigen::Vector3d(leaf.getX(), leaf.getY(), leaf.getZ()).array() - 0.5 * (cells - 1) * tree.getResolution();
      for (int x = 0; x < cells; ++x)
        for (int y = 0; y < cells; ++y)
          for (int z = 0; z < cells; ++z)
            cloud.points.push_back(corner + tree.getResolution() * Eigen::Vector3d(x, y, z));
    }
    if (cloud.points.empty()) continue;
    const Eigen::Isometry3d& place = object->global_shape_poses_[i];
    srmp::io::CollisionObject cells;
    cells.id = planning_scene::PlanningScene::OCTOMAP_NS;
    cells.shapes.push_back({std::move(cloud), Pose{place.translation(), Eigen::Quaterniond(place.rotation())}});
    result.objects.push_back(std::move(cells));
  }
}

/// `code`: with which regions that are wrong are refused.
srmp::io::GoalAlternative constraints_of(const Library& library, const moveit_messages::Constraints& message,
                                         Code code) {
  srmp::io::GoalAlternative goal;
  goal.name = message.name;
  goal.visibilities = message.visibility_constraints.size();
  for (const auto& joint : message.joint_constraints)
    goal.joints.push_back({joint.joint_name, joint.position, joint.tolerance_above, joint.tolerance_below});
  for (const auto& position : message.position_constraints) {
    srmp::io::PositionConstraint constraint;
    constraint.link = position.link_name;
    constraint.frame = position.header.frame_id;
    constraint.offset = vector_of(position.target_point_offset);
    const auto& region = position.constraint_region;
    constraint.mesh_regions = region.meshes.size();
    for (std::size_t i = 0; i < region.primitives.size(); ++i)
      constraint.regions.push_back({shape_of(library, region.primitives[i], "a constraint region", {code, code}),
                                    nth(region.primitive_poses, i)});
    goal.positions.push_back(std::move(constraint));
  }
  for (const auto& orientation : message.orientation_constraints) {
    const auto& q = orientation.orientation;
    goal.orientations.push_back({orientation.link_name,
                                 orientation.header.frame_id,
                                 Eigen::Quaterniond(q.w, q.x, q.y, q.z),
                                 {orientation.absolute_x_axis_tolerance, orientation.absolute_y_axis_tolerance,
                                  orientation.absolute_z_axis_tolerance},
                                 orientation.parameterization == 1});
  }
  return goal;
}

void set_row(moveit::core::RobotState& state, const srmp::Trajectory& trajectory, Eigen::Index row) {
  for (std::size_t i = 0; i < trajectory.joint_names.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const std::string& name = trajectory.joint_names[i];
    state.setVariablePosition(name, trajectory.positions(row, column));
    if (trajectory.velocities.rows() > 0) state.setVariableVelocity(name, trajectory.velocities(row, column));
    if (trajectory.accelerations.rows() > 0) state.setVariableAcceleration(name, trajectory.accelerations(row, column));
  }
  state.update();
}

}  // namespace

srmp::MoveItRobot robot_of(const moveit::core::RobotModel& model, const std::string& urdf_text,
                           const std::string& srdf_text) {
  srmp::MoveItRobot robot{urdf_text, srdf_text, {}, {}};
  for (const moveit::core::JointModel* joint : model.getJointModels()) {
    if (joint->getVariableCount() != 1 || joint->getMimic()) continue;
    const moveit::core::VariableBounds& limits = joint->getVariableBounds()[0];
    srmp::MoveItJointBounds& bounds = robot.bounds[joint->getName()];
    if (limits.position_bounded_) {
      bounds.lower = limits.min_position_;
      bounds.upper = limits.max_position_;
    }
    if (limits.velocity_bounded_ && limits.max_velocity_ > 0.0) bounds.velocity = limits.max_velocity_;
    if (limits.acceleration_bounded_ && limits.max_acceleration_ > 0.0) bounds.acceleration = limits.max_acceleration_;
#if SRMP_ROS_VERSION == 2
    if (limits.jerk_bounded_ && limits.max_jerk_ > 0.0) bounds.jerk = limits.max_jerk_;
#endif
  }
  return robot;
}

srmp::io::SceneFile scene_of(const Library& library, const planning_scene::PlanningScene& scene) {
  using Components = moveit_messages::PlanningSceneComponents;
  Components parts;
  parts.components = Components::ROBOT_STATE | Components::ROBOT_STATE_ATTACHED_OBJECTS |
                     Components::WORLD_OBJECT_NAMES | Components::WORLD_OBJECT_GEOMETRY | Components::TRANSFORMS |
                     Components::ALLOWED_COLLISION_MATRIX | Components::LINK_PADDING_AND_SCALING;
  moveit_messages::PlanningScene message;
  scene.getPlanningSceneMsg(message, parts);
  srmp::io::SceneFile result;
  result.name = scene.getName();
  for (const auto& object : message.world.collision_objects) result.objects.push_back(object_of(library, object));
  add_octomap(scene, result);
  // A frame that the scene knows from outside (tf) is given in the planning frame.
  for (const auto& frame : message.fixed_frame_transforms)
    result.fixed_frames.push_back({frame.header.frame_id, frame.child_frame_id, pose_of(frame.transform)});
  result.allowed_collisions = matrix_of(message.allowed_collision_matrix);
  for (const auto& padding : message.link_padding) result.link_padding[padding.link_name] = padding.padding;
  for (const auto& scale : message.link_scale) result.link_scale[scale.link_name] = scale.scale;
  result.robot_state = state_of(library, message.robot_state);
  return result;
}

/// Joints are where MoveIt puts them; what the message attaches, the session attaches, which refuses what it cannot.
srmp::io::RobotState start_of(const Library& library, const moveit_messages::RobotState& message,
                              const planning_scene::PlanningScene& scene) {
  require_understood(message, scene);
  moveit_messages::RobotState whole;
  const bool with_attached_bodies = false;
  moveit::core::robotStateToRobotStateMsg(*scene.getCurrentStateUpdated(message), whole, with_attached_bodies);
  srmp::io::RobotState start = state_of(library, whole);
  start.attached = attached_of(library, message);
  start.speed = speed_of(message);
  const bool names_joints = !message.joint_state.name.empty() || !message.multi_dof_joint_state.joint_names.empty();
  start.is_diff = message.is_diff || !names_joints;
  return start;
}

// Releases of moveit_msgs have one or the other name.
template <class Message>
auto speed_limited_link(const Message& message, int) -> decltype(message.cartesian_speed_limited_link) {
  return message.cartesian_speed_limited_link;
}
template <class Message>
auto speed_limited_link(const Message& message, long) -> decltype(message.cartesian_speed_end_effector_link) {
  return message.cartesian_speed_end_effector_link;
}

srmp::io::RequestFile request_of(const Library& library, const moveit_messages::MotionPlanRequest& message,
                                 const planning_scene::PlanningScene& scene) {
  srmp::io::RequestFile request;
  request.group_name = message.group_name;
  request.planner_id = message.planner_id;
  request.attempts = message.num_planning_attempts;
  if (message.allowed_planning_time != 0.0) request.allowed_planning_time = message.allowed_planning_time;
  request.velocity_scaling = message.max_velocity_scaling_factor;
  request.acceleration_scaling = message.max_acceleration_scaling_factor;
  request.start_state = start_of(library, message.start_state, scene);
  const auto& box = message.workspace_parameters;
  request.workspace = {box.header.frame_id, vector_of(box.min_corner), vector_of(box.max_corner)};
  for (const auto& goal : message.goal_constraints)
    request.goals.push_back(constraints_of(library, goal, Code::invalid_goal_constraints));
  request.path_constraints = constraints_of(library, message.path_constraints, Code::planning_failed);
  request.trajectory_constraints = message.trajectory_constraints.constraints.size();
  request.reference_trajectories = message.reference_trajectories.size();
  request.max_cartesian_speed = message.max_cartesian_speed;
  request.cartesian_speed_limited_link = speed_limited_link(message, 0);
  return request;
}

robot_trajectory::RobotTrajectoryPtr trajectory_of(const srmp::Trajectory& trajectory,
                                                   const moveit::core::RobotState& start, const std::string& group) {
  auto result = std::make_shared<robot_trajectory::RobotTrajectory>(start.getRobotModel(), group);
  moveit::core::RobotState state(start);
  if (trajectory.velocities.rows() == 0) state.dropVelocities();  // those of the start
  for (Eigen::Index row = 0; row < trajectory.positions.rows(); ++row) {
    set_row(state, trajectory, row);
    const double step = row == 0 || !trajectory.timed() ? 0.0 : trajectory.times[row] - trajectory.times[row - 1];
    result->addSuffixWayPoint(state, step);
  }
  return result;
}

robot_trajectory::RobotTrajectoryPtr path_of(const srmp::Trajectory& trajectory, const moveit::core::RobotState& start,
                                             const std::string& group) {
  srmp::Trajectory path;
  path.joint_names = trajectory.joint_names;
  path.positions = trajectory.waypoints;
  return trajectory_of(path, start, group);
}

}  // namespace srmp_moveit
