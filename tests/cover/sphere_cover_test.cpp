#include "srmp/cover/sphere_cover.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "srmp/core/error.hpp"
#include "srmp/geometry/mesh_file.hpp"
#include "support/amount.hpp"
#include "support/data.hpp"
#include "support/mesh_arm.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

double uniform(std::mt19937& random) { return random() * 0x1p-32; }

bool covered(const std::vector<PlacedSphere>& spheres, const Eigen::Vector3d& p) {
  for (const PlacedSphere& b : spheres)
    if ((p - b.center).squaredNorm() <= b.radius * b.radius) return true;
  return false;
}

Eigen::Vector3d random_direction(std::mt19937& random) {
  for (;;) {
    const Eigen::Vector3d v(2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1);
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}

/// A lower bound on the inflation: how far sampled points of the sphere are outside of the solid.
double sampled_inflation(const CoverSolid& solid, const PlacedSphere& sphere, std::mt19937& random) {
  double worst = 0;
  for (int i = 0; i < 200; ++i)
    worst = std::max(worst, -solid.depth(sphere.center + sphere.radius * random_direction(random)));
  return worst;
}

/// Random points of the solid, by rejection sampling in its box.
void check_solid(const CoverSolid& solid, double inflation, const std::function<bool(const Eigen::Vector3d&)>& inside) {
  std::mt19937 random(7);
  const SphereCover cover = cover_solid(solid, {.max_inflation = inflation});
  BOOST_TEST(contains_solid(cover.spheres, solid));
  BOOST_TEST(cover.max_inflation <= inflation * 1.0001);
  const PlacedSphere around = solid.bounding_sphere();
  int tried = 0, missed = 0, outside_bound = 0;
  for (int i = 0; i < amount(200'000); ++i) {
    const Eigen::Vector3d p =
        around.center +
        around.radius * Eigen::Vector3d(2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1);
    if (!inside(p)) continue;
    ++tried;
    missed += !covered(cover.spheres, p);
    outside_bound += (p - around.center).norm() > around.radius;
  }
  BOOST_TEST(tried > 0);
  BOOST_TEST(missed == 0);
  BOOST_TEST(outside_bound == 0);
  for (const PlacedSphere& b : pack_solid(solid, 12))
    for (int i = 0; i < 200; ++i) BOOST_TEST(inside(b.center + b.radius * (1 - 1e-6) * random_direction(random)));
}

void check_convex(const CoverSolid& solid, double inflation) {
  check_solid(solid, inflation, [&](const Eigen::Vector3d& p) { return solid.depth(p) >= 0; });
}

/// An L of two boxes, as one closed surface: not convex.
TriangleSoup ell() {
  const std::vector<Eigen::Vector2d> ring{{0, 0}, {0.2, 0}, {0.2, 0.05}, {0.05, 0.05}, {0.05, 0.2}, {0, 0.2}};
  TriangleSoup mesh;
  for (double z : {0.0, 0.06})
    for (const auto& p : ring) mesh.vertices.emplace_back(p.x(), p.y(), z);
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, 6 + j});
    mesh.triangles.push_back({i, 6 + j, 6 + i});
  }
  for (const std::array<int, 3>& t : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({6 + t[0], 6 + t[1], 6 + t[2]});
  }
  return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(covers_of_primitives_contain_them) {
  check_convex(CoverSolid::box({0.3, 0.2, 0.1}), 0.01);
  check_convex(CoverSolid::box({0.3, 0.004, 0.1}), 0.01);
  check_convex(CoverSolid::cylinder(0.06, 0.2), 0.008);
  check_convex(CoverSolid::cone(0.06, 0.15), 0.008);
}

BOOST_AUTO_TEST_CASE(covers_of_spheres_and_capsules_are_formulas) {
  const SphereCover sphere = cover_solid(CoverSolid::sphere(0.1));
  BOOST_TEST(sphere.spheres.size() == 1u);
  BOOST_TEST(sphere.max_inflation < 1e-8);
  for (double length : {1e-3, 0.05, 0.4}) {
    const CoverSolid capsule = CoverSolid::capsule(0.05, length);
    const SphereCover cover = cover_solid(capsule, {.max_inflation = 0.004});
    BOOST_TEST(contains_solid(cover.spheres, capsule));
    BOOST_TEST(cover.max_inflation <= 0.004 + 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(cover_of_a_concave_mesh_does_not_fill_the_hull) {
  const TriangleSoup mesh = ell();
  const CoverSolid solid = CoverSolid::mesh(mesh.vertices, mesh.triangles);
  BOOST_TEST(!solid.is_convex());
  BOOST_TEST(solid.is_closed());
  check_solid(solid, 0.006, [](const Eigen::Vector3d& p) {
    const auto within = [&](double x, double y) { return p.x() <= x && p.y() <= y; };
    return p.minCoeff() >= 0 && p.z() <= 0.06 && (within(0.2, 0.05) || within(0.05, 0.2));
  });
  const SphereCover cover = cover_solid(solid, {.max_inflation = 0.006});
  BOOST_TEST(!covered(cover.spheres, {0.12, 0.12, 0.03}));  // the corner that the hull would fill
}

/// Its faces are doubled, so that every edge has an even number of them, and all of them lie on its hull.
BOOST_AUTO_TEST_CASE(nothing_is_inside_of_an_open_box) {
  CoverSolid::Vertices corners;
  for (const double x : {0.0, 0.3})
    for (const double y : {0.0, 0.2})
      for (const double z : {0.0, 0.2}) corners.emplace_back(x, y, z);
  CoverSolid::Triangles faces;
  for (const std::array<int, 4>& face :
       {std::array{0, 4, 6, 2}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}) {  // all but the lid
    faces.push_back({face[0], face[1], face[2]});
    faces.push_back({face[0], face[2], face[3]});
    faces.push_back({face[2], face[1], face[0]});
    faces.push_back({face[3], face[2], face[0]});
  }
  BOOST_TEST(pack_solid(CoverSolid::mesh(corners, faces), 12).empty());
  CoverSolid::Triangles single{{1, 3, 7}, {1, 7, 5}};  // closed by a lid, each face once
  for (std::size_t i = 0; i < faces.size(); i += 4) single.insert(single.end(), {faces[i], faces[i + 1]});
  BOOST_TEST(!pack_solid(CoverSolid::mesh(corners, single), 12).empty());
}

BOOST_AUTO_TEST_CASE(the_proof_finds_uncovered_parts) {
  const CoverSolid box = CoverSolid::box({0.1, 0.1, 0.1});
  std::vector<PlacedSphere> spheres = cover_solid(box, {.max_inflation = 0.01}).spheres;
  spheres.erase(spheres.begin());  // the first sphere of the selection contains the most
  BOOST_TEST(!contains_solid(spheres, box));
  BOOST_TEST(!contains_solid({}, box));
  BOOST_TEST(contains_solid({{{0, 0, 0}, 0.0867}}, box));
  // A shell of spheres that leaves a hole in the middle covers the surface, not the solid.
  std::vector<PlacedSphere> shell;
  for (double x = -0.05; x <= 0.0501; x += 0.01)
    for (double y = -0.05; y <= 0.0501; y += 0.01)
      for (double z = -0.05; z <= 0.0501; z += 0.01)
        if (std::max({std::abs(x), std::abs(y), std::abs(z)}) > 0.045) shell.push_back({{x, y, z}, 0.012});
  BOOST_TEST(!contains_solid(shell, box));
}

BOOST_AUTO_TEST_CASE(covers_are_deterministic_and_respect_the_largest_number_of_spheres) {
  const TriangleSoup mesh = ell();
  const CoverSolid solid = CoverSolid::mesh(mesh.vertices, mesh.triangles);
  const SphereCover a = cover_solid(solid), b = cover_solid(solid);
  BOOST_TEST(a.spheres.size() == b.spheres.size());
  for (std::size_t i = 0; i < a.spheres.size(); ++i)
    BOOST_TEST((a.spheres[i].center == b.spheres[i].center && a.spheres[i].radius == b.spheres[i].radius));
  const SphereCover few = cover_solid(solid, {.max_inflation = 0.004, .max_spheres = 10});
  BOOST_TEST(few.spheres.size() <= 10u);
  BOOST_TEST(few.max_inflation > 0.004);
  BOOST_TEST(contains_solid(few.spheres, solid));
}

BOOST_AUTO_TEST_CASE(children_cover_the_part_of_the_solid_in_their_coarse_sphere) {
  const TriangleSoup mesh = ell();
  const CoverSolid solid = CoverSolid::mesh(mesh.vertices, mesh.triangles);
  const std::vector<PlacedSphere> coarse = cover_solid(solid, {.max_inflation = 0.015}).spheres;
  const std::vector<PlacedSphere> fine = cover_solid(solid, {.max_inflation = 0.004}).spheres;
  const auto children = cover_children(solid, coarse, fine);
  BOOST_TEST(children.size() == coarse.size());
  std::mt19937 random(3);
  for (int i = 0; i < 50'000; ++i) {
    const Eigen::Vector3d p(0.2 * uniform(random), 0.2 * uniform(random), 0.06 * uniform(random));
    if (solid.depth(p) < 0) continue;
    bool found = false;
    for (std::size_t c = 0; c < coarse.size() && !found; ++c) {
      if ((p - coarse[c].center).norm() > coarse[c].radius) continue;
      for (std::uint32_t f : children[c]) found = found || (p - fine[f].center).norm() <= fine[f].radius;
    }
    BOOST_REQUIRE(found);
  }
}

BOOST_AUTO_TEST_CASE(covers_reject_invalid_input) {
  check_throws<InvalidArgument>([] { CoverSolid::box({0.1, 0, 0.1}); }, "box size");
  check_throws<InvalidArgument>([] { CoverSolid::sphere(NAN); }, "sphere radius");
  check_throws<InvalidArgument>([] { CoverSolid::mesh({}, {}); }, "no triangles");
  check_throws<InvalidArgument>([] { CoverSolid::mesh({{0, 0, 0}}, {{0, 0, 1}}); }, "names vertex 1");
  check_throws<InvalidArgument>([] { cover_solid(CoverSolid::sphere(1), {.max_inflation = 0}); }, "max_inflation");
}

namespace {

/// How many spheres cover these meshes with at most 15 mm of inflation; checks that they do.
std::size_t spheres_over(const std::vector<std::string>& parts) {
  std::mt19937 random(5);
  std::size_t spheres = 0;
  for (const std::string& part : parts) {
    const TriangleSoup mesh = read_mesh_file(part);
    const CoverSolid solid = CoverSolid::mesh(mesh.vertices, mesh.triangles);
    const SphereCover cover = cover_solid(solid, {.max_inflation = 0.015});
    BOOST_TEST(contains_solid(cover.spheres, solid), part);
    spheres += cover.spheres.size();
    for (const auto& t : mesh.triangles)
      for (int i = 0; i < 50; ++i) {
        double u = uniform(random), v = uniform(random);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        BOOST_REQUIRE(covered(cover.spheres, mesh.vertices[t[0]] + u * (mesh.vertices[t[1]] - mesh.vertices[t[0]]) +
                                                 v * (mesh.vertices[t[2]] - mesh.vertices[t[0]])));
      }
    if (solid.is_convex())
      for (const PlacedSphere& b : cover.spheres) BOOST_TEST(sampled_inflation(solid, b, random) <= 0.0151);
  }
  return spheres;
}

}  // namespace

BOOST_AUTO_TEST_CASE(covers_of_an_arm_of_meshes_are_small) {
  BOOST_TEST(spheres_over(mesh_arm::files().meshes) <= 150u);
}

BOOST_AUTO_TEST_CASE(covers_of_the_panda_are_small) {
  std::vector<std::string> parts;
  for (const char* part : {"link1", "link2", "link3", "link4", "link5", "link7", "hand", "finger"})
    parts.push_back(mbm_file("panda", std::string("meshes/collision/") + part + ".obj"));
  if (!parts.front().empty()) BOOST_TEST(spheres_over(parts) <= 150u);
}
