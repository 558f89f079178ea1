#include <boost/test/unit_test.hpp>

#include "moveit_case.hpp"
#include "srmp/robot/robot_model.hpp"
#include "support/data.hpp"

using namespace moveit_case;

namespace {

const std::vector<Row>& requests() {
  static const std::vector<Row> rows{
      {"nothing", [](Case&) {}, Code::success},
      {"group_name", [](Case& c) { c.request.group_name = "arms"; }, Code::invalid_group_name, "did you mean 'arm'"},
      {"planner_id", [](Case& c) { c.request.planner_id = "wPASE"; }, Code::success},
      {"planner_id, unknown", [](Case& c) { c.request.planner_id = "wPASEE"; }, Code::planning_failed, "wPASE"},
      {"planner_id, for several arms", [](Case& c) { c.request.planner_id = "xECBS"; }, Code::planning_failed,
       "several robots"},
      {"pipeline_id", [](Case& c) { c.request.pipeline_id = "ompl"; }, Code::success},
      {"num_planning_attempts", [](Case& c) { c.request.attempts = 10; }, Code::success},
      {"num_planning_attempts < 0", [](Case& c) { c.request.attempts = -1; }, Code::planning_failed, "attempts"},
      {"allowed_planning_time", [](Case& c) { c.request.allowed_planning_time = 1e-9; }, Code::timed_out},
      {"allowed_planning_time = 0", [](Case& c) { c.request.allowed_planning_time = 0.0; }, Code::success},
      {"allowed_planning_time < 0", [](Case& c) { c.request.allowed_planning_time = -1.0; }, Code::planning_failed,
       "allowed_planning_time"},
      {"max_velocity_scaling_factor", [](Case& c) { c.request.velocity_scaling = 0.1; }, Code::success},
      {"max_velocity_scaling_factor > 1", [](Case& c) { c.request.velocity_scaling = 1.1; }, Code::planning_failed,
       "max_velocity_scaling_factor"},
      {"max_acceleration_scaling_factor", [](Case& c) { c.request.acceleration_scaling = 0.0; }, Code::success},
      {"max_acceleration_scaling_factor < 0", [](Case& c) { c.request.acceleration_scaling = -0.1; },
       Code::planning_failed, "max_acceleration_scaling_factor"},
      {"max_cartesian_speed", [](Case& c) { c.request.max_cartesian_speed = 0.1; }, Code::success},
      {"max_cartesian_speed, NaN", [](Case& c) { c.request.max_cartesian_speed = not_finite; }, Code::planning_failed,
       "max_cartesian_speed"},
      {"cartesian_speed_limited_link",
       [](Case& c) {
         c.request.max_cartesian_speed = 0.1;
         c.request.cartesian_speed_limited_link = "arm7_forearm";
       },
       Code::success},
      {"cartesian_speed_limited_link, unknown",
       [](Case& c) {
         c.request.max_cartesian_speed = 0.1;
         c.request.cartesian_speed_limited_link = "moon";
       },
       Code::invalid_link_name, "moon"},
      {"workspace_parameters",
       [](Case& c) { c.request.workspace = {"", Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)}; },
       Code::success},
      {"workspace_parameters.header",
       [](Case& c) { c.request.workspace = {"moon", Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)}; },
       Code::frame_transform_failure, "moon"},
      {"workspace_parameters.min_corner",
       [](Case& c) { c.request.workspace = {"", Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(-1, -1, -1)}; },
       Code::planning_failed, "min_corner"},
      {"trajectory_constraints", [](Case& c) { c.request.trajectory_constraints = 1; }, Code::planning_failed,
       "trajectory_constraints"},
      {"reference_trajectories", [](Case& c) { c.request.reference_trajectories = 1; }, Code::planning_failed,
       "reference_trajectories"},

      {"start_state.joint_state", [](Case& c) { c.request.start_state.joints["arm7_joint1"] = 0.4; }, Code::success},
      {"start_state.joint_state, NaN", [](Case& c) { c.request.start_state.joints["arm7_joint1"] = not_finite; },
       Code::invalid_robot_state, "arm7_joint1"},
      {"start_state.joint_state, outside of limits", [](Case& c) { c.request.start_state.joints["arm7_joint1"] = 3.5; },
       Code::start_state_invalid, "arm7_joint1"},
      {"start_state.joint_state, incomplete", [](Case& c) { c.scene.robot_state.joints.erase("arm7_joint3"); },
       Code::start_state_invalid, "arm7_joint3"},
      {"start_state.joint_state.velocity", [](Case& c) { c.request.start_state.velocities["arm7_joint1"] = 0.5; },
       Code::success},
      {"start_state.joint_state.velocity, above its limit",
       [](Case& c) { c.request.start_state.velocities["arm7_joint1"] = 50; }, Code::start_state_invalid, "limit"},
      {"start_state.joint_state.velocity, NaN",
       [](Case& c) { c.request.start_state.velocities["arm7_joint1"] = not_finite; }, Code::invalid_robot_state,
       "arm7_joint1"},
      {"start_state.joint_state.velocity, of no joint", [](Case& c) { c.request.start_state.velocities["wheel"] = 5; },
       Code::success},
      {"start_state.multi_dof_joint_state.twist", [](Case& c) { c.request.start_state.speed = 0.5; },
       Code::start_state_invalid, "twist"},
      {"start_state.is_diff",
       [](Case& c) {
         c.attach_to_scene("block", {0.4, 0.4, 0.4});
         c.request.start_state.is_diff = true;
         c.request.start_state.joints = ready;
       },
       Code::start_state_in_collision, "block"},
      {"start_state.is_diff, a whole state",
       [](Case& c) {
         c.attach_to_scene("block", {0.4, 0.4, 0.4});
         c.request.start_state.joints = ready;
       },
       Code::success},
      {"start state in collision", [](Case& c) { c.add_box("box", {0.3, 0, 0.6}, {0.3, 0.3, 0.3}); },
       Code::start_state_in_collision, "box"},
      {"start_state.multi_dof_joint_state",
       [](Case& c) { c.request.start_state.multi_dof_joints["virtual"] = Pose{{1, 0, 0}}; },
       Code::collision_checking_unavailable, "virtual"},
      {"start_state.attached_collision_objects", [](Case& c) { c.attach("rod", "arm7_hand"); }, Code::success},
      {"start_state.attached_collision_objects.link_name", [](Case& c) { c.attach("rod", "arm7_hnad"); },
       Code::invalid_link_name, "arm7_hnad"},
      {"start_state.attached_collision_objects.object, unknown",
       [](Case& c) { c.attach("rod", "arm7_hand").object.shapes.clear(); }, Code::invalid_object_name, "rod"},
      {"start_state.attached_collision_objects.object.operation",
       [](Case& c) { c.attach("rod", "arm7_hand").object.operation = io::ObjectOperation::remove; },
       Code::invalid_object_name, "rod"},
      {"start_state.attached_collision_objects.object.operation, append",
       [](Case& c) { c.attach("rod", "arm7_hand").object.operation = io::ObjectOperation::append; },
       Code::invalid_object_name, "attach it anew"},

      {"start_state.attached_collision_objects.touch_links",
       [](Case& c) {
         c.attach("rod", "arm7_hand").object.pose.p = {0, 0, -0.03};
         c.request.start_state.attached.back().touch_links.clear();
       },
       Code::start_state_in_collision, "rod"},
      {"start_state.attached_collision_objects.object.meshes",
       [](Case& c) { c.attach("rod", "arm7_hand").object.shapes = {{tetrahedron(0.02), Pose{{0, 0, 0.1}}}}; },
       Code::success},

      {"goal_constraints", [](Case& c) { c.request.goals.clear(); }, Code::invalid_goal_constraints, "goal"},
      {"goal_constraints, several",
       [](Case& c) {
         c.request.goals.push_back(c.request.goals[0]);
         c.joint(0).position = 1.0;
       },
       Code::success},
      {"goal without constraints", [](Case& c) { c.request.goals[0].joints.clear(); }, Code::invalid_goal_constraints,
       "no constraints"},
      {"joint_constraints.joint_name", [](Case& c) { c.joint(0).joint = "arm7_joint8"; },
       Code::invalid_goal_constraints, "arm7_joint8"},
      {"joint_constraints.joint_name, twice", [](Case& c) { c.joint(1).joint = "arm7_joint1"; },
       Code::invalid_goal_constraints, "twice"},
      {"joint_constraints, incomplete", [](Case& c) { c.request.goals[0].joints.pop_back(); },
       Code::invalid_goal_constraints, "arm7_joint7"},
      {"joint_constraints.position, NaN", [](Case& c) { c.joint(0).position = not_finite; },
       Code::invalid_goal_constraints, "finite"},
      {"joint_constraints.position, outside of limits", [](Case& c) { c.joint(0).position = 3.5; },
       Code::goal_state_invalid, "arm7_joint1"},
      {"joint_constraints.tolerance_above", [](Case& c) { c.joint(0).tolerance_above = -1; },
       Code::invalid_goal_constraints, "tolerance_above"},
      {"joint_constraints.tolerance_below", [](Case& c) { c.joint(0).tolerance_below = -1; },
       Code::invalid_goal_constraints, "tolerance_below"},
      {"goal in collision", [](Case& c) { c.add_box("box", {0.28, 0.28, 0.55}, {0.1, 0.1, 0.1}); },
       Code::goal_in_collision, "box"},
      {"visibility_constraints", [](Case& c) { c.request.goals[0].visibilities = 1; }, Code::invalid_goal_constraints,
       "visibility"},
      {"position_constraints", [](Case& c) { c.ask_for_pose(); }, Code::success},
      {"position_constraints.header",
       [](Case& c) {
         c.ask_for_pose();
         c.position().frame = "moon";
       },
       Code::frame_transform_failure, "moon"},
      {"position_constraints.header, of an object",
       [](Case& c) {
         c.ask_for_pose();
         c.add_box("table", {0, 0, -0.2}, {2, 2, 0.1});
         c.position().frame = "table";
         c.position().regions[0].pose.p.z() += 0.2;
       },
       Code::success},
      {"position_constraints.header, of the scene",
       [](Case& c) {
         c.ask_for_pose();
         c.scene.fixed_frames = {{"world", "camera", Pose{{0, 0, 1}}}};
         c.position().frame = "camera";
         c.position().regions[0].pose.p.z() -= 1.0;
       },
       Code::success},
      {"position_constraints.link_name",
       [](Case& c) {
         c.ask_for_pose();
         c.position().link = "arm7_hnad";
       },
       Code::invalid_link_name, "arm7_hnad"},
      {"position_constraints.link_name, not moved",
       [](Case& c) {
         c.ask_for_pose();
         c.position().link = "arm7_base";
       },
       Code::invalid_goal_constraints, "arm7_base"},
      {"position_constraints.link_name, in the middle",
       [](Case& c) {
         c.ask_for_pose();
         c.position().link = "arm7_elbow";
         c.position().regions = {{Sphere{0.02}, Pose{{0.1, 0.1, 0.46}}}};
       },
       Code::success},
      {"position_constraints.target_point_offset",
       [](Case& c) {
         c.ask_for_pose();
         c.position().offset = {0.1, 0, 0};
       },
       Code::invalid_goal_constraints, "orientation constraint"},
      {"position_constraints.constraint_region",
       [](Case& c) {
         c.ask_for_pose();
         c.position().regions.clear();
       },
       Code::invalid_goal_constraints, "no primitives"},
      {"position_constraints.constraint_region.primitives, a cone",
       [](Case& c) {
         c.ask_for_pose();
         c.position().regions[0].shape = Cone{0.1, 0.1};
       },
       Code::invalid_goal_constraints, "cone"},
      {"position_constraints.constraint_region.meshes",
       [](Case& c) {
         c.ask_for_pose();
         c.position().mesh_regions = 1;
       },
       Code::invalid_goal_constraints, "meshes"},
      {"position_constraints, out of reach",
       [](Case& c) {
         c.ask_for_pose();
         c.position().regions[0].pose.p = {5, 0, 0};
       },
       Code::no_ik_solution, "arm7_hand"},
      {"position_constraints, several",
       [](Case& c) {
         c.ask_for_pose();
         c.request.goals[0].positions.push_back(c.position());
       },
       Code::invalid_goal_constraints, "several"},
      {"position_constraints in collision",
       [](Case& c) {
         c.ask_for_pose();
         c.add_box("box", {0.28, 0.28, 0.5}, {0.1, 0.1, 0.1});
       },
       Code::goal_in_collision, "box"},
      {"orientation_constraints", [](Case& c) { c.ask_for_orientation(1.0); }, Code::success},
      {"orientation_constraints.orientation", [](Case& c) { c.ask_for_orientation(0.5); },
       Code::invalid_goal_constraints, "length"},
      {"orientation_constraints.absolute_x_axis_tolerance",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].tolerance.x() = -1;
       },
       Code::invalid_goal_constraints, "absolute_x_axis_tolerance"},
      {"orientation_constraints.absolute_y_axis_tolerance",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].tolerance.y() = -1;
       },
       Code::invalid_goal_constraints, "absolute_y_axis_tolerance"},
      {"orientation_constraints.absolute_z_axis_tolerance",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].tolerance.z() = not_finite;
       },
       Code::invalid_goal_constraints, "absolute_z_axis_tolerance"},
      {"orientation_constraints.header",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].frame = "moon";
       },
       Code::frame_transform_failure, "moon"},
      {"orientation_constraints.link_name",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].link = "arm7_hnad";
       },
       Code::invalid_link_name, "arm7_hnad"},
      {"orientation_constraints.parameterization",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].rotation_vector = true;
       },
       Code::success},
      {"orientation_constraints that leave all free",
       [](Case& c) {
         c.ask_for_orientation(1.0);
         c.request.goals[0].orientations[0].tolerance.setConstant(7.0);
       },
       Code::invalid_goal_constraints, "free"},
      {"joint_constraints and position_constraints",
       [](Case& c) {
         const auto joints = c.request.goals[0].joints;
         c.ask_for_pose();
         c.request.goals[0].joints = joints;
       },
       Code::invalid_goal_constraints, "together"}};
  return rows;
}

/// The hand points down at the start and the goal of a Case, and moves around the base.
const std::vector<Row>& path_constraints() {
  static const std::vector<Row> rows{
      {"path_constraints.orientation_constraints", [](Case& c) { c.keep_orientation({0.1, 0.1, 7.0}); }, Code::success},
      {"path_constraints.orientation_constraints, all axes",
       [](Case& c) {
         c.joint(0).position = 0.4;
         c.keep_orientation({0.2, 0.2, 1.2});
       },
       Code::success},
      {"path_constraints.orientation_constraints, a rotation vector",
       [](Case& c) { c.keep_orientation({0.2, 0.2, 1.2}).rotation_vector = true; }, Code::success},
      {"path_constraints.orientation_constraints, nothing", [](Case& c) { c.keep_orientation({7, 7, 7}); },
       Code::success},
      {"path_constraints.orientation_constraints.absolute_x_axis_tolerance",
       [](Case& c) { c.keep_orientation({-1, 0.1, 7.0}); }, Code::planning_failed, "absolute_x_axis_tolerance"},
      {"path_constraints.orientation_constraints.orientation",
       [](Case& c) { c.keep_orientation({0.1, 0.1, 7.0}).orientation.coeffs() *= 0.5; }, Code::planning_failed,
       "length"},
      {"path_constraints.orientation_constraints.header",
       [](Case& c) { c.keep_orientation({0.1, 0.1, 7.0}).frame = "moon"; }, Code::frame_transform_failure, "moon"},
      {"path_constraints.orientation_constraints.link_name",
       [](Case& c) { c.keep_orientation({0.1, 0.1, 7.0}).link = "arm7_hnad"; }, Code::invalid_link_name, "arm7_hnad"},
      {"path_constraints, of a link that does not move",
       [](Case& c) { c.keep_orientation({0.1, 0.1, 7.0}).link = "arm7_base"; }, Code::planning_failed,
       "no planned joint"},
      {"path_constraints, broken at the start",
       [](Case& c) {
         c.request.start_state.joints["arm7_joint6"] = 1.2;
         c.keep_orientation({0.1, 0.1, 7.0});
       },
       Code::start_violates_path_constraints, "arm7_hand"},
      {"path_constraints, broken at the goal",
       [](Case& c) {
         c.joint(5).position = 1.2;
         c.keep_orientation({0.1, 0.1, 7.0});
       },
       Code::goal_violates_path_constraints, "arm7_hand"},
      {"path_constraints, broken at the goal's pose",
       [](Case& c) {
         c.ask_for_pose();
         c.keep_position(Box{{0.2, 0.2, 0.2}});
         c.request.path_constraints.positions[0].regions[0].pose.p = c.at_start;
       },
       Code::goal_violates_path_constraints, "arm7_hand"},
      {"path_constraints.position_constraints, a box", [](Case& c) { c.keep_position(Box{{2, 2, 0.3}}); },
       Code::success},
      {"path_constraints.position_constraints, a sphere", [](Case& c) { c.keep_position(Sphere{0.6}); }, Code::success},
      {"path_constraints.position_constraints, a cylinder", [](Case& c) { c.keep_position(Cylinder{0.6, 1.0}); },
       Code::planning_failed, "cylinder"},
      {"path_constraints.position_constraints, a mesh", [](Case& c) { c.keep_position(Sphere{0.6}).mesh_regions = 1; },
       Code::planning_failed, "meshes"},
      {"path_constraints.position_constraints, several regions",
       [](Case& c) {
         auto& regions = c.keep_position(Sphere{0.6}).regions;
         regions.push_back(regions[0]);
       },
       Code::planning_failed, "several primitives"},
      {"path_constraints.position_constraints.target_point_offset",
       [](Case& c) { c.keep_position(Sphere{0.6}).offset = {0.1, 0, 0}; }, Code::success},
      {"path_constraints.position_constraints.header, of a link that moves",
       [](Case& c) {
         c.keep_position(Sphere{0.8}).frame = "arm7_elbow";
         c.request.path_constraints.positions[0].regions[0].pose = {};
       },
       Code::success},
      {"path_constraints.position_constraints.header", [](Case& c) { c.keep_position(Sphere{0.6}).frame = "moon"; },
       Code::frame_transform_failure, "moon"},
      {"path_constraints.joint_constraints",
       [](Case& c) { c.request.path_constraints.joints = {{"arm7_joint1", 0, 1, 1}}; }, Code::planning_failed,
       "joint_constraints"},
      {"path_constraints.visibility_constraints", [](Case& c) { c.request.path_constraints.visibilities = 1; },
       Code::planning_failed, "visibility_constraints"},
  };
  return rows;
}

const std::vector<Row>& scenes() {
  static const std::vector<Row> rows{
      {"is_diff", [](Case& c) { c.scene.is_diff = true; }, Code::invalid_object_name, "difference"},
      {"robot_model_name", [](Case& c) { c.scene.robot_model_name = "another"; }, Code::success},
      {"robot_state.joint_state, of no joint", [](Case& c) { c.scene.robot_state.joints["wheel"] = 1; }, Code::success},
      {"robot_state.multi_dof_joint_state.header",
       [](Case& c) {
         c.scene.robot_state.multi_dof_joints["virtual"] = {};
         c.scene.robot_state.multi_dof_frame = "moon";
       },
       Code::frame_transform_failure, "moon"},
      {"fixed_frame_transforms", [](Case& c) { c.scene.fixed_frames = {{"moon", "mars", {}}}; },
       Code::invalid_object_name, "moon"},
      {"allowed_collision_matrix",
       [](Case& c) {
         c.add_box("box", {0.3, 0, 0.6}, {0.3, 0.3, 0.3});
         c.scene.allowed_collisions.defaults["box"] = true;
       },
       Code::success},
      {"allowed_collision_matrix.default_entry_values, false",
       [](Case& c) {
         c.add_box("box", {0.3, 0, 0.6}, {0.3, 0.3, 0.3});
         c.scene.allowed_collisions.defaults["box"] = true;
         const auto robot = RobotModel::load(arm7());
         for (const auto& geometry : robot->geometries()) c.scene.allowed_collisions.defaults[geometry.link] = false;
       },
       Code::start_state_in_collision, "box"},
      {"allowed_collision_matrix.default_entry_names, of nothing",
       [](Case& c) { c.scene.allowed_collisions.defaults["nothing"] = true; }, Code::success},
      {"allowed_collision_matrix.entry_values, a short row",
       [](Case& c) {
         c.scene.allowed_collisions.names = {"arm7_hand", "arm7_base"};
         c.scene.allowed_collisions.entries = {{false, true}, {true}};
       },
       Code::invalid_object_name, "square"},
      {"allowed_collision_matrix.entry_values",
       [](Case& c) { c.scene.allowed_collisions.names = {"arm7_hand", "arm7_base"}; }, Code::invalid_object_name,
       "square"},
      {"link_padding, of one link", [](Case& c) { c.scene.link_padding = {{"arm7_hand", 0.01}}; },
       Code::collision_checking_unavailable, "padding"},
      {"link_padding < 0", [](Case& c) { c.scene.link_padding = {{"arm7_hand", -0.01}}; }, Code::invalid_object_name,
       "padding"},
      {"link_padding.link_name", [](Case& c) { c.scene.link_padding = {{"arm7_hnad", 0.01}}; }, Code::invalid_link_name,
       "arm7_hnad"},
      {"link_scale", [](Case& c) { c.scene.link_scale = {{"arm7_hand", 1.1}}; }, Code::collision_checking_unavailable,
       "scale"},
      {"link_scale = 1", [](Case& c) { c.scene.link_scale = {{"arm7_hand", 1.0}}; }, Code::success},
      {"world.collision_objects", [](Case& c) { c.add_box("box", {1, 0, 0.6}, {0.1, 0.1, 0.1}); }, Code::success},
      {"world.collision_objects.id, twice",
       [](Case& c) {
         c.add_box("box", {1, 0, 0.6}, {0.1, 0.1, 0.1});
         c.add_box("box", {2, 0, 0.6}, {0.1, 0.1, 0.1});
       },
       Code::invalid_object_name, "unique"},
      {"world.collision_objects.id, empty", [](Case& c) { c.add_box("", {1, 0, 0.6}, {0.1, 0.1, 0.1}); },
       Code::invalid_object_name, "empty"},
      {"world.collision_objects.header", [](Case& c) { c.add_box("box", {1, 0, 0.6}, {0.1, 0.1, 0.1}).frame = "moon"; },
       Code::frame_transform_failure, "moon"},
      {"world.collision_objects.pose, NaN", [](Case& c) { c.add_box("box", {not_finite, 0, 0.6}, {0.1, 0.1, 0.1}); },
       Code::invalid_object_name, "finite"},
      {"world.collision_objects.primitives, none",
       [](Case& c) { c.add_box("box", {1, 0, 0.6}, {0.1, 0.1, 0.1}).shapes.clear(); }, Code::invalid_object_name,
       "no shape"},
      {"world.collision_objects.primitives, size", [](Case& c) { c.add_box("box", {1, 0, 0.6}, {0.1, 0, 0.1}); },
       Code::invalid_object_name, "box"},
      {"world.collision_objects.planes", [](Case& c) { c.add_box("box", {1, 0, 0.6}, {0.1, 0.1, 0.1}).planes = 1; },
       Code::collision_checking_unavailable, "planes"},
      {"world.collision_objects.meshes",
       [](Case& c) { c.add_box("mesh", {0.28, 0.28, 0.55}, {0.1, 0.1, 0.1}).shapes = {{tetrahedron(0.2), {}}}; },
       Code::goal_in_collision, "mesh"},
      {"world.collision_objects.mesh_poses",
       [](Case& c) {
         c.add_box("mesh", {0.28, 0.28, 0.55}, {0.1, 0.1, 0.1}).shapes = {{tetrahedron(0.2), Pose{{2, 0, 0}}}};
       },
       Code::success},
      {"world.collision_objects.mesh_poses, NaN",
       [](Case& c) {
         c.add_box("mesh", {0.28, 0.28, 0.55}, {0.1, 0.1, 0.1}).shapes = {{tetrahedron(0.2), Pose{{not_finite, 0, 0}}}};
       },
       Code::invalid_object_name, "finite"},
      {"world.collision_objects.meshes, an index that is none",
       [](Case& c) {
         Mesh mesh = tetrahedron(0.2);
         mesh.triangles[0][0] = 9;
         c.add_box("mesh", {2, 0, 0}, {0.1, 0.1, 0.1}).shapes = {{mesh, {}}};
       },
       Code::invalid_object_name, "mesh"},
      {"world.collision_objects.subframe_names",
       [](Case& c) {
         c.ask_for_pose();
         c.add_box("table", {0, 0, -0.2}, {2, 2, 0.1}).subframes["corner"] = Pose{{0.1, 0, 0.2}};
         c.position().frame = "table/corner";
         c.position().regions[0].pose.p.x() -= 0.1;
       },
       Code::success},
      {"world.octomap",
       [](Case& c) {
         io::CollisionObject cells;
         cells.id = "<octomap>";
         cells.shapes = {{PointCloud{{{0.28, 0.28, 0.55}}, 0.1}, {}}};
         c.scene.objects.push_back(cells);
       },
       Code::goal_in_collision, "<octomap>"}};
  return rows;
}

/// Answers, in one session after another request, so that no row depends on what was before.
void check(const std::vector<Row>& rows) {
  MoveItSession session(arm_robot());
  for (const Row& row : rows) {
    Case question;
    row.change(question);
    const MoveItResponse response = session.solve(question.scene, question.request);
    BOOST_TEST(to_string(response.code) == to_string(row.code), row.field << ": " << to_string(response.code) << ": "
                                                                          << response.message << ", expected "
                                                                          << to_string(row.code));
    BOOST_TEST(response.message.find(row.fragment) != std::string::npos, row.field << ": " << response.message);
    const bool solved = row.code == Code::success;
    BOOST_TEST(response.message.empty() == solved, row.field);
    BOOST_TEST((response.trajectory.size() > 1) == solved, row.field);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_field_of_a_request_is_honoured_or_refused_with_its_code) { check(requests()); }

BOOST_AUTO_TEST_CASE(path_constraints_are_honoured_or_refused_with_their_code) { check(path_constraints()); }

BOOST_AUTO_TEST_CASE(every_field_of_a_scene_is_honoured_or_refused_with_its_code) { check(scenes()); }
