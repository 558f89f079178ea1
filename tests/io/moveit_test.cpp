#include "srmp/io/moveit.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <regex>

#include "io/temp_file.hpp"
#include "srmp/core/error.hpp"
#include "support/files.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::io;

namespace {

const std::string data = SRMP_SOURCE_DIR "/tests/io/data/";
const std::string scene_text = read_text(data + "scene.yaml");
const std::string request_text = read_text(data + "request.yaml");

SceneFile scene_from(const std::string& text) { return read_moveit_scene(TempFile(text).path()); }
RequestFile request_from(const std::string& text) { return read_moveit_request(TempFile(text).path()); }

template <class Exception = FileError>
void scene_refused(const std::string& from, const std::string& to, const std::string& fragment) {
  check_throws<Exception>([&] { scene_from(replaced(scene_text, from, to)); }, fragment);
}
template <class Exception = FileError>
void request_refused(const std::string& from, const std::string& to, const std::string& fragment) {
  check_throws<Exception>([&] { request_from(replaced(request_text, from, to)); }, fragment);
}

void check_near(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  BOOST_TEST((a - b).norm() < 1e-12, a.transpose() << " is not " << b.transpose());
}

std::string one_object(const std::string& rest) { return "world: {collision_objects: [{id: thing, " + rest + "}]}"; }

/// The robot with the virtual joint of the files.
Scene scene_with_robot() {
  RobotDescription description = robots::planar_description();
  description.srdf_text =
      "<robot name='planar'><virtual_joint name='virtual_joint' type='floating' parent_frame='odom' "
      "child_link='base'/><group name='arm'><chain base_link='base' tip_link='tip'/></group></robot>";
  Scene scene;
  scene.add_robot(RobotModel::load(description));
  return scene;
}

std::filesystem::path mbm_directory() {
  const char* directory = std::getenv("SRMP_MBM_DIR");
  return directory ? directory : "";
}

/// The directory of <robot>'s problems: in the data directory, or unpacked from its archive into `scratch`. Empty if
/// neither exists.
std::filesystem::path unpacked_problems(const std::string& robot, const std::filesystem::path& scratch) {
  const std::filesystem::path directory = mbm_directory() / robot;
  if (std::filesystem::is_directory(directory / "problems")) return directory / "problems";
  if (!std::filesystem::exists(directory / "problems.tar.bz2")) return {};
  std::filesystem::create_directories(scratch / robot);
  const std::string command =
      "tar -xjf '" + (directory / "problems.tar.bz2").string() + "' -C '" + (scratch / robot).string() + "'";
  return std::system(command.c_str()) == 0 ? scratch / robot : std::filesystem::path();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_scene_file_is_read_in_full) {
  const SceneFile scene = read_moveit_scene(data + "scene.yaml");
  BOOST_TEST(scene.name == "kitchen");
  BOOST_TEST(scene.robot_model_name == "planar");

  BOOST_REQUIRE(scene.objects.size() == 2u);
  const CollisionObject& shelf = scene.objects[0];
  BOOST_TEST(shelf.id == "shelf");
  BOOST_TEST(shelf.frame == "shelf_frame");
  BOOST_TEST((shelf.operation == ObjectOperation::add));
  BOOST_REQUIRE(shelf.shapes.size() == 3u);
  check_near(std::get<Box>(shelf.shapes[0].shape).size, {1, 2, 3});
  BOOST_TEST(std::get<Sphere>(shelf.shapes[1].shape).radius == 0.5);
  BOOST_TEST(std::get<Cone>(shelf.shapes[2].shape).length == 0.4);
  BOOST_TEST(std::get<Cone>(shelf.shapes[2].shape).radius == 0.1);
  check_near(shelf.pose * shelf.shapes[0].pose.p, {1, 1, 0});  // the object is rotated by 90 degrees
  check_near(shelf.pose * shelf.shapes[1].pose.p, {1, 0, 1});
  check_near(shelf.pose * Eigen::Vector3d(1, 0, 0), {1, 1, 0});

  const CollisionObject& wedge = scene.objects[1];
  const Mesh& mesh = std::get<Mesh>(wedge.shapes[0].shape);
  BOOST_TEST(mesh.vertices.size() == 4u);
  BOOST_TEST((mesh.triangles == std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 1, 3}}));
  check_near(wedge.shapes[0].pose.p, {5, 0, 0});

  BOOST_REQUIRE(scene.fixed_frames.size() == 1u);
  BOOST_TEST(scene.fixed_frames[0].frame == "world");
  BOOST_TEST(scene.fixed_frames[0].child == "shelf_frame");
  check_near(scene.fixed_frames[0].pose.p, {0, 0, 2});
  BOOST_TEST(scene.allowed_collisions.names.size() == 4u);
  BOOST_TEST(scene.allowed_collisions.entries[3][2]);
  BOOST_TEST(!scene.allowed_collisions.entries[3][0]);
  BOOST_TEST(!scene.allowed_collisions.defaults.at("upper"));

  BOOST_TEST((scene.robot_state.joints == std::map<std::string, double>{{"a", 0.25}, {"b", -1.0}}));
  check_near(scene.robot_state.multi_dof_joints.at("virtual_joint").p, {0, 0, 1});
  BOOST_REQUIRE(scene.robot_state.attached.size() == 1u);
  const AttachedObject& attached = scene.robot_state.attached[0];
  BOOST_TEST(attached.link == "tip");
  BOOST_TEST((attached.touch_links == std::vector<std::string>{"upper"}));
  BOOST_TEST(std::get<Cylinder>(attached.object.shapes[0].shape).length == 0.2);
  BOOST_TEST(std::get<Cylinder>(attached.object.shapes[0].shape).radius == 0.03);
}

BOOST_AUTO_TEST_CASE(a_request_file_is_read_in_full) {
  const RequestFile request = read_moveit_request(data + "request.yaml");
  BOOST_TEST(request.group_name == "arm");
  BOOST_TEST(request.planner_id == "RRTConnect");
  BOOST_TEST(request.allowed_planning_time.value() == 2.5);
  BOOST_TEST(request.velocity_scaling == 1.0);
  BOOST_TEST(request.acceleration_scaling == 0.5);
  BOOST_TEST(request.workspace->frame == "world");
  check_near(request.workspace->min_corner, {-1, -1, 0});
  check_near(request.workspace->max_corner, {1, 1, 2});
  BOOST_TEST((request.start_state.joints == std::map<std::string, double>{{"a", 0.0}, {"b", 0.5}}));

  BOOST_REQUIRE(request.goals.size() == 2u);
  const GoalAlternative &joints = request.goals[0], &pose = request.goals[1];
  BOOST_TEST(joints.name == "folded");
  BOOST_REQUIRE(joints.joints.size() == 2u);
  BOOST_TEST(joints.joints[0].position == 0.3);
  BOOST_TEST(joints.joints[0].tolerance_above == 0.01);
  BOOST_TEST(joints.joints[0].tolerance_below == 0.02);
  BOOST_TEST(joints.joints[1].joint == "b");
  BOOST_TEST(joints.joints[1].tolerance_above == 0.0);

  BOOST_REQUIRE((pose.positions.size() == 1u && pose.orientations.size() == 1u));
  BOOST_TEST(pose.positions[0].link == "tip");
  BOOST_TEST(pose.positions[0].frame == "world");
  BOOST_TEST(std::get<Sphere>(pose.positions[0].regions[0].shape).radius == 0.001);
  check_near(pose.positions[0].regions[0].pose.p, {0.4, 0, 0.5});
  BOOST_TEST(pose.orientations[0].orientation.x() == 1.0);
  check_near(pose.orientations[0].tolerance, {0.1, 0.2, 3.15});
  BOOST_TEST(pose.orientations[0].rotation_vector);
}

BOOST_AUTO_TEST_CASE(parts_that_a_scene_leaves_out_are_empty) {
  const SceneFile empty = scene_from("name: ''\n");
  BOOST_TEST(empty.objects.empty());
  BOOST_TEST(empty.robot_state.joints.empty());
  const SceneFile bare =
      scene_from(one_object("primitives: [{type: box, dimensions: [1, 1, 1]}], pose: {position: [1, 2, 3]}"));
  check_near(bare.objects[0].pose.p, {1, 2, 3});
  BOOST_TEST(bare.objects[0].frame == "");
}

BOOST_AUTO_TEST_CASE(files_of_srmp_are_refused_in_place_of_moveits) {
  const std::string ours = "{\n\"format\": \"srmp problem\", \"format_version\": 1}";
  check_throws<FileError>([&] { scene_from(ours); },
                          ":2: this is a file of the format 'srmp problem', not a MoveIt planning scene; Planner");
  check_throws<FileError>(
      [&] { request_from(ours); },
      ":2: this is a file of the format 'srmp problem', not a MoveIt motion plan request; srmp replay");
}

BOOST_AUTO_TEST_CASE(errors_in_scenes_name_their_line) {
  scene_refused("primitive_poses:\n        - {p", "primitve_poses:\n        - {p",
                "unknown key 'primitve_poses' in a collision object, did you mean 'primitive_poses'?");
  scene_refused("fixed_frame_transforms", "fixed_frame_transform",
                ":26: unknown key 'fixed_frame_transform' in a planning scene, did you mean 'fixed_frame_transforms'?");
  scene_refused("type: box", "type: bx",
                ":51: object 'shelf' has the unknown type 'bx'; known are 'box', 'sphere', 'cylinder' and 'cone'");
  scene_refused("[1, 2, 3]", "[1, 2]", "dimensions must be 3 numbers, not 2");
  scene_refused("[1, 2, 3]", "[1, 0, 3]", "has the dimension 0; all must be above 0");
  scene_refused("[1, 2, 3]", "[1, -2, 3]", "has the dimension -2");
  scene_refused("[1, 2, 3]", "[1, .nan, 3]",
                ":51: object 'shelf''s dimensions is .nan; only finite numbers are allowed");
  scene_refused("[1, 2, 3]", "[1, nan, 3]", "only finite");
  scene_refused("[1, 2, 3]", "[1, .inf, 3]", "only finite");
  scene_refused("rotation: [0, 0, 0, 1]}]", "rotation: [0, 0, 0, 0]}]", "pose quaternion is zero");
  scene_refused("orientation: [0, 0, 1, 1]", "orientation: [0, 0, 1]", "must be 4 numbers, not 3");
  scene_refused("{x: 0, y: 0, z: 1}", "{x: 0, y: 0}", "has no 'z'");
  scene_refused("        - {position: [0, 0, 0]}\n", "", "has 3 shapes, but 2 primitive_poses");
  scene_refused("id: wedge", "id: shelf", "two objects named 'shelf'");
  scene_refused("id: wedge", "id: bottle", "two objects named 'bottle'");
  scene_refused("id: wedge", "id: ''", "id is empty");
  scene_refused("- id: wedge", "- name: wedge", "unknown key 'name' in a collision object");
  scene_refused("[0, 1, 3]", "[0, 1, 4]", "has the index 4, but there are 4 vertices");
  scene_refused("[0, 1, 3]", "[0, 1, 1.5]", "has the index 1.5");
  scene_refused("position: [0.25, -1]", "position: [0.25]", "names 2 joints, but has 1 positions");
  scene_refused("[a, b]", "[a, a]", "joint 'a' appears twice");
  scene_refused("[virtual_joint]", "[]", "names 0 joints, but has 1 transforms");
  scene_refused("[true, false, true, false]", "[true, false, true]", "a row of 3 values for 4 names");
  scene_refused("    - [true, false, true, false]\n", "", "has 3 rows for 4 names");
  scene_refused("[true, false, true, false]", "[true, maybe, true, false]", "must be true or false, not 'maybe'");
  scene_refused("[true, false, true, false]", "{}", "a row of entry_values has no 'enabled'");
  scene_refused("[true, false, true, false]", "{enabled: 3}", "a row of entry_values must be a list, not '3'");
  scene_refused("[false]", "[]", "1 default_entry_names, but 0 default_entry_values");
  scene_refused("name: kitchen", "name: kitchen\nname: again", ":3: key 'name' appears twice");
  check_throws<FileError>([] { scene_from(one_object("pose: {}")); }, "has no shape");
  check_throws<FileError>([] { scene_from(one_object("primitives: [{type: box, dimensions: [1, 1, 1]}]")); },
                          "has no 'primitive_poses'");
  check_throws<FileError>([] { scene_from("world: {collision_objects: 3}"); },
                          "collision_objects must be a list, not '3'");
  check_throws<FileError>([] { scene_from(""); }, "the file is empty");
  check_throws<FileError>([] { scene_from("world: {"); }, "not valid YAML");
  check_throws<FileError>([] { read_moveit_scene("/no/such.yaml"); }, "there is no such file");
}

BOOST_AUTO_TEST_CASE(unsupported_parts_of_scenes_are_refused) {
  scene_refused<NotSupported>("planes: []", "planes: [{coef: [0, 0, 1, 0]}]", "object 'wedge' has planes");
  scene_refused<NotSupported>("data: []", "data: [1, 2]", "octomap");
  scene_refused("padding: 0}", "padding: -0.1}", "the padding of link 'upper' is -0.1; it must be 0 or above");
  scene_refused<NotSupported>("scale: 1.0}", "scale: 2}", "sets the scale of link 'upper'");
  scene_refused("operation: 0", "operation: 4", "has the unknown operation '4'");
  scene_refused<NotSupported>("type: Cone", "type: prism", "is a prism");
  check_throws<NotSupported>(
      [] { scene_from(one_object("meshes: [{resource: 'a.stl'}], pose: {}, mesh_poses: [{}]")); }, "names a mesh file");
}

BOOST_AUTO_TEST_CASE(errors_in_requests_name_their_line) {
  request_refused("goal_constraints:", "goal_constraint:",
                  ":15: unknown key 'goal_constraint' in a motion plan request, did you mean 'goal_constraints'?");
  request_refused("- {joint_name: a, position: 0.3, ", "- {joint_name: a, ",
                  ":18: a joint constraint has no 'position'");
  request_refused("position: 0.3", "position: .nan", ":18: a's position is .nan");
  request_refused("tolerance_above: 0.01", "tolerance_above: -1", "tolerance_above is -1; it must be 0 or above");
  request_refused("joint_name: b", "joint_name: a", "joint 'a' is constrained twice");
  request_refused("joint_name: b", "joint_nam: b", "did you mean 'joint_name'?");
  request_refused("orientation: [1, 0, 0, 0]", "orientation: [0, 0, 0, 0]",
                  "quaternion has the length 0; it must be 1");
  request_refused("parameterization: 1", "parameterization: 2", "parameterization is 2");
  request_refused("absolute_y_axis_tolerance: 0.2", "absolute_y_axis_tolerance: -0.2",
                  "absolute_y_axis_tolerance is -0.2");
  request_refused("allowed_planning_time: 2.5", "allowed_planning_time: -1", ":5: allowed_planning_time is -1");
  request_refused("max_acceleration_scaling_factor: 0.5", "max_acceleration_scaling_factor: 1.5",
                  "it must be in 0 … 1");
  request_refused("min_corner: [-1, -1, 0]", "min_corner: [-1, 3, 0]",
                  "min_corner 3 is above its max_corner 1 along y");
  request_refused("[0.001]", "[0]", "has the dimension 0");
  request_refused("position: [0, 0.5]", "position: [0, x]", "must be a number, not 'x'");
  check_throws<FileError>([] { request_from("group_name: arm\n"); }, "has no goal_constraints");
  check_throws<FileError>([] { request_from("goal_constraints: []\n"); }, "has no goal_constraints");
  check_throws<FileError>([] { request_from("goal_constraints: [{name: a}]\n"); }, "holds no constraints");
}

BOOST_AUTO_TEST_CASE(unsupported_parts_of_requests_are_refused) {
  request_refused<NotSupported>("type: sphere, dimensions: [0.001]", "type: cone, dimensions: [1, 1]",
                                "a cone is not supported");
  request_refused<NotSupported>("joint_constraints: [], position",
                                "joint_constraints: [{joint_name: a, position: 0}], position",
                                "joint_constraints in path_constraints are not supported");
  request_refused<NotSupported>("num_planning_attempts: 1", "trajectory_constraints: {constraints: [{}]}",
                                "trajectory_constraints are not supported");
  request_refused("num_planning_attempts: 1", "max_cartesian_speed: .inf", "only finite numbers are allowed");
  request_refused<NotSupported>(
      "    orientation_constraints:", "    visibility_constraints: [{}]\n    orientation_constraints:",
      "visibility_constraints are not supported");
  BOOST_TEST(!request_from(replaced(request_text, "allowed_planning_time: 2.5", "allowed_planning_time: 0"))
                  .allowed_planning_time.has_value());
}

BOOST_AUTO_TEST_CASE(a_scene_file_is_applied_to_a_scene) {
  Scene scene = scene_with_robot();
  const Pose robot_base = Pose::from_xyzw({0, 0, 10}, {0, 0, 0, 1});
  BOOST_TEST(apply(read_moveit_scene(data + "scene.yaml"), scene, robot_base).empty());
  check_near(scene.robot("planar").base.p, {0, 0, 11});
  check_near({scene.robot("planar").q[0], scene.robot("planar").q[1], 0}, {0.25, -1, 0});
  BOOST_TEST((scene.object_names() == std::vector<std::string>{"bottle", "shelf", "shelf_1", "shelf_2", "wedge"}));
  check_near(scene.object_pose("shelf").p, {1, 1, 12});  // from its frame to the world
  check_near(scene.object_pose("wedge").p, {5, 0, 10});
  BOOST_TEST(scene.attachments().at("bottle").link == "tip");
  BOOST_TEST(scene.attachments().at("bottle").touch_links.contains("upper"));
  check_near(scene.object_pose("bottle").p, scene.link_pose("planar", "tip") * Eigen::Vector3d(0, 0, 0.1));

  BOOST_TEST(scene.allowed_collision("tip", "shelf_2"));  // every shape of the object
  BOOST_TEST(scene.allowed_collision("bottle", "shelf"));
  BOOST_TEST(!scene.allowed_collision("upper", "shelf"));
}

BOOST_AUTO_TEST_CASE(entries_of_unknown_links_say_nothing) {
  Scene scene = scene_with_robot();
  const bool before = scene.allowed_collision("upper", "tip");
  // Links that this robot does not have may be named, as long as no object's entry allows contact with them.
  const std::string other = replaced(scene_text, "entry_names: [upper, tip,", "entry_names: [torso, tip,");
  apply(scene_from(other), scene);
  BOOST_TEST(scene.allowed_collision("upper", "tip") == before);
}

BOOST_AUTO_TEST_CASE(a_refused_file_leaves_the_scene_as_it_was) {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& fragment) {
    Scene scene = scene_with_robot();
    scene.add_object("table", Box{{1, 1, 1}}, {});
    const SceneFile file = scene_from(replaced(scene_text, from, to));
    check_throws<Error>([&] { apply(file, scene); }, fragment);
    BOOST_TEST((scene.object_names() == std::vector<std::string>{"table"}));
    BOOST_TEST(scene.attachments().empty());
  };
  refused("header: {frame_id: shelf_frame}", "header: {frame_id: shelf_fram}",
          "object 'shelf' is in the unknown frame 'shelf_fram', did you mean 'shelf_frame'?");
  refused("link_name: tip", "link_name: tipp", "unknown link 'tipp', did you mean 'tip'?");
  refused("id: wedge", "id: table", "table");
  refused("id: wedge", "id: shelf_1", "'shelf_1' is taken by an object");
  refused("entry_names: [upper, tip,", "entry_names: [upper, tool,", "tool");
  refused("joint_names: [virtual_joint]", "joint_names: [wheels]", "'wheels' is not a virtual joint");
}

BOOST_AUTO_TEST_CASE(objects_can_be_given_in_the_frame_of_a_link) {
  Scene scene = scene_with_robot();
  apply(scene_from(one_object(
            "header: {frame_id: lower}, primitives: [{type: sphere, dimensions: [0.1]}], pose: {position: [0, 1, 0]}")),
        scene);
  check_near(scene.object_pose("thing").p, {1, 1, 0});
}

BOOST_AUTO_TEST_CASE(a_request_can_attach_objects) {
  const std::string held =
      replaced(request_text, "start_state:\n",
               "start_state:\n  attached_collision_objects: [{link_name: tip, object: {id: cup, header: {frame_id: "
               "tip}, primitives: [{type: sphere, dimensions: [0.1]}], pose: {}}}]\n");
  Scene scene = scene_with_robot();
  const StartState start = apply_start(request_from(held), scene, "planar");
  check_near({start.q[0], start.q[1], 0}, {0, 0.5, 0});
  BOOST_TEST(scene.attachments().at("cup").link == "tip");
  check_near(scene.object_pose("cup").p, {2, 0, 0});
}

namespace {

/// How many scenes with objects, and how many requests of joints, a directory holds; all of its files are read.
struct ProblemCounts {
  int scenes{}, requests{};
};

ProblemCounts read_problems(const std::filesystem::path& problems) {
  ProblemCounts counts;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(problems)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("scene") && name.ends_with(".yaml")) {
      Scene scene;
      apply(read_moveit_scene(entry.path().string()), scene);
      counts.scenes += !scene.objects().empty();
    } else if (name.starts_with("request") && name.ends_with(".yaml")) {
      const RequestFile request = read_moveit_request(entry.path().string());
      counts.requests +=
          request.goals.size() == 1 && request.goals[0].joints.size() >= 6 && !request.start_state.joints.empty();
    }
  }
  return counts;
}

/// As MoveIt writes messages: every field, with a header and a time.
std::string written_scene(int number) {
  const std::string scene = R"(name: ""
robot_state:
  joint_state: {header: {stamp: {secs: 0, nsecs: 0}, frame_id: "", seq: 0}, name: [], position: [], velocity: [], effort: []}
  is_diff: false
fixed_frame_transforms: []
world:
  collision_objects:
    - header: {frame_id: world}
      id: boxNUMBER
      primitives:
        - type: box
          dimensions: [0.1, 0.2, 0.3]
      primitive_poses:
        - position: [PLACE, 0.5, 0.25]
          orientation: [0, 0, 0, 1]
      operation: add
    - id: can
      primitives: [{type: cylinder, dimensions: [0.2, 0.03]}]
      primitive_poses: [{position: [0, PLACE, 0.1], orientation: [0, 0, 0, 1]}]
is_diff: false
)";
  return std::regex_replace(std::regex_replace(scene, std::regex("PLACE"), std::to_string(0.1 * number)),
                            std::regex("NUMBER"), std::to_string(number));
}

std::string written_request(int number) {
  std::string names, positions, goals;
  for (int joint = 1; joint <= 7; ++joint) {
    const std::string name = "arm7_joint" + std::to_string(joint);
    names += (joint > 1 ? ", " : "") + name;
    positions += (joint > 1 ? ", " : "") + std::to_string(0.05 * joint);
    goals += "      - {joint_name: " + name + ", position: " + std::to_string(0.1 * joint - 0.05 * number) +
             ", tolerance_above: 0.001, tolerance_below: 0.001, weight: 1}\n";
  }
  return R"(workspace_parameters:
  header: {frame_id: world}
  min_corner: [-2, -2, -2]
  max_corner: [2, 2, 2]
planner_id: RRTConnect
group_name: arm
num_planning_attempts: 1
allowed_planning_time: 60
max_velocity_scaling_factor: 1
max_acceleration_scaling_factor: 1
start_state:
  is_diff: false
  joint_state:
    name: [)" +
         names + "]\n    position: [" + positions + "]\ngoal_constraints:\n  - joint_constraints:\n" + goals;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_directory_of_problems_can_be_read) {
  constexpr int problems = 20;
  const TemporaryDirectory directory;
  for (int k = 1; k <= problems; ++k) {
    const std::string number = std::to_string(1000 + k);
    directory.write("shelf_arm7/scene" + number + ".yaml", written_scene(k));
    directory.write("shelf_arm7/request" + number + ".yaml", written_request(k));
  }
  const ProblemCounts counts = read_problems(directory.path());
  BOOST_TEST(counts.scenes == problems);
  BOOST_TEST(counts.requests == problems);
  Scene scene;
  apply(read_moveit_scene(directory.path("shelf_arm7/scene1003.yaml")), scene);
  check_near(scene.object_pose("box3").p, {0.3, 0.5, 0.25});
  const RequestFile request = read_moveit_request(directory.path("shelf_arm7/request1003.yaml"));
  BOOST_TEST(std::abs(request.goals[0].joints[6].position - 0.55) < 1e-6);
  BOOST_TEST(std::abs(request.start_state.joints.at("arm7_joint2") - 0.1) < 1e-6);
}

BOOST_AUTO_TEST_CASE(every_motion_bench_maker_problem_can_be_read) {
  if (mbm_directory().empty()) {
    BOOST_TEST_MESSAGE("skipped: SRMP_MBM_DIR is not set");
    return;
  }
  const std::filesystem::path scratch =
      std::filesystem::temp_directory_path() / ("srmp_test_mbm_" + std::to_string(::getpid()));
  int robots_seen = 0;
  for (const std::string robot : {"panda", "ur5", "fetch"}) {
    const std::filesystem::path problems = unpacked_problems(robot, scratch);
    if (problems.empty()) {
      BOOST_TEST_MESSAGE("skipped: no problems of " << robot << " in SRMP_MBM_DIR");
      continue;
    }
    const auto [scenes, requests] = read_problems(problems);
    BOOST_TEST(scenes >= 350);
    BOOST_TEST(requests >= 350);
    BOOST_TEST(scenes == requests);
    BOOST_TEST_MESSAGE(robot << ": " << scenes << " problems");
    ++robots_seen;
  }
  std::filesystem::remove_all(scratch);
  BOOST_TEST_MESSAGE(robots_seen << " robots");
}
