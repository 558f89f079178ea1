#include "srmp/core/block_vector.hpp"

#include <boost/test/unit_test.hpp>
#include <random>
#include <string>
#include <vector>

using srmp::BlockVector;

BOOST_AUTO_TEST_CASE(block_vector_does_what_a_vector_does) {
  std::mt19937 random(0);
  BlockVector<std::string> blocks;
  std::vector<std::string> vector;
  for (int i = 0; i < 100'000; ++i) {
    if (random() % 3 != 0 || vector.empty()) {
      const std::string value = std::to_string(random());
      blocks.push_back(value);
      vector.push_back(value);
    } else {
      blocks.pop_back();
      vector.pop_back();
    }
    if (random() % 30'000 == 0) {
      blocks.clear();
      vector.clear();
    }
    if (random() % 10'000 == 0) {
      blocks.grow_to(vector.size() + 5'000, "grown");
      vector.resize(vector.size() + 5'000, "grown");
      blocks.grow_to(3, "is large enough already");
    }
    BOOST_REQUIRE_EQUAL(blocks.size(), vector.size());
    BOOST_REQUIRE_EQUAL(blocks.empty(), vector.empty());
    if (vector.empty()) continue;
    const std::size_t at = random() % vector.size();
    BOOST_REQUIRE_EQUAL(blocks[at], vector[at]);
    BOOST_REQUIRE_EQUAL(blocks.front(), vector.front());
    BOOST_REQUIRE_EQUAL(blocks.back(), vector.back());
  }
  std::vector<std::string> visited;
  blocks.for_each([&](const std::string& value) { visited.push_back(value); });
  BOOST_TEST(visited == vector);
}

BOOST_AUTO_TEST_CASE(block_vector_leaves_full_blocks_where_they_are) {
  BlockVector<int> blocks;
  blocks.grow_to(BlockVector<int>::block_size, 7);
  const int* const first = &blocks[0];
  for (std::size_t i = 0; i < 1'000'000; ++i) blocks.push_back(static_cast<int>(i));
  BOOST_TEST(&blocks[0] == first);
  BOOST_TEST(blocks.memory() >= 4'000'000);
  BOOST_TEST(blocks.memory() < 5'000'000);
}

BOOST_AUTO_TEST_CASE(short_block_vectors_are_small) {
  BlockVector<int> blocks;
  BOOST_TEST(blocks.memory() == 0);
  blocks.push_back(1);
  BOOST_TEST(blocks.memory() <= 4 * sizeof(int));
}
