#include <coal/BVH/BVH_model.h>
#include <coal/collision_object.h>
#include <coal/mesh_loader/loader.h>

#include <boost/test/unit_test.hpp>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/geometry/mesh_geometry.hpp"
#include "srmp/robot/robot_model.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

/// The unit cube as OBJ text with twelve triangles, corner (0, 0, 0), and a stray line.
const char* kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 9 9 9\n"
    "f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n"
    "f 1 9\nf 1 1 2\n";

RobotDescription with_mesh(const std::string& filename) {
  RobotDescription description;
  description.urdf_text =
      "<robot name='r'><link name='base'>\n<collision><geometry><mesh filename='" + filename +
      "'/></geometry></collision></link><link name='tip'/><joint name='j' type='revolute'><parent link='base'/>"
      "<child link='tip'/><limit lower='-1' upper='1' velocity='1' effort='1'/></joint></robot>";
  return description;
}

std::string urdf_file(const TemporaryDirectory& directory, const std::string& name, const std::string& mesh) {
  return directory.write(name, with_mesh(mesh).urdf_text);
}

RobotDescription from_file(const std::string& path) {
  RobotDescription description;
  description.urdf_path = path;
  return description;
}

}  // namespace

BOOST_AUTO_TEST_CASE(mesh_files_are_read_without_their_degenerate_faces) {
  const TemporaryDirectory directory;
  const std::string path = directory.write("cube.obj", kCube);
  const TriangleSoup mesh = read_mesh_file(path, {1, 2, 3});
  BOOST_TEST(mesh.vertices.size() == 8);
  BOOST_TEST(mesh.triangles.size() == 12);
  Eigen::Vector3d high = mesh.vertices[0];
  for (const auto& v : mesh.vertices) high = high.cwiseMax(v);
  BOOST_TEST(high == Eigen::Vector3d(1, 2, 3));
}

BOOST_AUTO_TEST_CASE(a_link_of_several_materials_is_the_union_of_the_file_and_what_coal_reads) {
  const TemporaryDirectory directory;
  const std::string path =
      directory.write("two.obj",
                      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\n"
                      "usemtl a\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nusemtl b\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n");
  using Corners = std::set<std::array<double, 3>>;
  const auto corners = [](const auto& vertices, auto a, auto b, auto c) {
    Corners result;
    for (const auto i : {a, b, c}) {
      const Eigen::Vector3d v = vertices[static_cast<std::size_t>(i)];
      result.insert({v.x(), v.y(), v.z()});
    }
    return result;
  };
  const auto triangles = [&](const coal::CollisionGeometry& geometry) {
    const auto& model = dynamic_cast<const coal::BVHModelBase&>(geometry);
    std::set<Corners> result;
    for (const coal::Triangle& t : *model.tri_indices) result.insert(corners(*model.vertices, t[0], t[1], t[2]));
    return result;
  };
  const auto robot = RobotModel::load(from_file(urdf_file(directory, "r.urdf", "two.obj")));
  const std::set<Corners> ours = triangles(*robot->geometries()[0].shape);
  const TriangleSoup file = read_mesh_file(path);
  BOOST_TEST(file.parts == 2);
  for (const auto& t : file.triangles) BOOST_TEST(ours.count(corners(file.vertices, t[0], t[1], t[2])) == 1);
  for (const Corners& t : triangles(*coal::MeshLoader().load(path, coal::Vec3s::Ones())))
    BOOST_TEST(ours.count(t) == 1);
}

BOOST_AUTO_TEST_CASE(unreadable_meshes_are_errors_with_a_reason) {
  const TemporaryDirectory directory;
  check_throws<FileError>([] { read_mesh_file("/no/such.obj"); }, "mesh file '/no/such.obj' does not exist");
  check_throws<FileError>([&] { read_mesh_file(directory.path()); }, "is not a file");
  check_throws<FileError>([&] { read_mesh_file(directory.write("empty.stl", "")); }, "is empty");
  check_throws<FileError>([&] { read_mesh_file(directory.write("x.unknown", "hello")); }, "supported are '.stl'");
  check_throws<FileError>([&] { read_mesh_file(directory.write("points.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n")); },
                          "points.obj'");
}

BOOST_AUTO_TEST_CASE(files_that_count_more_than_they_hold_are_refused_at_once) {
  const TemporaryDirectory directory;
  const auto refused = [&](const std::string& name, const std::string& text, const std::string& why) {
    check_throws<FileError>([&] { read_mesh_file(directory.write(name, text)); }, why);
  };
  refused("a.ply", "ply\nformat ascii 1.0\nelement vertex 100000000\nproperty float x\nend_header\n",
          "has 100000000 elements 'vertex'");
  refused("a.ply", "ply\nformat ascii 1.0\ncomment\n", "without its last line, end_header");
  const std::string vertices = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nend_header\n0\n1\n2\n";
  refused("a.ply", vertices, "has 3 rows, but counts 4 elements");
  refused("a.ply", "ply\nformat ascii 1.0\nproperindices\nend_header\n", "has 'properindices' in its header");
  const std::string rows = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  BOOST_TEST(read_mesh_file(directory.write("a.off", "OFF\n4 4 6\n" + rows)).triangles.size() == 4u);
  BOOST_TEST(read_mesh_file(directory.write("a.off", "OFF 4 4 6\r\n" + rows)).triangles.size() == 4u);
  refused("a.off", "OFF # of a tetrahedron\n4 4 6\n" + rows, "has a comment (#)");
  refused("a.off", "nOFF\n3\n4 100000000 6\n" + rows, "nOFF");
  refused("a.gltf", "OFF\n4 4 6\n" + rows, "is no glTF");
  refused("a.off", "OFF\n4#4 6\n" + rows, "'4#4' as the number of vertices");
  refused("a.off", "OFF\n4000 4 6\n" + rows, "has 4000 vertices");
  refused("a.off", "OFF\n4 99 6\n" + rows, "has 99 faces");
  refused("a.off", "OFF\n4 -4 6\n" + rows, "'-4' as the number of faces");
  refused("a.off", "OFF\n4 4\n", "does not say how many vertices, faces and edges it has");
}

BOOST_AUTO_TEST_CASE(convex_meshes_become_solids_and_others_stay_surfaces) {
  const TemporaryDirectory directory;
  TriangleSoup cube = read_mesh_file(directory.write("cube.obj", kCube));
  BOOST_TEST(is_convex(cube));
  BOOST_TEST(make_mesh_geometry(cube, MeshModel::hull_if_convex)->getObjectType() == coal::OT_GEOM);
  BOOST_TEST(make_mesh_geometry(cube, MeshModel::surface)->getObjectType() == coal::OT_BVH);

  TriangleSoup open = cube;
  open.triangles.pop_back();
  BOOST_TEST(!is_convex(open));

  TriangleSoup dented = cube;  // a corner pushed 10 µm inwards bends the quads beside it the wrong way
  dented.vertices[static_cast<std::size_t>(dented.triangles[0][0])] += Eigen::Vector3d::Constant(1e-5);
  BOOST_TEST(!is_convex(dented));
  BOOST_TEST(make_mesh_geometry(dented, MeshModel::hull_if_convex)->getObjectType() == coal::OT_BVH);
  BOOST_TEST(make_mesh_geometry(dented, MeshModel::hull)->getObjectType() == coal::OT_GEOM);
}

BOOST_AUTO_TEST_CASE(a_hull_has_only_its_corners_and_faces_outwards) {
  std::vector<Eigen::Vector3d> points{{0.5, 0.5, 0.5}};  // inside
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1, (i >> 1) & 1, i >> 2);
  const TriangleSoup hull = convex_hull(points);
  BOOST_TEST(hull.vertices.size() == 8u);
  BOOST_TEST(hull.triangles.size() == 12u);
  BOOST_TEST(is_convex(hull));  // closed, too
  for (const auto& t : hull.triangles) {
    const Eigen::Vector3d &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
    BOOST_TEST((b - a).cross(c - a).dot(a - points[0]) > 0);
  }
  points.push_back({0, 0, std::numeric_limits<double>::quiet_NaN()});
  check_throws<InvalidArgument>([&] { convex_hull(points); }, "point 9 of a convex hull");
  check_throws<InvalidArgument>([&] { convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}); }, "3 points has no volume");
}

BOOST_AUTO_TEST_CASE(hulls_need_a_volume) {
  const TriangleSoup flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.3, 0.3, 0}}, {{0, 1, 2}}};
  check_throws<InvalidArgument>([&] { make_mesh_geometry(flat, MeshModel::hull); }, "has no volume");
  check_throws<InvalidArgument>([&] { make_mesh_geometry({flat.vertices, {}}, MeshModel::surface); },
                                "at least one triangle");
  BOOST_TEST(!spans_volume({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}));
  BOOST_TEST(!spans_volume({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}));
  BOOST_TEST(make_mesh_geometry(flat, MeshModel::hull_if_convex)->getObjectType() == coal::OT_BVH);
}

BOOST_AUTO_TEST_CASE(bounding_spheres_contain_their_mesh) {
  const TemporaryDirectory directory;
  directory.write("cube.obj", kCube);
  const auto robot = RobotModel::load(from_file(urdf_file(directory, "r.urdf", "cube.obj")));
  const LinkGeometry& geometry = robot->geometries().at(0);
  BOOST_TEST((geometry.center - Eigen::Vector3d::Constant(0.5)).norm() < 1e-12);
  BOOST_TEST(geometry.radius >= std::sqrt(0.75));
  BOOST_TEST(geometry.radius < std::sqrt(0.75) + 1e-9);
}

BOOST_AUTO_TEST_CASE(meshes_are_found_in_every_directory_that_is_searched) {
  const TemporaryDirectory directory;
  directory.write("work/meshes/cube.obj", kCube);
  directory.write("some_package/meshes/cube.obj", kCube);
  directory.write("elsewhere/other_package/cube.obj", kCube);
  const auto loads = [&](const std::string& mesh, const std::vector<std::string>& package_dirs = {}) {
    RobotDescription description = from_file(urdf_file(directory, "work/r.urdf", mesh));
    description.package_dirs = package_dirs;
    return RobotModel::load(description)->geometries().size() == 1;
  };
  BOOST_TEST(loads("meshes/cube.obj"));
  BOOST_TEST(loads("package://meshes/cube.obj"));
  BOOST_TEST(loads("package://work/meshes/cube.obj"));
  BOOST_TEST(loads("package://some_package/meshes/cube.obj"));
  BOOST_TEST(loads("file://" + directory.path("work/meshes/cube.obj")));
  BOOST_TEST(loads(directory.path("work/meshes/cube.obj")));
  BOOST_TEST(loads("package://other_package/cube.obj", {directory.path("elsewhere")}));
  BOOST_TEST(loads("package://other_package/cube.obj", {directory.path("elsewhere/other_package/")}));
  BOOST_TEST(loads("cube.obj", {directory.path("elsewhere/other_package")}));
}

BOOST_AUTO_TEST_CASE(packages_on_the_ros_path_are_found) {
  const TemporaryDirectory directory;
  directory.write("overlay/share/pack/cube.obj", kCube);
  setenv("AMENT_PREFIX_PATH", ("/nowhere:" + directory.path("overlay")).c_str(), 1);
  const auto robot = RobotModel::load(with_mesh("package://pack/cube.obj"));
  unsetenv("AMENT_PREFIX_PATH");
  BOOST_TEST(robot->geometries().size() == 1);
}

BOOST_AUTO_TEST_CASE(the_error_for_a_missing_mesh_lists_every_path_tried) {
  const TemporaryDirectory directory;
  RobotDescription description = from_file(urdf_file(directory, "work/r.urdf", "package://pack/cube.obj"));
  description.package_dirs = {"/my/packages"};
  const auto load = [&] { RobotModel::load(description); };
  check_throws<FileError>(load, "r.urdf:2: mesh 'package://pack/cube.obj' was not found; tried '");
  check_throws<FileError>(load, directory.path("work/pack/cube.obj"));
  check_throws<FileError>(load, directory.path("pack/cube.obj"));
  check_throws<FileError>(load, "'/my/packages/pack/cube.obj'");
  check_throws<FileError>([] { RobotModel::load(with_mesh("cube.obj")); }, "give package_dirs");
}

BOOST_AUTO_TEST_CASE(the_error_for_a_broken_mesh_gives_the_urdf_line_and_visuals_are_not_read) {
  const TemporaryDirectory directory;
  directory.write("broken.stl", "");
  check_throws<FileError>([&] { RobotModel::load(from_file(urdf_file(directory, "r.urdf", "broken.stl"))); },
                          "r.urdf:2: mesh file '");
  RobotDescription description = with_mesh("x.stl");
  for (std::size_t at; (at = description.urdf_text.find("collision>")) != std::string::npos;)
    description.urdf_text.replace(at, 10, "visual>");
  BOOST_TEST(RobotModel::load(description)->geometries().empty());
}
