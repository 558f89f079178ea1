#include "srmp/scene/scene.hpp"

#include <boost/test/data/test_case.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

#include "srmp/core/error.hpp"
#include "srmp/scene/scene_changes.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

/// base ──a── upper ──b── lower ── tip, called `name`.
std::shared_ptr<const RobotModel> planar_called(const std::string& name) {
  RobotDescription description = robots::planar()->description();
  description.name = name;
  return RobotModel::load(description);
}

/// Two equal robots, a cup attached to the first, and a table.
Scene two_planars() {
  Scene scene;
  scene.add_robot(planar_called("left"));
  scene.add_robot(planar_called("right"), Pose::from_rpy({0, 4, 0}, {0, 0, 0}));
  scene.add_object("table", Box{{1, 1, 0.1}}, Pose::from_rpy({0, 0, -1}, {0, 0, 0}), 0.01);
  scene.add_object("cup", Cylinder{0.05, 0.1}, Pose::from_rpy({2, 0, 0.1}, {0, 0, 0}));
  scene.attach_object("cup", "left", "tip", {"lower"});
  scene.set_allowed_collision("table", "left/upper");
  return scene;
}

/// Everything a caller can see of the scene, as text.
std::string state_of(const Scene& scene) {
  std::ostringstream out;
  out.precision(17);
  const auto put = [&](const Pose& pose) {
    for (double v : pose.to_list()) out << v << ' ';
  };
  for (const auto& [name, robot] : scene.robots()) {
    out << "\nrobot " << name << ' ' << robot.q.transpose() << " / " << robot.other_positions.transpose() << ' '
        << robot.padding << ' ';
    put(robot.base);
  }
  for (const auto& [name, object] : scene.objects()) {
    out << "\nobject " << name << ' ' << shape_kind(object.shape) << ' ' << object.padding << ' '
        << object.geometry.get() << ' ';
    put(object.pose);
  }
  for (const auto& [name, attachment] : scene.attachments()) {
    out << "\nattached " << name << ' ' << attachment.robot << ' ' << attachment.link;
    for (const std::string& link : attachment.touch_links) out << ' ' << link;
  }
  std::vector<std::string> bodies = scene.object_names();
  for (const std::string& robot : scene.robot_names())
    for (const std::string& link : scene.robot(robot).model->link_names()) bodies.push_back(robot + "/" + link);
  for (const std::string& a : bodies)
    for (const std::string& b : bodies) out << (scene.allowed_collision(a, b) ? '1' : '0');
  return out.str();
}

struct BadInput {
  const char* what;
  std::function<void(Scene&)> call;
  const char* sentence;  // a part of it
};
std::ostream& operator<<(std::ostream& out, const BadInput& bad) { return out << bad.what; }

Pose broken_pose(double px, double qw) { return {Eigen::Vector3d(px, 0, 0), Eigen::Quaterniond(qw, 0, 0, 0)}; }
const std::vector<Eigen::Vector3d> corner{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<Eigen::Vector3d> square{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};

void add(Scene& scene, const Shape& shape) { scene.add_object("x", shape, {}); }

const std::vector<BadInput> bad_inputs{
    {"null model", [](Scene& s) { s.add_robot(nullptr); }, "model is null"},
    {"robot twice", [](Scene& s) { s.add_robot(planar_called("left")); }, "name 'left' is taken by a robot"},
    {"robot named as an object", [](Scene& s) { s.add_robot(planar_called("table")); },
     "'table' is taken by an object"},
    {"robot base NaN", [](Scene& s) { s.add_robot(planar_called("third"), broken_pose(nan_value, 1)); },
     "base of robot 'third'"},
    {"unknown robot", [](Scene& s) { s.set_base_pose("lefd", {}); }, "unknown robot 'lefd', did you mean 'left'?"},
    {"remove unknown robot", [](Scene& s) { s.remove_robot("zzzzzz"); }, "known: 'left' and 'right'"},
    {"base with zero quaternion", [](Scene& s) { s.set_base_pose("left", broken_pose(0, 0)); }, "quaternion is zero"},
    {"qpos too short", [](Scene& s) { s.set_qpos("left", Eigen::VectorXd::Zero(1)); }, "left"},
    {"qpos NaN", [](Scene& s) { s.set_qpos("left", Eigen::Vector2d(0, nan_value)); }, "b is NaN"},
    {"qpos outside limits", [](Scene& s) { s.set_qpos("left", Eigen::Vector2d(0, 3.5)); }, "above the upper limit 3"},
    {"unknown joint", [](Scene& s) { s.set_joint_positions("left", {{"a", 0.5}, {"bb", 1}}); },
     "'bb', did you mean 'b'?"},
    {"joint outside limits", [](Scene& s) { s.set_joint_positions("left", {{"a", 0.5}, {"b", 4}}); },
     "outside its limits [-3, 3]"},
    {"joint infinite", [](Scene& s) { s.set_joint_positions("left", {{"a", INFINITY}}); }, "is infinity"},
    {"negative robot padding", [](Scene& s) { s.set_robot_padding("left", -0.1); }, "padding of robot 'left' is -0.1"},
    {"object twice", [](Scene& s) { s.add_object("cup", Sphere{1}, {}); }, "'cup' is taken by an object"},
    {"object named as a robot", [](Scene& s) { s.add_object("left", Sphere{1}, {}); }, "'left' is taken by a robot"},
    {"object named as a link", [](Scene& s) { s.add_object("left/tip", Sphere{1}, {}); },
     "is the name of a link of robot 'left'"},
    {"object without name", [](Scene& s) { s.add_object("", Sphere{1}, {}); }, "name is empty"},
    {"object pose NaN", [](Scene& s) { s.add_object("x", Sphere{1}, broken_pose(nan_value, 1)); },
     "pose of object 'x'"},
    {"object pose with zero quaternion", [](Scene& s) { s.add_object("x", Sphere{1}, broken_pose(0, 0)); }, "zero"},
    {"negative padding", [](Scene& s) { s.add_object("x", Sphere{1}, {}, -1e-3); }, "padding of object 'x' is -0.001"},
    {"padding NaN", [](Scene& s) { s.set_padding("cup", nan_value); }, "padding of object 'cup' is NaN"},
    {"negative box", [](Scene& s) { add(s, Box{{1, -1, 1}}); }, "box size of object 'x' is -1"},
    {"flat box", [](Scene& s) { add(s, Box{{1, 1, 0}}); }, "box size of object 'x' is 0"},
    {"infinite box", [](Scene& s) { add(s, Box{{1, INFINITY, 1}}); }, "infinity"},
    {"sphere of radius 0", [](Scene& s) { add(s, Sphere{0}); }, "sphere radius of object 'x' is 0"},
    {"cylinder of NaN", [](Scene& s) { add(s, Cylinder{nan_value, 1}); }, "cylinder radius of object 'x' is NaN"},
    {"cylinder without length", [](Scene& s) { add(s, Cylinder{1, 0}); }, "cylinder length"},
    {"capsule with negative length", [](Scene& s) { add(s, Capsule{1, -2}); }, "capsule length of object 'x' is -2"},
    {"cone with negative radius", [](Scene& s) { add(s, Cone{-1, 2}); }, "cone radius"},
    {"mesh without vertices", [](Scene& s) { add(s, Mesh{{}, {}, false}); }, "has no vertices"},
    {"mesh without triangles", [](Scene& s) { add(s, Mesh{corner, {}, false}); }, "has no triangles"},
    {"mesh with a wrong index", [](Scene& s) { add(s, Mesh{corner, {{0, 1, 4}}, false}); },
     "triangle 0 names vertex 4, but there are 4"},
    {"mesh with a negative index", [](Scene& s) { add(s, Mesh{corner, {{0, 1, 2}, {0, -1, 2}}, false}); },
     "triangle 1 names vertex -1"},
    {"mesh with NaN", [](Scene& s) { add(s, Mesh{{{0, 0, 0}, {1, 0, 0}, {0, nan_value, 0}}, {{0, 1, 2}}, false}); },
     "vertex 2 has"},
    {"mesh of lines", [](Scene& s) { add(s, Mesh{corner, {{0, 1, 1}}, false}); }, "every triangle has zero area"},
    {"hull of a flat mesh", [](Scene& s) { add(s, Mesh{square, {}, true}); }, "mesh of object 'x': the convex hull"},
    {"hull of three points", [](Scene& s) { add(s, Mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, true}); },
     "has no volume"},
    {"empty cloud", [](Scene& s) { add(s, PointCloud{{}, 0.1}); }, "point cloud of object 'x' is empty"},
    {"cloud of resolution 0", [](Scene& s) { add(s, PointCloud{{{0, 0, 0}}, 0}); },
     "point cloud resolution of object 'x' is 0"},
    {"cloud with NaN", [](Scene& s) { add(s, PointCloud{{{0, 0, 0}, {0, nan_value, 0}}, 0.1}); }, "point 1 has"},
    {"cloud beyond the octree", [](Scene& s) { add(s, PointCloud{{{0, 0, 400}}, 0.01}); }, "use a coarser resolution"},
    {"remove unknown object", [](Scene& s) { s.remove_object("tabel"); },
     "unknown object 'tabel', did you mean 'table'?"},
    {"move unknown object", [](Scene& s) { s.set_object_pose("zzz", {}); }, "known: 'cup' and 'table'"},
    {"move attached object", [](Scene& s) { s.set_object_pose("cup", {}); },
     "attached to link 'tip' of robot 'left'; detach it"},
    {"move to NaN", [](Scene& s) { s.set_object_pose("table", broken_pose(nan_value, 1)); }, "pose of object 'table'"},
    {"attach twice", [](Scene& s) { s.attach_object("cup", "right", "tip"); },
     "already attached to link 'tip' of robot 'left'"},
    {"attach unknown object", [](Scene& s) { s.attach_object("cap", "left", "tip"); }, "did you mean 'cup'?"},
    {"attach to unknown robot", [](Scene& s) { s.attach_object("table", "rihgt", "tip"); }, "did you mean 'right'?"},
    {"attach to unknown link", [](Scene& s) { s.attach_object("table", "left", "tipp"); }, "'tip'"},
    {"attach with unknown touch link", [](Scene& s) { s.attach_object("table", "left", "tip", {"lover"}); }, "'lower'"},
    {"attach at NaN", [](Scene& s) { s.attach_object("table", "left", "tip", {}, broken_pose(nan_value, 1)); },
     "in link 'tip'"},
    {"detach what is not attached", [](Scene& s) { s.detach_object("table"); }, "not attached; attached are 'cup'"},
    {"detach unknown object", [](Scene& s) { s.detach_object("cupp"); }, "did you mean 'cup'?"},
    {"allow unknown body", [](Scene& s) { s.set_allowed_collision("cup", "tabel"); }, "did you mean 'table'?"},
    {"allow unknown link", [](Scene& s) { s.set_allowed_collision("cup", "left/tipp"); }, "did you mean 'left/tip'?"},
    {"allow ambiguous link", [](Scene& s) { s.set_allowed_collision("cup", "tip"); },
     "ambiguous: 'left/tip' and 'right/tip'"},
    {"allow with itself", [](Scene& s) { s.set_allowed_collision("cup", "cup"); }, "the same body"},
    {"query unknown body", [](Scene& s) { s.allowed_collision("cup", "tabel"); }, "did you mean 'table'?"},
    {"pose of unknown link", [](Scene& s) { s.link_pose("left", "tipp"); }, "'tip'"},
    {"pose of unknown object", [](Scene& s) { s.object_pose("cupp"); }, "did you mean 'cup'?"},
};

}  // namespace

BOOST_DATA_TEST_CASE(invalid_input_is_one_sentence_and_changes_nothing, boost::unit_test::data::make(bad_inputs)) {
  Scene scene = two_planars();
  const std::string before = state_of(scene);
  check_throws<InvalidArgument>([&] { sample.call(scene); }, sample.sentence);
  BOOST_TEST(state_of(scene) == before);
}

BOOST_AUTO_TEST_CASE(a_missing_mesh_file_is_a_file_error) {
  check_throws<FileError>([] { Mesh::from_file("no/such/file.stl"); }, "no/such/file.stl");
  check_throws<InvalidArgument>([] { Mesh::from_file("no/such/file.stl", {1, 0, 1}); }, "scale");
}

BOOST_AUTO_TEST_CASE(shapes_have_a_kind) {
  BOOST_TEST(shape_kind(Box{{1, 1, 1}}) == "box");
  BOOST_TEST(shape_kind(PointCloud{{{0, 0, 0}}, 0.1}) == "point cloud");
  BOOST_TEST(shape_kind(Mesh{}) == "mesh");
}

BOOST_AUTO_TEST_CASE(poses_are_normalised) {
  Scene scene;
  scene.add_object("x", Sphere{1}, broken_pose(1, 2));
  BOOST_TEST(scene.object_pose("x").q.norm() == 1.0);
}

BOOST_AUTO_TEST_CASE(attaching_and_detaching_do_not_move_an_object) {
  Scene scene = two_planars();
  const Pose held = scene.object_pose("cup");
  BOOST_TEST((held.p - Eigen::Vector3d(2, 0, 0.1)).norm() < 1e-12);
  scene.set_qpos("left", Eigen::Vector2d(M_PI / 2, 0));
  BOOST_TEST((scene.object_pose("cup").p - Eigen::Vector3d(0, 2, 0.1)).norm() < 1e-12);
  scene.detach_object("cup");
  scene.set_qpos("left", Eigen::Vector2d(0, 0));
  BOOST_TEST((scene.object_pose("cup").p - Eigen::Vector3d(0, 2, 0.1)).norm() < 1e-12);
  scene.attach_object("cup", "right", "tip", {}, Pose::from_rpy({0.1, 0, 0}, {0, 0, 0}));
  BOOST_TEST((scene.object_pose("cup").p - Eigen::Vector3d(2.1, 4, 0)).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(removing_a_robot_detaches_its_objects_and_removes_its_settings) {
  Scene scene = two_planars();
  scene.remove_robot("left");
  BOOST_TEST(scene.attachments().empty());
  BOOST_TEST((scene.object_pose("cup").p - Eigen::Vector3d(2, 0, 0.1)).norm() < 1e-12);
  scene.add_robot(planar_called("left"));
  BOOST_TEST(!scene.allowed_collision("table", "left/upper"));
}

BOOST_AUTO_TEST_CASE(removing_an_object_detaches_it_and_removes_its_settings) {
  Scene scene = two_planars();
  scene.set_allowed_collision("cup", "table");
  scene.remove_object("cup");
  BOOST_TEST(scene.attachments().empty());
  scene.add_object("cup", Sphere{0.1}, {});
  BOOST_TEST(!scene.allowed_collision("cup", "table"));
}

BOOST_AUTO_TEST_CASE(a_scene_follows_the_objects_of_another) {
  Scene scene = two_planars();
  scene.set_allowed_collision("cup", "table");
  scene.add_object("gone", Sphere{0.1}, {});
  scene.set_group("desk", {{"table", "gone"}, {}, {}});
  Scene other = scene;
  other.remove_object("gone");
  other.add_object("new", Sphere{0.2}, {{0, 0, 1}, {1, 0, 0, 0}}, 0.01);
  other.set_object_pose("table", {{3, 0, 0}, {1, 0, 0, 0}});
  scene.follow_objects(other, {"gone", "new", "table"});
  BOOST_TEST((scene.object_names() == other.object_names()));
  BOOST_TEST(scene.object("new").geometry == other.object("new").geometry);
  BOOST_TEST(scene.object("new").padding == 0.01);
  BOOST_TEST(scene.object("table").pose.p.x() == 3.0);
  BOOST_TEST(scene.groups().at("desk").objects.size() == 1u);
  check_throws<InvalidArgument>([&] { scene.follow_objects(other, {"cup"}); }, "'cup' is attached");
  BOOST_TEST(scene.allowed_collision("cup", "table"));
}

BOOST_AUTO_TEST_CASE(changes_of_a_scene_are_found) {
  Scene before = two_planars();
  before.add_object("box", Box{{0.1, 0.1, 0.1}}, {});
  before.add_object("sphere", Sphere{0.1}, {});
  before.set_allowed_collision("box", "table");
  const auto changes = [&](auto&& change) {
    Scene after = before;
    change(after);
    return changes_between(before, after);
  };
  using Names = std::set<std::string>;
  const SceneChanges none = changes([](Scene&) {});
  BOOST_TEST((none.objects.empty() && none.robots.empty() && !none.anything_else));

  const SceneChanges objects = changes([](Scene& scene) {
    scene.set_object_pose("sphere", {{1, 0, 0}, {1, 0, 0, 0}});
    scene.remove_object("box");  // its setting goes with it
    scene.add_object("new", Sphere{0.1}, {});
    scene.set_allowed_collision("new", "left");
    scene.set_padding("table", 0.02);
  });
  BOOST_TEST((objects.objects == Names{"box", "new", "sphere", "table"}));
  BOOST_TEST((objects.robots.empty() && !objects.anything_else));
  const SceneChanges again = changes([](Scene& scene) {
    scene.remove_object("box");
    scene.add_object("box", Box{{0.1, 0.1, 0.1}}, {});
  });
  BOOST_TEST((again.objects == Names{"box"}));
  BOOST_TEST(!again.anything_else);

  const SceneChanges placed = changes([](Scene& scene) { scene.set_qpos("left", Eigen::Vector2d(0.1, 0.2)); });
  BOOST_TEST((placed.objects.empty() && placed.robots == Names{"left"} && !placed.anything_else));

  const std::vector<std::function<void(Scene&)>> others{
      [](Scene& scene) { scene.set_base_pose("left", {{0, 0, 1}, {1, 0, 0, 0}}); },
      [](Scene& scene) { scene.set_robot_padding("left", 0.01); },
      [](Scene& scene) { scene.remove_robot("right"); },
      [](Scene& scene) {
        scene.remove_robot("right");
        scene.add_robot(planar_called("right"), Pose::from_rpy({0, 4, 0}, {0, 0, 0}));
      },
      [](Scene& scene) {
        scene.detach_object("cup");
        scene.attach_object("cup", "left", "tip");
      },
      [](Scene& scene) {
        scene.detach_object("cup");
        scene.attach_object("cup", "left", "tip", {"lower"}, Pose{{0, 0, 0.2}, {1, 0, 0, 0}});
      },
      [](Scene& scene) { scene.add_robot(planar_called("third")); },
      [](Scene& scene) { scene.attach_object("box", "left", "tip"); },
      [](Scene& scene) { scene.detach_object("cup"); },
      [](Scene& scene) { scene.set_allowed_collision("sphere", "table"); },
      [](Scene& scene) { scene.set_allowed_collision("box", "table", false); },
      [](Scene& scene) { scene.set_allowed_collision("left", "right"); },
      [](Scene& scene) {  // the pairs of an object that only moved are those of before
        scene.set_object_pose("sphere", {{1, 0, 0}, {1, 0, 0, 0}});
        scene.set_allowed_collision("sphere", "left");
      },
      [](Scene& scene) { scene.clear_allowed_collisions(); },
      [](Scene& scene) { scene.reset(); }};
  for (std::size_t i = 0; i < others.size(); ++i) BOOST_TEST(changes(others[i]).anything_else, "change " << i);
}

BOOST_AUTO_TEST_CASE(a_group_goes_with_its_first_object) {
  Scene scene = two_planars();
  scene.add_object("table_1", Sphere{0.1}, {});
  scene.set_group("desk", {{"table", "table_1"}, {{0, 0, 1}, {1, 0, 0, 0}}, {{"edge", {}}}});
  BOOST_TEST((scene.groups().at("desk").frame.p == Eigen::Vector3d(0, 0, 1)));
  check_throws<InvalidArgument>([&] { scene.set_group("desk", {{}, {}, {}}); }, "group 'desk' has no objects");
  check_throws<InvalidArgument>([&] { scene.set_group("desk", {{"tabel"}, {}, {}}); }, "did you mean 'table'?");
  BOOST_TEST(scene.groups().at("desk").objects.size() == 2u);
  scene.remove_object("table_1");
  BOOST_TEST((scene.groups().at("desk").objects == std::vector<std::string>{"table"}));
  scene.remove_object("table");
  BOOST_TEST(scene.groups().empty());
}

BOOST_AUTO_TEST_CASE(allowed_collisions_override_the_rules_in_both_directions) {
  Scene scene = two_planars();
  BOOST_TEST(scene.allowed_collision("left/upper", "left/lower"));  // adjacent
  BOOST_TEST(!scene.allowed_collision("left/upper", "right/upper"));
  BOOST_TEST(scene.allowed_collision("cup", "left/tip"));    // holds it
  BOOST_TEST(scene.allowed_collision("left/lower", "cup"));  // touch link
  BOOST_TEST(!scene.allowed_collision("cup", "left/upper"));
  BOOST_TEST(!scene.allowed_collision("cup", "right/lower"));
  scene.set_allowed_collision("left/upper", "left/lower", false);
  scene.set_allowed_collision("cup", "left/lower", false);
  scene.set_allowed_collision("left/upper", "right/upper", true);
  BOOST_TEST(!scene.allowed_collision("left/lower", "left/upper"));
  BOOST_TEST(!scene.allowed_collision("cup", "left/lower"));
  BOOST_TEST(scene.allowed_collision("right/upper", "left/upper"));
}

BOOST_AUTO_TEST_CASE(the_name_of_a_robot_stands_for_its_links_and_later_calls_override_earlier_ones) {
  Scene scene = two_planars();
  scene.set_allowed_collision("table", "right");
  BOOST_TEST(scene.allowed_collision("table", "right"));
  BOOST_TEST(scene.allowed_collision("table", "right/tip"));
  scene.set_allowed_collision("right/tip", "table", false);
  BOOST_TEST(!scene.allowed_collision("table", "right/tip"));
  BOOST_TEST(scene.allowed_collision("table", "right/lower"));
  BOOST_TEST(!scene.allowed_collision("table", "right"));
  scene.set_allowed_collision("right", "table");
  BOOST_TEST(scene.allowed_collision("table", "right/tip"));
  scene.set_allowed_collision("left", "right");
  BOOST_TEST(scene.allowed_collision("left/tip", "right/lower"));
}

BOOST_AUTO_TEST_CASE(a_link_name_suffices_while_only_one_robot_has_the_link) {
  Scene scene;
  scene.add_robot(planar_called("left"));
  scene.add_object("cup", Sphere{0.1}, {});
  scene.set_allowed_collision("cup", "tip");
  BOOST_TEST(scene.allowed_collision("left/tip", "cup"));
}

BOOST_AUTO_TEST_CASE(a_robot_starts_within_its_limits) {
  RobotDescription description;
  description.urdf_text = "<robot name='r'><link name='base'/><link name='tip'/>" +
                          robots::joint("j", "revolute", "base", "tip", "0 0 0", "0 0 1",
                                        "<limit lower='0.5' upper='3' velocity='2' effort='1'/>") +
                          "</robot>";
  Scene scene;
  scene.add_robot(RobotModel::load(description));
  BOOST_TEST(scene.robot("r").q[0] == 0.5);
  scene.reset();
  BOOST_TEST(scene.robots().empty());
}
