#include "srmp/collision/narrow_phase.hpp"

#include <coal/narrowphase/support_functions.h>
#include <coal/shape/geometric_shapes.h>

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/scene/shape_geometry.hpp"

using namespace srmp;
using namespace worlds;
using namespace srmp::detail;

// What the checker rests on: Coal's margin is right to the tolerance for every pair of kinds, and the hull is outside.

namespace {

using Geometry = std::shared_ptr<const coal::CollisionGeometry>;

struct NamedShape {
  std::string name;
  Geometry geometry;
  Bounds bounds;
  std::shared_ptr<const PrimitiveBvh> bvh;
};

NamedShape body_of(const std::string& name, const Geometry& geometry) {
  return {name, geometry, bounds_of(*geometry), make_primitive_bvh(*geometry)};
}

std::vector<NamedShape> bodies() {
  std::vector<NamedShape> all;
  for (const auto& [name, shape] : every_kind()) {
    const Geometry geometry = make_geometry(shape, name);
    all.push_back(body_of(name, geometry));
  }
  return all;
}

/// A mesh of many triangles first.
std::vector<NamedShape> bodies_and_large_ones() {
  std::vector<NamedShape> all = {body_of("dented", make_geometry(dented(), "dented")),
                                 body_of("large hull", make_geometry(hull_of(dented()), "large hull"))};
  for (NamedShape& body : bodies()) all.push_back(std::move(body));
  return all;
}

struct Place {
  Place(const NamedShape& of, const Pose& at) : body(of), pose(at.isometry()), center(pose * body.bounds.center) {}
  Placed placed() const { return {body.geometry.get(), body.bvh.get(), body.bounds, pose, center}; }
  const NamedShape& body;
  Eigen::Isometry3d pose;
  Eigen::Vector3d center;
};

/// A narrow phase for one pair.
struct Narrow {
  Narrow(const NamedShape& a, const NamedShape& b)
      : solids(!a.bvh && !b.bvh), formula(solids ? table.index(*a.geometry, *b.geometry) : -1), narrow(table) {}
  double distance(const Place& a, const Place& b, double margin) {
    if (solids) return narrow.solids(formula, a.placed(), b.placed(), margin);
    return narrow.primitives(a.placed(), b.placed(), {.margin = margin});
  }
  FormulaTable table;
  bool solids;
  int formula;
  NarrowPhase narrow;
};

Pose somewhere(Dice& dice) {
  return at(dice.in(-0.25, 0.25), dice.in(-0.25, 0.25), dice.in(-0.25, 0.25), dice.in(-3, 3), dice.in(-3, 3),
            dice.in(-3, 3));
}

/// Beside each other at random, unless they touch. Returns how often they do not.
int check_margins(const NamedShape& a, const NamedShape& b, int places, Dice& dice) {
  Narrow narrow(a, b);
  int beside = 0;
  for (int i = 0; i < places; ++i) {
    const Place place_a(a, somewhere(dice)), place_b(b, somewhere(dice));
    const double distance = NarrowPhase::distance(place_a.placed(), place_b.placed()).distance;
    if (distance <= 1e-5) continue;
    ++beside;
    for (double off : {1e-5, 1e-3, 0.02, 0.05, 0.3})
      BOOST_TEST(std::abs(narrow.distance(place_a, place_b, distance + off) - distance) < NarrowPhase::tolerance,
                 a.name << ' ' << b.name);
    const double below = distance - NarrowPhase::tolerance;
    BOOST_TEST(narrow.distance(place_a, place_b, below) == infinity, a.name << ' ' << b.name);
    BOOST_TEST(narrow.distance(place_a, place_b, 0.5 * below) == infinity, a.name << ' ' << b.name);
  }
  return beside;
}

std::size_t primitives_of(const NamedShape& body) {
  return body.bvh ? std::max(body.bvh->triangles().size(), body.bvh->cubes().size()) : 1;
}

/// Returns how often there were near primitives, but not too many. `a` has primitives.
int check_near_primitives(const NamedShape& a, const NamedShape& b, Dice& dice) {
  Narrow narrow(a, b);
  int listed = 0;
  for (int k = 0; k < 30; ++k) {
    const Pose pose = somewhere(dice);
    const Place place_a(a, somewhere(dice)), place_b(b, pose);
    const double distance = narrow.distance(place_a, place_b, 1.0), margin = distance + 0.004;
    if (distance <= 1e-5) continue;
    std::vector<PrimitivePair> near, alone;
    const double found =
        narrow.narrow.primitives(place_a.placed(), place_b.placed(), {.margin = margin, .candidates = &near});
    if (near.empty()) continue;  // too many
    ++listed;
    BOOST_TEST(near.size() <= PrimitiveQuery::max_candidates);
    BOOST_TEST(std::abs(found - distance) < NarrowPhase::tolerance);
    // One by one, the same primitives are within the margin.
    for (std::uint32_t i = 0; i < primitives_of(a); ++i)
      for (std::uint32_t j = 0; j < primitives_of(b); ++j) {
        const PrimitivePair pair{i, j};
        const double own = narrow.narrow.primitives(place_a.placed(), place_b.placed(),
                                                    {.margin = margin + 1e-4, .among = std::span(&pair, 1)});
        const bool is_near = std::ranges::any_of(near, [&](auto& other) { return other.a == i && other.b == j; });
        if (std::abs(own - margin) > NarrowPhase::tolerance) BOOST_TEST(is_near == (own < margin));
      }
    // Moved by less than what the margin leaves, they are all that matter.
    Pose moved_pose = pose;
    moved_pose.p += Eigen::Vector3d(0.001, 0.0, -0.001);
    const Place moved(b, moved_pose);
    const double after = narrow.distance(place_a, moved, margin - 0.0015);
    alone = near;
    const double among = narrow.narrow.primitives(place_a.placed(), moved.placed(),
                                                  {.margin = margin - 0.0015, .among = alone, .candidates = &near});
    BOOST_TEST((among == after || std::abs(among - after) < NarrowPhase::tolerance));
    BOOST_TEST(near.size() <= alone.size());
  }
  return listed;
}

}  // namespace

BOOST_AUTO_TEST_CASE(near_primitives_are_all_that_matter_nearby) {
  const std::vector<NamedShape> all = bodies_and_large_ones();
  Dice dice(17);
  int listed = 0;
  for (const NamedShape& other : all) listed += check_near_primitives(all.front(), other, dice);
  BOOST_TEST(listed > 100);
}

BOOST_AUTO_TEST_CASE(where_many_primitives_are_near_none_are_candidates) {
  const NamedShape body = body_of("dented", make_geometry(dented(), "dented"));
  Narrow narrow(body, body);
  const Place place(body, Pose{}), beside(body, at(2.0 * body.bounds.radius + 0.01, 0, 0, 0, 0, 0));
  const double distance = narrow.distance(place, beside, 1.0);
  std::vector<PrimitivePair> candidates{{7, 7}};
  const auto query = [&](double margin, double enough) {
    return narrow.narrow.primitives(place.placed(), beside.placed(),
                                    {.margin = margin, .enough = enough, .candidates = &candidates});
  };
  BOOST_TEST(query(distance - 1e-5, 0.0) == infinity);
  BOOST_TEST(candidates.empty());
  BOOST_TEST(query(distance + 1e-5, 0.0) < infinity);
  BOOST_TEST(!candidates.empty());
  BOOST_TEST(std::abs(query(1.0, 0.0) - distance) < NarrowPhase::tolerance);
  BOOST_TEST(candidates.empty());  // all are near
  const double any = query(1.0, 1.0);
  BOOST_TEST((any > distance - NarrowPhase::tolerance && any < 1.0));
  BOOST_TEST(candidates.empty());
}

BOOST_AUTO_TEST_CASE(margins_hold_where_many_primitives_are_near) {
  const std::vector<NamedShape> all = bodies_and_large_ones();
  Dice dice(7);
  int beside = 0;
  for (const NamedShape& other : all) beside += check_margins(all.front(), other, 100, dice);
  BOOST_TEST(beside > 300);
}

BOOST_AUTO_TEST_CASE(margins_hold_for_every_pair_of_kinds) {
  const std::vector<NamedShape> all = bodies();
  Dice dice(1);
  for (const NamedShape& a : all)
    for (const NamedShape& b : all) check_margins(a, b, 40, dice);
}

BOOST_AUTO_TEST_CASE(what_overlaps_is_within_any_margin) {
  const std::vector<NamedShape> all = bodies();
  Dice dice(4);
  const auto on_a_grid = [&] {  // aligned and symmetric places are where GJK stops just short of 0
    const auto step = [&] { return 0.02 * (static_cast<double>(dice.below(5)) - 2.0); };
    const auto turn = [&] { return M_PI / 2 * static_cast<double>(dice.below(4)); };
    return at(step(), step(), step(), turn(), turn(), turn());
  };
  for (const NamedShape& a : all)
    for (const NamedShape& b : all) {
      Narrow narrow(a, b);
      for (int i = 0; i < 60; ++i) {
        const Place place_a(a, on_a_grid()), place_b(b, on_a_grid());
        if (NarrowPhase::deepest(place_a.placed(), place_b.placed(), 0.0).distance > -1e-4) continue;
        for (double margin : {0.0, 1e-5, 0.02})
          BOOST_TEST(narrow.distance(place_a, place_b, margin) <= NarrowPhase::contact_distance,
                     a.name << ' ' << b.name << ' ' << margin);
      }
    }
}

BOOST_AUTO_TEST_CASE(a_cloud_is_its_voxels) {
  const PointCloud cloud{{{0.01, 0.01, 0.01}, {0.05, -0.03, 0.09}, {-0.07, 0.03, 0.01}}, 0.02};
  const Geometry geometry = make_geometry(cloud, "cloud"), box = make_geometry(Box{{0.02, 0.02, 0.02}}, "voxel");
  const NamedShape body = body_of("cloud", geometry), voxel = body_of("voxel", box);
  const auto all = bodies();
  Dice dice(2);
  for (int i = 0; i < 200; ++i) {
    const NamedShape& other_body = all[dice.below(all.size() - 1)];
    const Pose pose = somewhere(dice);
    const Place place(body, pose), other(other_body, somewhere(dice));
    double nearest = 1e9;
    for (const Eigen::Vector3d& p : cloud.points)  // every point is the middle of its voxel
      nearest = std::min(
          nearest,
          NarrowPhase::distance(Place(voxel, pose * at(p.x(), p.y(), p.z())).placed(), other.placed()).distance);
    const double distance = NarrowPhase::distance(place.placed(), other.placed()).distance;
    if (nearest > 0) BOOST_TEST(std::abs(distance - nearest) < 3e-6, other_body.name);
    BOOST_TEST((distance <= 0) == (nearest <= 0), other_body.name);
  }
}

BOOST_AUTO_TEST_CASE(hulls_and_spheres_and_boxes_are_outside) {
  const Mesh mesh = angle_iron();
  const Geometry geometry = make_geometry(mesh, "mesh"), hull = outer_hull(geometry);
  BOOST_TEST(hull != geometry);
  BOOST_TEST(is_convex_solid(*hull));
  BOOST_TEST(!is_convex_solid(*geometry));
  const Bounds bounds = bounds_of(*geometry);
  for (const Eigen::Vector3d& v : mesh.vertices) {
    BOOST_TEST((v - bounds.center).norm() <= bounds.radius + 1e-12);
    BOOST_TEST(((v - bounds.box_center).cwiseAbs() - bounds.box_half).maxCoeff() <= 1e-12);
  }
  const Geometry sphere = make_geometry(Sphere{0.1}, "sphere"),
                 flat = make_geometry(Mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}}, false},
                                      "flat");
  BOOST_TEST(bounds_of(*sphere).radius == 0.1);
  BOOST_TEST(outer_hull(sphere) == sphere);
  BOOST_TEST(outer_hull(flat) == flat);
}

BOOST_AUTO_TEST_CASE(a_query_does_not_remember_the_one_before) {
  const std::vector<NamedShape> all = bodies_and_large_ones();
  Dice dice(3);
  for (const NamedShape& a : all)
    for (const NamedShape& b : all) {
      Narrow used(a, b);
      for (int i = 0; i < 15; ++i) {
        const Place place_a(a, somewhere(dice)), place_b(b, somewhere(dice));
        Narrow fresh(a, b);
        const double one = used.distance(place_a, place_b, 0.1), other = fresh.distance(place_a, place_b, 0.1);
        BOOST_TEST(one == other, a.name << ' ' << b.name);  // to the last bit
      }
    }
}

/// Coal remembers for the whole process what its first question about a box was (see ask_for_first_support): another
/// one here, which is asked later than the library's, must have no effect.
BOOST_AUTO_TEST_CASE(distances_of_boxes_do_not_depend_on_what_the_process_asked_before) {
  const coal::Box box(2.0, 3.0, 4.0);
  int hint = 0;
  coal::details::getSupport(&box, Eigen::Vector3d::UnitX(), hint);
  const Eigen::Vector3d corner = coal::details::getSupport(&box, -Eigen::Vector3d::Ones(), hint);
  BOOST_TEST((corner == Eigen::Vector3d(-1.0, -1.5, -2.0)));
}
