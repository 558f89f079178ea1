#include "srmp/cover/quick_cover.hpp"

#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "srmp/cover/cover_solid.hpp"
#include "support/amount.hpp"

using namespace srmp;

namespace {

double uniform(std::mt19937& random, double low, double high) { return low + (high - low) * (random() * 0x1p-32); }

bool has(const PlacedSphere& sphere, const Eigen::Vector3d& p) { return (p - sphere.center).norm() <= sphere.radius; }

Eigen::Vector3d on(const PlacedSphere& sphere, std::mt19937& random) {
  const auto component = [&] { return uniform(random, -1, 1); };
  return sphere.center + sphere.radius * Eigen::Vector3d(component(), component(), component()).normalized();
}

/// Random points of the solid are in a coarse sphere and in one of its children; the inner spheres are in the solid.
void check_cover(const coal::ShapeBase& shape, const CoverSolid& solid, std::mt19937& random, bool with_inner) {
  const GeometryCover cover = quick_cover(shape);
  BOOST_TEST(cover.coarse.size() <= 27u);
  BOOST_TEST(cover.fine.size() <= 27u * 8u);
  BOOST_TEST(!cover.hollow);
  BOOST_TEST((with_inner ? !cover.inner.empty() && cover.inner.size() <= 16 : cover.inner.empty()));
  const PlacedSphere around = solid.bounding_sphere();
  for (int i = 0; i < amount(400); ++i) {
    PlacedSphere within = around;
    within.radius *= uniform(random, 0.0, 1.0);
    const Eigen::Vector3d p = on(within, random);
    if (solid.depth(p) < 0) continue;
    BOOST_TEST(has(cover.bound, p));
    const auto covers = [&](std::size_t c) {
      return has(cover.coarse[c], p) &&
             std::ranges::any_of(cover.children[c], [&](std::uint32_t f) { return has(cover.fine[f], p); });
    };
    bool covered = false;
    for (std::size_t c = 0; c < cover.coarse.size(); ++c) covered = covered || covers(c);
    BOOST_TEST(covered);
  }
  for (const PlacedSphere& sphere : cover.inner)
    for (int i = 0; i < 20; ++i) BOOST_TEST(solid.depth(on(sphere, random)) >= -1e-12);
}

}  // namespace

BOOST_AUTO_TEST_CASE(quick_covers_of_primitives_contain_them_and_inner_spheres_are_inside) {
  std::mt19937 random(1);
  const auto size = [&] { return std::pow(10.0, uniform(random, -3, 0)); };  // 1 mm to 1 m
  for (int i = 0; i < amount(100); ++i) {
    const double x = size(), y = size(), z = size();
    check_cover(coal::Box(x, y, z), CoverSolid::box({x, y, z}), random, true);
    check_cover(coal::Cylinder(x, y), CoverSolid::cylinder(x, y), random, true);
    check_cover(coal::Capsule(x, y), CoverSolid::capsule(x, y), random, true);
    check_cover(coal::Cone(x, y), CoverSolid::cone(x, y), random, false);
  }
}

/// The spheres of a slim rod hardly stick out of its side, and those inside overlap.
BOOST_AUTO_TEST_CASE(quick_covers_of_rods_are_close) {
  constexpr double radius = 0.02, length = 0.5;
  const GeometryCover cover = quick_cover(coal::Cylinder(radius, length));
  for (const PlacedSphere& sphere : cover.fine) BOOST_TEST(sphere.radius < 1.3 * radius);
  BOOST_TEST(cover.coarse.size() <= 9u);
  for (std::size_t i = 1; i < cover.inner.size(); ++i)
    BOOST_TEST((cover.inner[i].center - cover.inner[i - 1].center).norm() < 2 * radius - 1e-4);
}

/// Scenes refuse such sizes; a cover of them must end all the same.
BOOST_AUTO_TEST_CASE(quick_covers_of_endless_or_empty_things_end) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double size : {0.0, 1e-12, 1e12, infinity, std::nan("")}) {
    for (const double other : {0.0, 1.0}) {
      BOOST_TEST(quick_cover(coal::Box(size, other, 1.0)).inner.size() <= 16u);
      BOOST_TEST(quick_cover(coal::Cylinder(size, other)).inner.size() <= 16u);
      BOOST_TEST(quick_cover(coal::Cylinder(other, size)).inner.size() <= 16u);
      BOOST_TEST(quick_cover(coal::Capsule(size, other)).inner.size() <= 16u);
      BOOST_TEST(quick_cover(coal::Capsule(other, size)).inner.size() <= 16u);
    }
  }
}
