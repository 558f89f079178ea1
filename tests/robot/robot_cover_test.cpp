#include "srmp/robot/robot_cover.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/shape/geometric_shapes.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <boost/test/unit_test.hpp>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include "srmp/core/error.hpp"
#include "srmp/cover/quick_cover.hpp"
#include "srmp/geometry/mesh_geometry.hpp"
#include "support/amount.hpp"
#include "support/data.hpp"
#include "support/files.hpp"
#include "support/mesh_arm.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool same(const std::vector<PlacedSphere>& a, const std::vector<PlacedSphere>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PlacedSphere& x, const PlacedSphere& y) {
    return same_bits(x.radius, y.radius) && same_bits(x.center[0], y.center[0]) &&
           same_bits(x.center[1], y.center[1]) && same_bits(x.center[2], y.center[2]);
  });
}

bool same(const GeometryCover& a, const GeometryCover& b) {
  return same(std::vector{a.bound}, std::vector{b.bound}) && same(a.coarse, b.coarse) && same(a.fine, b.fine) &&
         same(a.inner, b.inner) && a.children == b.children && a.exact == b.exact && a.hollow == b.hollow &&
         a.quick == b.quick && same_bits(a.coarse_inflation.max, b.coarse_inflation.max) &&
         same_bits(a.coarse_inflation.mean, b.coarse_inflation.mean) &&
         same_bits(a.fine_inflation.max, b.fine_inflation.max) &&
         same_bits(a.fine_inflation.mean, b.fine_inflation.mean);
}

bool same(const RobotCover& a, const RobotCover& b) {
  return std::equal(a.parts.begin(), a.parts.end(), b.parts.begin(), b.parts.end(), [](const auto& x, const auto& y) {
    return x.link == y.link && x.name == y.name && x.in_link.matrix() == y.in_link.matrix() && same(*x.cover, *y.cover);
  });
}

/// Coarse covers, which are quick to compute.
const CoverLevels kRough{.coarse = 0.06, .fine = 0.04, .closing = 0.02};

using Geometry = std::shared_ptr<const coal::CollisionGeometry>;

Geometry box(double x, double y, double z) { return std::make_shared<coal::Box>(x, y, z); }

/// A sphere with bumps and dents; with a triangle taken out where asked.
TriangleSoup lumpy(unsigned seed, bool open) {
  std::mt19937 random(seed);
  constexpr int rings = 7, sectors = 10;
  TriangleSoup mesh;
  const auto at = [&](double up, double around) {
    const double r = 0.08 + 0.05 * (random() * 0x1p-32);
    return Eigen::Vector3d(r * std::sin(up) * std::cos(around), r * std::sin(up) * std::sin(around), r * std::cos(up));
  };
  mesh.vertices = {at(0, 0), at(M_PI, 0)};
  for (int i = 1; i < rings; ++i)
    for (int k = 0; k < sectors; ++k) mesh.vertices.push_back(at(M_PI * i / rings, 2 * M_PI * k / sectors));
  const auto id = [&](int i, int k) { return 2 + (i - 1) * sectors + k % sectors; };
  for (int k = 0; k < sectors; ++k) {
    mesh.triangles.push_back({0, id(1, k), id(1, k + 1)});
    mesh.triangles.push_back({1, id(rings - 1, k + 1), id(rings - 1, k)});
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({id(i, k), id(i + 1, k), id(i + 1, k + 1)});
      mesh.triangles.push_back({id(i, k), id(i + 1, k + 1), id(i, k + 1)});
    }
  }
  if (open) mesh.triangles.pop_back();
  return mesh;
}

std::string only_file(const std::string& directory) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) files.push_back(entry.path().string());
  BOOST_REQUIRE(files.size() == 1u);
  return files[0];
}

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

RobotDescription mbm_robot(const std::string& name, const std::string& end_effector) {
  RobotDescription description;
  description.urdf_path = mbm_file(name, name + ".urdf");
  description.srdf_path = mbm_file(name, name + ".srdf");
  description.end_effector = end_effector;
  return description;
}

/// Sets an environment variable for one test.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Environment() { old_ ? setenv(name_, old_->c_str(), 1) : unsetenv(name_); }

 private:
  const char* name_;
  std::optional<std::string> old_;
};

}  // namespace

/// Points on the triangles, evenly spread.
std::vector<Eigen::Vector3d> points_on(const TriangleSoup& mesh) {
  std::vector<Eigen::Vector3d> points;
  for (const auto& [a, b, c] : mesh.triangles)
    for (int i = 0; i <= 8; ++i)
      for (int k = 0; i + k <= 8; ++k) {
        const auto corner = [&](int number) { return mesh.vertices[static_cast<std::size_t>(number)]; };
        points.push_back((i * corner(a) + k * corner(b) + (8 - i - k) * corner(c)) / 8.0);
      }
  return points;
}

BOOST_AUTO_TEST_CASE(quick_covers_contain_meshes_and_stick_out_little) {
  for (unsigned seed = 0; seed < amount(20u); ++seed)
    for (const bool open : {false, true}) {
      const TriangleSoup mesh = lumpy(seed, open);
      const GeometryCover cover = quick_cover(*make_mesh_geometry(mesh, MeshModel::surface));
      BOOST_TEST(cover.quick);
      BOOST_TEST(cover.fine.size() <= 128u);
      const std::vector<Eigen::Vector3d> points = points_on(mesh);
      for (const Eigen::Vector3d& point : points)
        for (const auto* level : {&cover.coarse, &cover.fine})
          BOOST_REQUIRE(std::any_of(level->begin(), level->end(), [&](const PlacedSphere& sphere) {
            return (point - sphere.center).norm() <= sphere.radius * (1 + 1e-12);
          }));
      const CoverSolid solid = CoverSolid::mesh(mesh.vertices, mesh.triangles);
      double inflation = 0;
      for (const PlacedSphere& sphere : cover.fine) inflation += sphere.radius - solid.depth(sphere.center);
      if (!open) BOOST_TEST(inflation / static_cast<double>(cover.fine.size()) < 0.014);  // of a solid of 0.2 m
    }
}

BOOST_AUTO_TEST_CASE(covers_of_lumpy_meshes_contain_them) {
  for (unsigned seed = 1; seed <= 2; ++seed)
    for (const bool open : {false, true}) {
      const TriangleSoup mesh = lumpy(seed, open);
      const Geometry shape = make_mesh_geometry(mesh, MeshModel::surface);
      const GeometryCover cover = cover_geometry(*shape, {.coarse = 0.04, .fine = 0.025});
      const CoverSolid solid = CoverSolid::mesh(mesh.vertices, mesh.triangles, 0.015);
      BOOST_TEST(solid.is_closed() == !open);
      BOOST_TEST(contains_solid(cover.coarse, solid));
      BOOST_TEST(contains_solid(cover.fine, solid));
      BOOST_TEST(cover.coarse_inflation.max <= 0.040001);
      BOOST_TEST(cover.fine_inflation.max <= 0.025001);
      BOOST_TEST(cover.coarse_inflation.mean <= cover.coarse_inflation.max + 1e-12);
      BOOST_TEST(cover.children.size() == cover.coarse.size());
      BOOST_TEST(cover.hollow);
      for (const PlacedSphere& sphere : cover.inner) BOOST_TEST(solid.depth(sphere.center) >= sphere.radius - 1e-12);
    }
}

BOOST_AUTO_TEST_CASE(cavities_behind_small_holes_may_be_filled) {
  // A box of thin walls with a square hole of 2 cm in its lid.
  TriangleSoup mesh;
  const auto quad = [&](Eigen::Vector3d a, Eigen::Vector3d b, Eigen::Vector3d c, Eigen::Vector3d d) {
    const int n = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
    mesh.triangles.push_back({n, n + 1, n + 2});
    mesh.triangles.push_back({n, n + 2, n + 3});
  };
  const double h = 0.1, e = 0.01;
  quad({-h, -h, -h}, {h, -h, -h}, {h, h, -h}, {-h, h, -h});
  for (const double s : {-h, h}) {
    quad({s, -h, -h}, {s, h, -h}, {s, h, h}, {s, -h, h});
    quad({-h, s, -h}, {h, s, -h}, {h, s, h}, {-h, s, h});
  }
  quad({-h, -h, h}, {h, -h, h}, {h, -e, h}, {-h, -e, h});
  quad({-h, e, h}, {h, e, h}, {h, h, h}, {-h, h, h});
  quad({-h, -e, h}, {-e, -e, h}, {-e, e, h}, {-h, e, h});
  quad({e, -e, h}, {h, -e, h}, {h, e, h}, {e, e, h});
  const CoverSolid as_it_is = CoverSolid::mesh(mesh.vertices, mesh.triangles);
  const CoverSolid filled = CoverSolid::mesh(mesh.vertices, mesh.triangles, 0.015);
  BOOST_TEST(as_it_is.depth({0, 0, 0}) < 0);
  BOOST_TEST(filled.depth({0, 0, 0}) > 0.09);
  BOOST_TEST(filled.depth({0, 0, 0.099}) < 0.012);  // beside the hole
  BOOST_TEST(filled.depth({0, 0, 0.12}) < 0);
  BOOST_TEST(filled.depth({0.12, 0, 0}) < 0);
  const SphereCover a = cover_solid(as_it_is, {.max_inflation = 0.015}),
                    b = cover_solid(filled, {.max_inflation = 0.015});
  BOOST_TEST(contains_solid(b.spheres, filled));
  BOOST_TEST(2 * b.spheres.size() < a.spheres.size());
}

BOOST_AUTO_TEST_CASE(every_geometry_of_a_robot_is_covered) {
  const auto robot = RobotModel::load(arm7());
  CoverStore store("");
  const RobotCover cover = cover_robot(*robot, store, {.levels = kRough});
  BOOST_REQUIRE(cover.parts.size() == robot->geometries().size());
  for (std::size_t i = 0; i < cover.parts.size(); ++i) {
    BOOST_TEST(cover.parts[i].name == robot->geometries()[i].name);
    BOOST_TEST((store.cover(*robot->geometries()[i].shape) == cover.parts[i].cover));
  }
  BOOST_TEST(cover.coarse_spheres() <= 160u);
  BOOST_TEST(cover.coarse_inflation() <= kRough.coarse * 1.0001);
  BOOST_TEST(cover.fine_inflation() <= kRough.fine * 1.0001);
  BOOST_TEST((cover.origin == CoverStore::Origin::built));

  // The URDF file alone gives the same covers, with any number of threads; poses are computed in another way.
  CoverStore other("");
  const RobotCover from_file = cover_urdf(arm7().urdf_path, {}, other, {.levels = kRough, .threads = 1});
  BOOST_REQUIRE(from_file.parts.size() == cover.parts.size());
  for (std::size_t i = 0; i < cover.parts.size(); ++i) {
    BOOST_TEST(same(*cover.parts[i].cover, *from_file.parts[i].cover));
    BOOST_TEST(cover.parts[i].in_link.isApprox(from_file.parts[i].in_link, 1e-12));
  }
}

BOOST_AUTO_TEST_CASE(coarse_spheres_grow_until_they_are_few_enough) {
  const auto robot = RobotModel::load(arm7());
  CoverStore store("");
  const RobotCover free = cover_robot(*robot, store, {.levels = kRough, .max_coarse = 0});
  const std::size_t budget = free.coarse_spheres() - 3;
  const RobotCover tight = cover_robot(*robot, store, {.levels = kRough, .max_coarse = budget});
  BOOST_TEST(tight.coarse_spheres() <= budget);
  BOOST_TEST(tight.coarse_inflation() > free.coarse_inflation());
  BOOST_TEST(tight.fine_spheres() == free.fine_spheres());
}

BOOST_AUTO_TEST_CASE(loaded_covers_equal_computed_ones_bit_for_bit) {
  const TemporaryDirectory directory;
  const auto robot = RobotModel::load(arm7());
  const RobotCoverOptions options{.levels = kRough};
  CoverStore first(directory.path("covers")), second(directory.path("covers"));
  const RobotCover built = cover_robot(*robot, first, options);
  const RobotCover loaded = cover_robot(*robot, second, options);
  BOOST_TEST((built.origin == CoverStore::Origin::built));
  BOOST_TEST((loaded.origin == CoverStore::Origin::file));
  BOOST_TEST((cover_robot(*robot, second, options).origin == CoverStore::Origin::memory));
  BOOST_TEST(same(built, loaded));
  const auto copy = RobotModel::load(arm7());  // the same content at other addresses
  BOOST_TEST((cover_robot(*copy, second, options).origin == CoverStore::Origin::memory));
  BOOST_TEST((cover_robot(*robot, second, {.levels = kRough, .max_coarse = 150}).origin == CoverStore::Origin::built));
}

BOOST_AUTO_TEST_CASE(quick_covers_of_a_robot_are_kept_in_a_file) {
  const TemporaryDirectory directory;
  const auto robot = RobotModel::load(arm7()), copy = RobotModel::load(arm7());
  CoverStore first(directory.path("covers"), kRough), second(directory.path("covers"), kRough);
  ensure_quickly_covered(*robot, first);
  const auto files = [&] {
    const std::filesystem::directory_iterator all(directory.path("covers"));
    return std::distance(begin(all), end(all));
  };
  BOOST_TEST(files() == 1);
  ensure_quickly_covered(*copy, second);
  BOOST_TEST(files() == 1);
  for (std::size_t i = 0; i < robot->geometries().size(); ++i) {
    const auto built = first.adopted_quick(*robot->geometries()[i].shape);
    const auto loaded = second.adopted_quick(*copy->geometries()[i].shape);
    BOOST_REQUIRE((built && loaded));
    BOOST_TEST(same(*built, *loaded));
  }
  BOOST_TEST(!ensure_covered(*copy, second));  // a file of quick covers is not taken for one of close covers
}

BOOST_AUTO_TEST_CASE(covers_are_keyed_by_content_and_levels) {
  const TemporaryDirectory directory;
  CoverStore store(directory.path(), kRough);
  const GeometryCover& a = *store.cover(*box(0.3, 0.2, 0.1));
  BOOST_TEST((store.cover(*box(0.3, 0.2, 0.1)).get() == &a));
  BOOST_TEST((store.cover(*box(0.3, 0.2, 0.11)).get() != &a));
  BOOST_TEST(same(*CoverStore(directory.path(), kRough).cover(*box(0.3, 0.2, 0.1)), a));
  const GeometryCover finer = *CoverStore(directory.path(), {.coarse = 0.06, .fine = 0.02}).cover(*box(0.3, 0.2, 0.1));
  BOOST_TEST(finer.fine.size() > a.fine.size());
  const GeometryCover& sphere = *store.cover(coal::Sphere(0.1));
  BOOST_TEST(sphere.exact);
  BOOST_TEST(sphere.fine.empty());
}

BOOST_AUTO_TEST_CASE(large_geometries_are_covered_less_closely) {
  CoverLevels levels = kRough;
  const coal::Box bar(0.4, 0.4, 0.02);  // its bounding sphere's radius is 0.28 m
  const GeometryCover full = cover_geometry(bar, levels);
  levels.full_size = 0.2831;
  BOOST_TEST(same(cover_geometry(bar, levels), full));
  levels.full_size = 0.25;
  const double growth = std::pow(full.bound.radius / 0.25, 6);
  const GeometryCover coarser = cover_geometry(bar, levels);
  BOOST_TEST(coarser.fine.size() < full.fine.size());
  BOOST_TEST(coarser.coarse_inflation.max <= growth * levels.coarse * 1.0001);
  BOOST_TEST(coarser.fine_inflation.max <= growth * levels.fine * 1.0001);
  BOOST_TEST(coarser.fine_inflation.max > levels.fine);

  for (const double size : {1.0, 10.0, 1000.0}) {
    const Eigen::Vector3d sizes(size, size, 0.02);
    const GeometryCover plate = cover_geometry(*box(sizes[0], sizes[1], sizes[2]), {});
    for (const auto* level : {&plate.coarse, &plate.fine}) BOOST_TEST(contains_solid(*level, CoverSolid::box(sizes)));
    BOOST_TEST(plate.fine.size() < 1500u);  // the cost follows from it
  }
}

BOOST_AUTO_TEST_CASE(covers_of_damaged_files_are_computed_again) {
  const TemporaryDirectory directory;
  const Geometry shape = box(0.2, 0.1, 0.1);
  const auto ask = [&] {
    CoverStore store(directory.path(), kRough);
    return *store.cover(*shape);
  };
  const GeometryCover good = ask();
  const std::string path = only_file(directory.path()), text = contents(path);
  const auto damaged = [&](const std::string& bad) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bad;
    BOOST_TEST(same(ask(), good));
    BOOST_TEST(contents(path) == text);  // repaired
    BOOST_TEST(only_file(directory.path()) == path);
  };
  damaged("");
  damaged("no cover");
  damaged(text.substr(0, text.size() / 2));
  damaged(text + "x");
  for (const std::size_t i : {std::size_t{0}, std::size_t{8}, std::size_t{20}, text.size() / 2, text.size() - 1}) {
    std::string flipped = text;
    flipped[i] ^= 4;  // magic, version, key, numbers, checksum
    damaged(flipped);
  }
}

BOOST_AUTO_TEST_CASE(a_directory_that_cannot_be_used_is_no_error) {
  const TemporaryDirectory directory;
  const Geometry shape = box(0.2, 0.1, 0.1);
  CoverStore none("", kRough);
  const std::string file = directory.write("file", "not a directory");
  CoverStore blocked(file + "/covers", kRough);
  BOOST_TEST(same(*blocked.cover(*shape), *none.cover(*shape)));
  if (geteuid() != 0) {  // root may read and write everything
    const std::string locked = directory.path("locked");
    std::filesystem::create_directories(locked);
    chmod(locked.c_str(), 0500);
    CoverStore store(locked, kRough);
    BOOST_TEST(same(*store.cover(*shape), *none.cover(*shape)));
    chmod(locked.c_str(), 0700);
  }
}

BOOST_AUTO_TEST_CASE(threads_share_stores_and_directories) {
  const TemporaryDirectory directory;
  CoverStore shared(directory.path(), kRough), own(directory.path(), kRough);
  const std::vector<Geometry> shapes{box(0.2, 0.1, 0.1), std::make_shared<coal::Cylinder>(0.05, 0.2),
                                     std::make_shared<coal::Cone>(0.05, 0.2), box(0.1, 0.1, 0.1)};
  std::vector<std::vector<const GeometryCover*>> found(3);
  const auto work = [&](CoverStore& store, std::size_t t) {
    for (const Geometry& shape : shapes) found[t].push_back(store.cover(*shape).get());
  };
  std::thread a(work, std::ref(shared), 0), b(work, std::ref(shared), 1), c(work, std::ref(own), 2);
  a.join();
  b.join();
  c.join();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    BOOST_TEST((found[0][i] == found[1][i]));
    BOOST_TEST(same(*found[0][i], *found[2][i]));
  }
}

BOOST_AUTO_TEST_CASE(the_environment_selects_the_directory) {
  const Environment home("HOME", "/home/someone");
  {
    const Environment a("SRMP_CACHE_DIR", nullptr), b("XDG_CACHE_HOME", nullptr);
    BOOST_TEST(default_cover_directory() == "/home/someone/.cache/srmp/covers");
  }
  {
    const Environment a("SRMP_CACHE_DIR", nullptr), b("XDG_CACHE_HOME", "/caches");
    BOOST_TEST(default_cover_directory() == "/caches/srmp/covers");
  }
  const Environment b("XDG_CACHE_HOME", "relative");
  const Environment a("SRMP_CACHE_DIR", nullptr);
  BOOST_TEST(default_cover_directory() == "/home/someone/.cache/srmp/covers");
  const Environment c("SRMP_CACHE_DIR", "/mine");
  BOOST_TEST(default_cover_directory() == "/mine/covers");
  const Environment d("SRMP_CACHE_DIR", "");
  BOOST_TEST(default_cover_directory() == "");
}

BOOST_AUTO_TEST_CASE(progress_increases_and_may_stop_the_computation) {
  const auto robot = RobotModel::load(arm7());
  CoverStore store("");
  const RobotCoverOptions options{.levels = kRough};
  struct Stop {};
  BOOST_CHECK_THROW(cover_robot(*robot, store, options, [](std::size_t, std::size_t) { throw Stop(); }), Stop);
  std::size_t last = 0, all = 0;
  cover_robot(*robot, store, options, [&](std::size_t done, std::size_t total) {
    BOOST_TEST(done >= last);
    last = done;
    all = total;
  });
  BOOST_TEST(last == all);
  BOOST_TEST(all > 0u);
}

BOOST_AUTO_TEST_CASE(covers_reject_unsupported_geometry_and_invalid_options) {
  check_throws<InvalidArgument>([] { cover_geometry(*box(1, 1, 1), {.coarse = 0}); }, "coarse inflation");
  check_throws<InvalidArgument>([] { cover_geometry(*box(1, 1, 1), {.fine = NAN}); }, "fine inflation");
  check_throws<InvalidArgument>([] { CoverStore("", {.coarse = 0.01, .fine = 0.02}); }, "must not exceed");
  check_throws<InvalidArgument>([] { cover_geometry(*box(1, 1, 1), {.closing = -1}); }, "closing");
  CoverStore store("");
  check_throws<NotSupported>([&] { store.cover(coal::Plane(Eigen::Vector3d(0, 0, 1), 0)); }, "solids and meshes");
  check_throws<FileError>([&] { cover_urdf("/nowhere.urdf", {}, store); }, "nowhere.urdf");
  coal::Box swept(1, 1, 1);
  swept.setSweptSphereRadius(0.1);
  check_throws<NotSupported>([&] { store.cover(swept); }, "padding");
}

BOOST_AUTO_TEST_CASE(covers_of_robots_of_meshes_contain_them) {
  const std::array<std::pair<const char*, const char*>, 4> robots{
      {{"arm7 of meshes", ""}, {"ur5", "tool0"}, {"panda", "panda_hand"}, {"fetch", "gripper_link"}}};
  for (std::size_t k = 0; k < amount(robots.size()); ++k) {
    const auto& [name, end_effector] = robots[k];
    const RobotDescription description = k == 0 ? mesh_arm::description() : mbm_robot(name, end_effector);
    if (description.urdf_path.empty()) continue;
    const auto robot = RobotModel::load(description);
    CoverStore store("");
    // Coarser than the default: the proof is the same, with fewer spheres to compute.
    const RobotCover cover = cover_robot(*robot, store, {.levels = {.coarse = 0.04, .fine = 0.025}});
    BOOST_TEST(cover.coarse_spheres() <= 160u, name);
    BOOST_TEST(cover.fine_inflation() <= 0.025001, name);
    for (std::size_t i = 0; i < cover.parts.size(); ++i) {
      const auto* mesh = dynamic_cast<const coal::BVHModelBase*>(robot->geometries()[i].shape.get());
      if (!mesh) continue;
      CoverSolid::Triangles triangles;
      for (std::size_t n = 0; n < mesh->num_tris; ++n) {
        const auto& t = (*mesh->tri_indices)[n];
        triangles.push_back({static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
      }
      const CoverSolid solid =
          CoverSolid::mesh({mesh->vertices->begin(), mesh->vertices->begin() + mesh->num_vertices}, triangles, 0.015);
      BOOST_TEST(contains_solid(cover.parts[i].cover->coarse, solid), cover.parts[i].name);
      BOOST_TEST(contains_solid(cover.parts[i].cover->fine, solid), cover.parts[i].name);
    }
  }
}
