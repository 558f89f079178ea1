#include "srmp/io/scene_file.hpp"

#include <boost/test/unit_test.hpp>

#include "io/worlds.hpp"
#include "srmp/core/error.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"
#include "temp_file.hpp"

namespace {

bool same(const srmp::Pose& a, const srmp::Pose& b) { return a.to_list() == b.to_list(); }

std::string text_of_every_kind() {
  const TemporaryDirectory directory;
  srmp::io::save_scene(worlds::every_kind(), directory.path("scene.json"));
  return read_text(directory.path("scene.json"));
}

void check_refused(const std::string& text, const std::string& fragment) {
  const TempFile file(text);
  check_throws<srmp::FileError>([&] { srmp::io::load_scene(file.path()); }, fragment);
  check_throws<srmp::FileError>([&] { srmp::io::load_scene(file.path()); }, file.path());
}

}  // namespace

BOOST_AUTO_TEST_SUITE(scene_file)

BOOST_AUTO_TEST_CASE(a_scene_is_read_back_bit_for_bit) {
  const srmp::Scene scene = worlds::every_kind();
  const TempFile file(text_of_every_kind());
  const srmp::Scene read = srmp::io::load_scene(file.path());
  BOOST_TEST(read.object_names() == scene.object_names());
  for (const auto& [name, object] : scene.objects()) {
    const srmp::Object& twin = read.object(name);
    BOOST_CHECK(same(twin.pose, object.pose));
    BOOST_CHECK_EQUAL(twin.padding, object.padding);
    BOOST_CHECK_EQUAL(srmp::shape_kind(twin.shape), srmp::shape_kind(object.shape));
  }
  BOOST_CHECK(std::get<srmp::Box>(read.object("box").shape).size == Eigen::Vector3d(0.1, 0.2, 1.0 / 3));
  const auto& mesh = std::get<srmp::Mesh>(read.object("surface").shape);
  BOOST_CHECK(mesh.vertices == std::get<srmp::Mesh>(scene.object("surface").shape).vertices);
  BOOST_CHECK(mesh.triangles == std::get<srmp::Mesh>(scene.object("surface").shape).triangles);
  BOOST_CHECK(std::get<srmp::PointCloud>(read.object("cloud").shape).points ==
              std::get<srmp::PointCloud>(scene.object("cloud").shape).points);
  const srmp::Attachment& held = read.attachments().at("attached");
  BOOST_CHECK_EQUAL(held.link, "tip");
  BOOST_CHECK((held.touch_links == std::set<std::string>{"lower", "tip"}));
  BOOST_CHECK(read.allowed_settings() == scene.allowed_settings());
  const srmp::RobotInstance &robot = scene.robot("planar"), &twin = read.robot("planar");
  BOOST_CHECK(same(robot.base, twin.base) && robot.q == twin.q && robot.padding == twin.padding);
  BOOST_CHECK(twin.model->joint_names() == robot.model->joint_names());
  BOOST_CHECK_EQUAL(twin.model->end_effector(), "tip");

  const TemporaryDirectory directory;
  srmp::io::save_scene(read, directory.path("again.json"));
  BOOST_CHECK(read_text(directory.path("again.json")) == read_text(file.path()));
}

BOOST_AUTO_TEST_CASE(poses_are_read_bit_for_bit) {
  srmp::Scene scene = worlds::every_kind();
  for (int i = 0; i < 5; ++i) {  // rounding errors add up
    scene.detach_object("attached");
    scene.attach_object("attached", "planar", "lower");
    scene.set_qpos("planar", Eigen::Vector2d(0.1 * i, 0.2 * i));
  }
  const TemporaryDirectory directory;
  srmp::io::save_scene(scene, directory.path("scene.json"));
  BOOST_CHECK(
      same(srmp::io::load_scene(directory.path("scene.json")).object("attached").pose, scene.object("attached").pose));
}

BOOST_AUTO_TEST_CASE(robots_need_only_their_mesh_files) {
  const TemporaryDirectory directory;
  const std::string urdf = robots::planar_description().urdf_text, mesh = R"(<mesh filename="parts/tip.stl"/>)";
  const std::string with_mesh = replaced(
      urdf, "<link name='tip'/>", "<link name='tip'><collision><geometry>" + mesh + "</geometry></collision></link>");
  directory.write("parts/tip.stl",
                  "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\n"
                  "endfacet\nendsolid t\n");
  srmp::RobotDescription description;
  description.urdf_path = directory.write("arm.urdf", with_mesh);
  description.srdf_path = directory.write("arm.srdf",
                                          "<robot name='planar'><group name='arm'><chain base_link='base' "
                                          "tip_link='tip'/></group></robot>");
  description.group = "arm";
  srmp::Scene scene;
  scene.add_robot(srmp::RobotModel::load(description));
  srmp::io::save_scene(scene, directory.path("scene.json"));
  directory.write("arm.urdf", "changed since");
  std::filesystem::remove(description.srdf_path);
  const auto read = srmp::io::load_scene(directory.path("scene.json"));
  BOOST_CHECK_EQUAL(read.robot("planar").model->geometries().size(), 3u);

  std::filesystem::create_directory(directory.path("elsewhere"));
  std::filesystem::rename(directory.path("parts"), directory.path("elsewhere/parts"));
  check_throws<srmp::FileError>(
      [&] { srmp::io::load_scene(directory.path("scene.json")); },
      "scene.robots[0]: URDF text:1: mesh 'parts/tip.stl' was not found; tried '" + directory.path("parts/tip.stl"));
  BOOST_CHECK_NO_THROW(srmp::io::load_scene(directory.path("scene.json"), {directory.path("elsewhere")}));
}

BOOST_AUTO_TEST_CASE(other_files_are_refused) {
  check_throws<srmp::FileError>([] { srmp::io::load_scene("/nowhere/s.json"); }, "there is no such file");
  check_refused("", "the file is empty");
  check_refused("[1, 2]", "this is no file of srmp; expected is a JSON map with \"format\": 'srmp scene'");
  check_refused("{}", "it does not say its format");
  check_refused(R"({"format": "srmp trajectory", "format_version": 1})", "the format is 'srmp trajectory'; expected");
  check_refused(R"({"format": "srmp scene", "format_version": 2, "srmp_version": "9.0"})",
                "srmp 9.0 wrote version 2 of the format 'srmp scene', and srmp");
  check_refused(R"({"format": "srmp scene", "format_version": 0, "srmp_version": "9.0"})", "format_version is 0");
  check_refused(R"({"format": "srmp scene"})", "it has no 'format_version'");
  check_refused(std::string("\x7f"
                            "ELF\0\1\2",
                            7),
                "");
}

BOOST_AUTO_TEST_CASE(errors_in_damaged_files_name_the_place) {
  const std::string text = text_of_every_kind();
  const auto changed = [&](const std::string& from, const std::string& to) { return replaced(text, from, to); };
  check_refused(changed("\"padding\": 0.01", "\"padding\": \"0.01\""),
                "scene.objects[1].padding must be a number, or one of the strings 'inf', '-inf' and 'nan', not '0.01'");
  check_refused(changed("\"padding\": 0.01", "\"padding\": \"inf\""), "scene.objects[1]: padding of object 'box'");
  check_refused(changed("\"padding\": 0.01", "\"padding\": []"), "scene.objects[1].padding must be a number");
  check_refused(changed("\"padding\": 0.01", "\"pading\": 0.01"), "scene.objects[1]: it has no 'padding'");
  check_refused(changed("\"padding\": 0.01", "\"padding\": 0.01, \"colour\": 3"),
                "unknown key 'colour' in scene.objects[1]");
  check_refused(changed("\"kind\": \"box\"", "\"kind\": \"torus\""),
                "scene.objects[1].shape: the kind is 'torus'; known");
  check_refused(changed("\"radius\": 0.05", "\"radius\": -1"), "sphere radius of object 'attached' is -1");
  check_refused(changed("\"convex\": false", "\"convex\": \"perhaps\""), "must be true or false");
  check_refused(changed("[0, 1, 2]", "[0, 1.5, 2]"), "must be a whole number");
  check_refused(changed("[0, 1, 2]", "[0, 1]"), "triangles[0] must be 3 numbers, not 2");
  check_refused(changed("[0, 1, 2]", "[0, 1, 7]"), "triangle 0 names vertex 7");
  check_refused(changed("\"link\": \"tip\"", "\"link\": \"tap\""), "tap");
  check_refused(changed("\"a\": \"cloud\"", "\"a\": \"clod\""), "did you mean 'cloud'?");
  check_refused(changed("\"a\": \"cloud\"", "\"a\": \"cloud\", \"a\": \"cloud\""), "key 'a' appears twice");
  check_refused(changed("<robot", "<robt"), "scene.robots[0]: URDF text");
  check_refused(changed("\"srmp_version\"", "\"srmp_verson\""), "it has no 'srmp_version'");
  for (std::size_t size = 1; size < text.size() - 2; size += text.size() / 97 + 1)
    check_refused(text.substr(0, size), "");
}

BOOST_AUTO_TEST_SUITE_END()
