#include "srmp/geometry/distance_field.hpp"

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/collision/narrow_phase.hpp"
#include "srmp/scene/shape_geometry.hpp"

using namespace srmp;
using namespace worlds;
using Eigen::Vector3d;

BOOST_AUTO_TEST_CASE(a_distance_field_bounds_the_distance_from_below_and_above) {
  const auto sphere = make_geometry(Sphere{1e-7}, "point");
  const Pose here;
  Dice dice(1);
  for (const auto& [name, shape] : every_kind()) {
    const auto geometry = make_geometry(shape, name);
    const auto bvh = make_primitive_bvh(*geometry);
    const auto field = make_distance_field(*geometry, bvh.get());
    BOOST_TEST((field == nullptr) == (name == "box" || name == "sphere" || name == "cylinder" || name == "capsule"));
    if (!field) continue;
    double lost = 0;
    int far = 0;
    for (int i = 0; i < 3000; ++i) {
      const double side = i % 2 ? 0.15 : 0.5;
      const Vector3d point(dice.in(-side, side), dice.in(-side, side), dice.in(-side, side));
      const Pose there{point, Eigen::Quaterniond::Identity()};
      const detail::Bounds bounds = detail::bounds_of(*geometry), tiny = detail::bounds_of(*sphere);
      const Eigen::Isometry3d pose = here.isometry(), place = there.isometry();
      const double truth =
          std::max(0.0, detail::NarrowPhase::distance({geometry.get(), bvh.get(), bounds, pose, bounds.center},
                                                      {sphere.get(), nullptr, tiny, place, point})
                            .distance);
      const DistanceField::Bounds range = field->distance(point);
      BOOST_TEST(range.low <= truth + 3e-6, name);
      BOOST_TEST(range.high >= truth - 3e-6, name);
      if (truth < 0.05 || truth > 0.18) continue;
      lost += truth - range.low;
      ++far;
    }
    BOOST_TEST(far > 100);
    BOOST_TEST(lost / far < 0.025, name << " " << lost / far << " " << field->cell());
  }
}

BOOST_AUTO_TEST_CASE(primitives_of_a_point_cloud_are_its_distinct_cells) {
  const PrimitiveBvh tree({{0, 0, 0}, {5, -3, 2}, {0, 0, 0}, {-1, -1, -1}, {100, 0, 0}, {7, 7, 7}}, 0.5);
  BOOST_TEST(tree.cubes().size() == 5u);
  BOOST_TEST(tree.edge() == 0.5);
  std::vector<Vector3d> found(tree.cubes());
  for (const Vector3d& expected :
       {Vector3d(0.25, 0.25, 0.25), Vector3d(2.75, -1.25, 1.25), Vector3d(50.25, 0.25, 0.25)})
    BOOST_TEST((std::find(found.begin(), found.end(), expected) != found.end()));
}

BOOST_AUTO_TEST_CASE(every_box_of_a_bvh_contains_its_primitives) {
  Dice dice(2);
  Mesh mesh;
  std::vector<std::array<std::int32_t, 3>> cells;
  const auto index = [&] { return static_cast<std::int32_t>(dice.below(40)) - 20; };
  for (int i = 0; i < 500; ++i) {
    for (int k = 0; k < 3; ++k) mesh.vertices.emplace_back(dice.in(-1, 1), dice.in(-1, 1), dice.in(-1, 1));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    cells.push_back({index(), index(), index()});
  }
  const auto geometry = make_geometry(mesh, "mesh");
  for (const PrimitiveBvh& tree : {*make_primitive_bvh(*geometry), PrimitiveBvh(cells, 0.1)}) {
    std::vector<int> seen(tree.of_cubes() ? tree.cubes().size() : tree.triangles().size());
    // Calls visit(corner) for the corners of all primitives in a box.
    const std::function<void(PrimitiveBvh::BoxNumber, const std::function<void(const Vector3d&)>&)> corners =
        [&](PrimitiveBvh::BoxNumber box, const auto& visit) {
          const PrimitiveBvh::Part& part = tree.part(box);
          for (std::size_t k = part.first; k < part.first + part.size; ++k) {
            for (int c = 0; tree.of_cubes() && c < 8; ++c)
              visit(tree.cubes()[k] + 0.05 * Vector3d(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1));
            for (int c = 0; !tree.of_cubes() && c < 3; ++c) visit(tree.triangles()[k][static_cast<std::size_t>(c)]);
          }
          for (int i = 0; !part.has_primitives() && i < tree.nodes()[part.first].size; ++i)
            corners(RoundedBoxes::count * part.first + static_cast<std::uint32_t>(i), visit);
        };
    for (std::uint32_t node = 0; node < tree.nodes().size(); ++node)
      for (int i = 0; i < tree.nodes()[node].size; ++i) {
        const auto number = RoundedBoxes::count * node + static_cast<std::uint32_t>(i);
        const PrimitiveBvh::Part& part = tree.part(number);
        for (std::size_t k = part.first; k < part.first + part.size; ++k) ++seen[k];
        const RoundedBox box = tree.box(number);
        double outside = 0;
        corners(number, [&](const Vector3d& corner) {
          const Vector3d local = box.axes3d().transpose() * (corner - box.center3d());
          outside = std::max(outside, (local.cwiseAbs() - box.half_extents3d()).maxCoeff());
        });
        BOOST_TEST(outside <= 0.0);
      }
    BOOST_TEST((std::count(seen.begin(), seen.end(), 1) == static_cast<std::ptrdiff_t>(seen.size())));
  }
}
