#include "srmp/search/open_list.hpp"

#include <boost/test/unit_test.hpp>
#include <map>
#include <random>
#include <tuple>

using namespace srmp::search;

namespace {

using Key = std::tuple<double, double, std::uint64_t>;

/// A slow reference implementation of OPEN.
struct Model {
  std::map<StateId, Key> keys;
  std::uint64_t next{};

  void set(StateId s, double priority, double heuristic) {
    const auto found = keys.find(s);
    if (found != keys.end() && std::get<0>(found->second) == priority && std::get<1>(found->second) == heuristic)
      return;
    keys[s] = {priority, heuristic, next++};
  }
  StateId first() const {
    const auto less = [](const auto& a, const auto& b) { return a.second < b.second; };
    return std::min_element(keys.begin(), keys.end(), less)->first;
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(open_list_breaks_ties_by_heuristic_then_insertion) {
  OpenList open;
  open.set(3, 1.0, 0.5);
  open.set(1, 1.0, 0.5);
  open.set(2, 1.0, 0.25);
  open.set(0, 2.0, 0.0);
  for (const StateId expected : {2u, 3u, 1u, 0u}) BOOST_TEST(open.pop().state == expected);
  BOOST_TEST(open.empty());
  BOOST_TEST(open.min_priority() == infinity);
}

BOOST_AUTO_TEST_CASE(open_list_keeps_the_number_of_an_unchanged_or_restored_key) {
  OpenList open;
  for (const StateId s : {4u, 5u, 6u}) open.set(s, 1.0, 1.0);
  open.set(4, 1.0, 1.0);
  BOOST_TEST(open.top().state == 4u);
  const OpenList::Entry entry = open.pop();
  open.restore(entry);
  BOOST_TEST(open.top().state == 4u);
  open.set(4, 2.0, 1.0);
  open.set(4, 1.0, 1.0);  // changed and changed back: now the last inserted
  for (const StateId expected : {5u, 6u, 4u}) BOOST_TEST(open.pop().state == expected);
}

BOOST_AUTO_TEST_CASE(open_list_agrees_with_a_sorted_map) {
  std::mt19937 random(7);
  const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
  OpenList open;
  Model model;
  for (int step = 0; step < 20000; ++step) {
    const StateId s = below(60);
    switch (below(step % 4000 < 2000 ? 5 : 3)) {  // grows for a while, then shrinks
      case 0:
        if (!model.keys.empty()) {
          BOOST_REQUIRE(open.top().state == model.first());
          model.keys.erase(open.pop().state);
        }
        break;
      case 1:
        open.erase(s);
        model.keys.erase(s);
        break;
      default: {
        const double priority = below(8), heuristic = below(3);
        open.set(s, priority, heuristic);
        model.set(s, priority, heuristic);
      }
    }
    BOOST_REQUIRE(open.size() == model.keys.size());
    BOOST_REQUIRE(open.contains(s) == model.keys.contains(s));
  }
  open.reprioritise([](const OpenList::Entry& entry) { return entry.heuristic; });
  for (auto& [s, key] : model.keys) std::get<0>(key) = std::get<1>(key);
  while (!open.empty()) {
    BOOST_REQUIRE(open.top().state == model.first());
    model.keys.erase(open.pop().state);
  }
  open.set(1, 0.0, 0.0);
  open.clear();
  BOOST_TEST(!open.contains(1));
  BOOST_TEST(open.empty());
}
