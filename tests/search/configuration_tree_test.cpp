#include "srmp/search/configuration_tree.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "srmp/core/error.hpp"
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

BOOST_AUTO_TEST_CASE(the_first_of_those_that_are_nearest_is_found_at_every_size) {
  srmp::search::RandomSequence random(11);
  const auto draw = [&]() -> Eigen::VectorXd {  // few values, so that many are equally near, and none near 0
    const double x = 2.0 + std::floor(3.0 * random.next()), turns = std::floor(7.0 * random.next()) - 3.0;
    return Vector2d(x, 2.0 * std::numbers::pi * turns + (random.next() < 0.5 ? 2.0 : -2.0));
  };
  for (const char wraps : {0, 1}) {
    ConfigurationTree tree({0, wraps});
    for (std::size_t size = 1; size <= 40; ++size) {
      const Eigen::VectorXd newest = draw();
      size == 1 ? tree.add_root(newest) : tree.add(newest, 0);
      for (const Eigen::VectorXd& q : {Eigen::VectorXd(Vector2d(0.0, 0.0)), draw()}) {
        const std::size_t found = tree.nearest(q);
        for (std::size_t i = 0; i < size; ++i) {
          const double margin = tree.distance(q, tree[i]) - tree.distance(q, tree[found]);
          BOOST_TEST(margin > -1e-12);
          if (i < found && tree[i] == tree[found]) BOOST_ERROR("an equal one comes before");
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(all_instruction_sets_find_the_same_nearest_configuration) {
  using namespace srmp::search;
  RandomSequence random(13);
  const auto draw = [&](double size) { return size * (2.0 * random.next() - 1.0); };
  for (std::size_t components = 1; components <= 14; ++components)
    for (const std::size_t count : {1, 2, 7}) {
      std::vector<ComponentBlock> blocks(count * components);
      std::vector<char> wraps(components);
      std::vector<double> q(components);
      for (char& w : wraps) w = random.next() < 0.5;
      for (ComponentBlock& block : blocks)
        for (double& value : block.values) value = std::round(draw(8.0));  // many are equally near
      for (int trial = 0; trial < 20; ++trial) {
        for (double& value : q) value = trial % 2 ? draw(8.0) : std::round(draw(8.0));
        if (trial == 19) q[0] = std::nan("");
        for (const char* wrapping : {static_cast<const char*>(nullptr), std::as_const(wraps).data()}) {
          const ConfigurationBlocks configurations{blocks.data(), count, components, wrapping};
          const std::size_t found = nearest_portable(configurations, q.data());
          BOOST_TEST(found < count * ComponentBlock::size);
          if (trial == 19) BOOST_TEST(found == 0u);
          for (const srmp::SimdBackend backend : srmp::available_simd_backends())
            BOOST_TEST(nearest_function(backend)(configurations, q.data()) == found);
        }
      }
    }
}

BOOST_AUTO_TEST_CASE(a_configuration_of_another_size_is_refused) {
  ConfigurationTree tree;
  tree.add_root(Vector2d(0, 0));
  BOOST_CHECK_THROW(tree.add_root(Vector3d(0, 0, 0)), srmp::InvalidArgument);
  BOOST_TEST(tree.size() == 1u);
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
