#include "scenes.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "library.hpp"
#include "pipeline.hpp"

using namespace srmp_moveit;

namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

const srmp_moveit::Library& library() {
  static const auto opened = srmp_moveit::open_library();
  return *opened;
}

Eigen::Isometry3d isometry_of(const srmp::Pose& pose) { return Eigen::Translation3d(pose.p) * pose.q; }

geometry_messages::Pose message_of(const srmp::Pose& pose) { return tf2::toMsg(isometry_of(pose)); }

shape_messages::SolidPrimitive primitive_of(const srmp::Shape& shape) {
  shape_messages::SolidPrimitive message;
  if (const auto* box = std::get_if<srmp::Box>(&shape)) {
    message.type = message.BOX;
    message.dimensions.assign(box->size.data(), box->size.data() + 3);
  } else if (const auto* sphere = std::get_if<srmp::Sphere>(&shape)) {
    message.type = message.SPHERE;
    message.dimensions = {sphere->radius};
  } else if (const auto* cylinder = std::get_if<srmp::Cylinder>(&shape)) {
    message.type = message.CYLINDER;
    message.dimensions = {cylinder->length, cylinder->radius};
  } else {
    throw std::runtime_error("a shape that these problems do not have");
  }
  return message;
}

/// Sets the parameters, and loads the robot as MoveIt does, with the kinematics solvers of its parameters.
moveit::core::RobotModelPtr load(const std::string& urdf, const std::string& srdf) {
  set_parameter("robot_description", urdf);
  set_parameter("robot_description_semantic", srdf);
  const std::shared_ptr<robot_model_loader::RobotModelLoader> loader = load_model("robot_description");
  return {loader, loader->getModel().get()};  // which owns the solvers, and lives as long as the model
}

}  // namespace

moveit::core::RobotModelPtr load_panda(const std::string& directory) {
  std::string urdf = text_of(directory + "/panda.urdf");
  const std::string srdf = text_of(directory + "/panda.srdf"), package = "package://meshes/";
  for (auto at = urdf.find(package); at != std::string::npos; at = urdf.find(package))
    urdf.replace(at, package.size(), "file://" + directory + "/meshes/");
  return load(urdf, srdf);
}

moveit::core::RobotModelPtr load_two_arms() {
  std::string urdf = "<robot name='pair'><link name='base'/>", srdf = "<robot name='pair'>", apart;
  const std::string limit = "<limit lower='-3' upper='3' velocity='2' effort='1'/>";
  const char* const links[] = {"base", "upper", "middle", "lower"};
  for (const std::string side : {"left_", "right_"}) {
    for (int i = 1; i < 4; ++i) {
      const std::string parent = i == 1 ? "base" : side + links[i - 1], child = side + links[i];
      const std::string at = i > 1 ? "0.5 0 0" : side == "left_" ? "0 0.5 0" : "0 -0.5 0";
      urdf += "<link name='" + child +
              "'><collision><origin xyz='0.25 0 0'/><geometry><box size='0.4 0.08 0.08'/>"
              "</geometry></collision></link><joint name='" +
              side + "joint" + std::to_string(i) + "' type='revolute'><parent link='" + parent + "'/><child link='" +
              child + "'/><origin xyz='" + at + "'/><axis xyz='0 0 1'/>" + limit + "</joint>";
      if (i > 1) apart += "<disable_collisions link1='" + parent + "' link2='" + child + "' reason='Adjacent'/>";
    }
    srdf += "<group name='" + side.substr(0, side.size() - 1) + "'><chain base_link='base' tip_link='" + side +
            "lower'/></group>";
  }
  srdf += "<group name='both'><group name='left'/><group name='right'/></group>";
  return load(urdf + "</robot>", srdf + apart + "</robot>");
}

planning_scene::PlanningScenePtr read_scene(const std::string& path, const moveit::core::RobotModelPtr& model) {
  const srmp::io::SceneFile file = library().read_scene(path);
  auto scene = std::make_shared<planning_scene::PlanningScene>(model);
  Eigen::Isometry3d camera(Eigen::Translation3d(0.3, -0.2, 1.1) *
                           Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()));
  scene->getTransformsNonConst().setTransform(camera, "camera");
  for (const srmp::io::CollisionObject& object : file.objects) {
    moveit_messages::CollisionObject message;
    message.header.frame_id = "camera";
    message.id = object.id;
    message.operation = message.ADD;
    message.pose = tf2::toMsg(Eigen::Isometry3d(camera.inverse() * isometry_of(object.pose)));
    for (const srmp::io::PlacedShape& shape : object.shapes) {
      message.primitives.push_back(primitive_of(shape.shape));
      message.primitive_poses.push_back(message_of(shape.pose));
    }
    if (!scene->processCollisionObjectMsg(message)) throw std::runtime_error("MoveIt refuses object " + object.id);
  }
  return scene;
}

moveit_messages::MotionPlanRequest read_request(const std::string& path) {
  const srmp::io::RequestFile file = library().read_request(path);
  moveit_messages::MotionPlanRequest request;
  request.group_name = file.group_name;
  request.num_planning_attempts = 1;
  request.allowed_planning_time = 5.0;
  request.max_velocity_scaling_factor = request.max_acceleration_scaling_factor = 1.0;
  request.start_state.is_diff = true;
  for (const auto& [joint, position] : file.start_state.joints) {
    if (joint.find("finger") != std::string::npos) continue;  // fixed in this Panda
    request.start_state.joint_state.name.push_back(joint);
    request.start_state.joint_state.position.push_back(position);
  }
  request.goal_constraints.resize(1);
  for (const srmp::io::JointConstraint& joint : file.goals.at(0).joints) {
    moveit_messages::JointConstraint constraint;
    constraint.joint_name = joint.joint;
    constraint.position = joint.position;
    constraint.tolerance_above = constraint.tolerance_below = 1e-4;
    constraint.weight = 1.0;
    request.goal_constraints[0].joint_constraints.push_back(constraint);
  }
  return request;
}

moveit_messages::MotionPlanRequest with_pose_goal(moveit_messages::MotionPlanRequest request,
                                                  const planning_scene::PlanningScene& scene) {
  const std::string link = "panda_link8", frame = scene.getWorld()->getObjectIds().at(0);
  moveit::core::RobotState state = *scene.getCurrentStateUpdated(request.start_state);
  for (const auto& joint : request.goal_constraints.at(0).joint_constraints)
    state.setVariablePosition(joint.joint_name, joint.position);
  state.update();
  const Eigen::Isometry3d pose = scene.getFrameTransform(frame).inverse() * state.getGlobalLinkTransform(link);
  moveit_messages::Constraints goal;
  moveit_messages::PositionConstraint position;
  position.header.frame_id = frame;
  position.link_name = link;
  position.constraint_region.primitives.push_back(primitive_of(srmp::Sphere{1e-3}));
  position.constraint_region.primitive_poses.resize(1);
  position.constraint_region.primitive_poses[0] = tf2::toMsg(pose);
  position.constraint_region.primitive_poses[0].orientation = geometry_messages::Quaternion();
  position.constraint_region.primitive_poses[0].orientation.w = 1.0;
  position.weight = 1.0;
  moveit_messages::OrientationConstraint orientation;
  orientation.header.frame_id = frame;
  orientation.link_name = link;
  orientation.orientation = tf2::toMsg(pose).orientation;
  orientation.absolute_x_axis_tolerance = orientation.absolute_y_axis_tolerance =
      orientation.absolute_z_axis_tolerance = 1e-2;
  orientation.weight = 1.0;
  goal.position_constraints = {position};
  goal.orientation_constraints = {orientation};
  request.goal_constraints = {goal};
  return request;
}

void add_box(planning_scene::PlanningScene& scene, const std::string& id, const Eigen::Vector3d& position,
             const Eigen::Vector3d& size) {
  moveit_messages::CollisionObject message;
  message.header.frame_id = scene.getPlanningFrame();
  message.id = id;
  message.operation = message.ADD;
  message.pose.orientation.w = 1.0;
  message.pose.position = tf2::toMsg(position);
  message.primitives = {primitive_of(srmp::Box{size})};
  message.primitive_poses.resize(1);
  message.primitive_poses[0].orientation.w = 1.0;
  scene.processCollisionObjectMsg(message);
}
