#include "srmp/lattice/state_table.hpp"

#include <array>
#include <boost/test/unit_test.hpp>
#include <map>
#include <random>

using srmp::StateTable;

BOOST_AUTO_TEST_CASE(states_are_numbered_in_the_order_of_their_first_insertion) {
  using Key = std::array<std::int32_t, 3>;
  std::mt19937 random(0);
  StateTable table(3);
  std::map<Key, srmp::search::StateId> model;
  for (int i = 0; i < 300'000; ++i) {
    const std::uint32_t range = i < 1000 ? 4 : 60;  // few different keys, then many
    const auto entry = [&] {
      return static_cast<std::int32_t>(random() % range) - static_cast<std::int32_t>(range) / 2;
    };
    const Key key{entry(), entry(), entry()};
    const auto [known, is_new] = model.try_emplace(key, static_cast<srmp::search::StateId>(model.size()));
    BOOST_REQUIRE_EQUAL(table.insert(key), known->second);
    BOOST_REQUIRE_EQUAL(table.size(), model.size());
  }
  for (const auto& [key, id] : model) {
    const auto stored = table.key(id);
    BOOST_REQUIRE_EQUAL_COLLECTIONS(stored.begin(), stored.end(), key.begin(), key.end());
    BOOST_REQUIRE_EQUAL(table.insert(key), id);
  }
}
