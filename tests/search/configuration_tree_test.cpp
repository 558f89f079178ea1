#include "srmp/search/configuration_tree.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "srmp/search/rrt_connect.hpp"

using Eigen::Vector2d;
using Eigen::Vector3d;
using srmp::search::ConfigurationTree;

BOOST_AUTO_TEST_CASE(the_nearest_configuration_is_that_of_a_comparison_one_by_one) {
  srmp::search::RandomSequence random(7);
  const auto draw = [&]() -> Eigen::VectorXd {
    const auto angle = [&] { return 8.0 * random.next() - 4.0; };
    const double x = angle(), y = angle(), z = angle();
    return Vector3d(x, y, z);
  };
  ConfigurationTree tree({0, 1, 0});
  tree.add_root(draw());
  for (std::size_t i = 1; i < 200; ++i) tree.add(draw(), i / 2);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::VectorXd q = draw();
    const std::size_t nearest = tree.nearest(q);
    for (std::size_t i = 0; i < tree.size(); ++i) {
      Eigen::VectorXd way = tree[i] - q;
      way[1] = std::remainder(way[1], 2.0 * std::numbers::pi);
      BOOST_TEST(std::abs(way.norm() - tree.distance(q, tree[i])) < 1e-12);
      BOOST_TEST(tree.distance(q, tree[nearest]) <= way.norm() + 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_first_of_those_that_are_nearest_is_found) {
  for (std::size_t size = 1; size < 30; ++size)
    for (std::size_t first = 0; first < size; ++first) {
      ConfigurationTree tree({0, 1});
      for (std::size_t i = 0; i < size; ++i)
        tree.add_root(Vector2d(i < first ? 1.0 : 0.0, 2.0 * std::numbers::pi * static_cast<double>(i % 3)));
      BOOST_TEST(tree.nearest(Vector2d(0.0, 0.0)) >= first);
      ConfigurationTree without_angles;
      for (std::size_t i = 0; i < size; ++i) without_angles.add_root(Vector2d(i < first ? 1.0 : 0.0, 0.0));
      BOOST_TEST(without_angles.nearest(Vector2d(0.0, 0.0)) == first);
    }
}

BOOST_AUTO_TEST_CASE(ways_lead_to_the_root_at_their_length) {
  ConfigurationTree tree;
  BOOST_TEST(tree.empty());
  const std::size_t a = tree.add_root(Vector2d(0, 0)), b = tree.add_root(Vector2d(5, 5));
  const std::size_t c = tree.add(Vector2d(3, 4), a), d = tree.add(Vector2d(3, 6), c);
  BOOST_TEST(tree.cost(a) == 0.0);
  BOOST_TEST(tree.cost(d) == 7.0);
  const auto way = tree.to_root(d);
  BOOST_REQUIRE_EQUAL(way.size(), 3u);
  BOOST_TEST((way[0] == Vector2d(3, 6)));
  BOOST_TEST((way[2] == Vector2d(0, 0)));
  BOOST_TEST(tree.to_root(b).size() == 1u);
  BOOST_TEST((tree.back() == Vector2d(3, 6)));
  BOOST_TEST(tree.nearest(Vector2d(4.9, 5)) == b);
}
