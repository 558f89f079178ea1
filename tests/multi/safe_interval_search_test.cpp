#include "srmp/multi/safe_interval_search.hpp"

#include "multi/grids.hpp"
#include "srmp/core/error.hpp"
#include "srmp/multi/conflict_search.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::multi;
using namespace srmp::multi::test;

namespace {

constexpr std::size_t me = 0;

/// The first agent among the others, which take their paths as if they were alone.
struct Scene {
  explicit Scene(unsigned seed) : world(random_world(seed)) {
    for (std::size_t i = 0; i < world->size(); ++i) {
      TimedSearchResult found = timed_search(*world, i, {}, {}, {}, nullptr, {}, Deadline());
      if (found.status == Status::solved) paths.push_back(std::move(found.path));
    }
    for (std::size_t i = 1; i < paths.size(); ++i) avoid.push_back({i, &paths[i]});
  }

  bool solvable_alone() const { return paths.size() == world->size(); }
  TimedSearchResult search(const SafeIntervalSearchOptions& options, const TimedPath* known = nullptr) {
    return safe_interval_search(*world, me, constraints, avoid, known, options, Deadline());
  }

  /// Step by step: it begins at the start, makes moves that exist and are allowed, and stays at a goal.
  void check(const TimedPath& path) {
    TestAgent& agent = world->agents[me];
    StateId at = agent.start();
    int step = 0;
    double cost = 0.0;
    for (const Move& move : path.moves) {
      BOOST_REQUIRE_EQUAL(move.from, at);
      BOOST_REQUIRE_EQUAL(move.start, step);
      for (const Constraint& constraint : constraints) BOOST_TEST(!forbids(*world, constraint, me, move));
      if (move.end == forever) break;
      BOOST_REQUIRE_EQUAL(move.end - move.start, move.waits() ? 1 : agent.duration(move.from, move.to));
      cost += move.waits() ? agent.wait : agent.evaluate(move.from, move.to);
      at = move.to;
      step = move.end;
    }
    BOOST_TEST(path.moves.back().end == forever);
    BOOST_TEST(agent.is_goal(at));
    BOOST_TEST(path.cost == cost);
    for (const OtherPath& other : avoid) BOOST_TEST(conflicts_of(*world, {me, &path}, other).count == 0);
  }

  std::unique_ptr<TestWorld> world;
  std::vector<TimedPath> paths;
  std::vector<OtherPath> avoid;
  std::vector<Constraint> constraints;
};

}  // namespace

BOOST_AUTO_TEST_SUITE(safe_intervals)

BOOST_AUTO_TEST_CASE(paths_are_free_of_conflicts_and_are_found_where_there_are_any) {
  int solvable = 0, solved = 0, expansions = 0, timed_expansions = 0;
  for (unsigned seed = 0; seed < 600; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      const TimedSearchResult best =
          timed_search(*scene.world, me, {}, scene.avoid, {}, nullptr, {.max_evaluations = 20'000}, Deadline());
      for (const SafeIntervalSearchOptions& options :
           {SafeIntervalSearchOptions{}, SafeIntervalSearchOptions{.weight = 1.0, .patient_weight = 1.0}}) {
        const TimedSearchResult found = scene.search(options, &scene.paths[me]);
        solvable += best.status == Status::solved;
        if (found.status != Status::solved) continue;
        scene.check(found.path);
        BOOST_REQUIRE(best.status == Status::solved);
        BOOST_TEST(found.path.cost >= best.path.cost - 1e-9);
        ++solved;
        expansions += static_cast<int>(found.statistics.expansions);
        timed_expansions += static_cast<int>(best.statistics.expansions);
      }
    }
  }
  BOOST_TEST(solvable > 500);
  BOOST_TEST(solved > solvable * 95 / 100);
  BOOST_TEST(expansions < timed_expansions);
}

BOOST_AUTO_TEST_CASE(constraints_are_obeyed) {
  int solved = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone() || scene.paths.size() < 2) continue;
      for (const Move& move : scene.paths[me].moves)  // none of its first moves
        if (scene.constraints.size() < 3 && move.end != forever) scene.constraints.push_back({me, move, false});
      if (const Move& move = scene.paths[1].moves.front(); seed % 2 == 0 && move.end != forever)
        scene.constraints.push_back({1, move, true});  // nor any that conflicts with the second agent's
      const TimedSearchResult found = scene.search({});
      if (found.status != Status::solved) continue;
      scene.check(found.path);
      ++solved;
    }
  }
  BOOST_TEST(solved > 100);
}

BOOST_AUTO_TEST_CASE(known_paths_alone_are_not_left) {
  GridWorld free_row = grid({"a..b"}, {"b..a"});  // they would have to pass each other
  TimedSearchResult other = timed_search(free_row, 1, {}, {}, {}, nullptr, {}, Deadline());
  TimedSearchResult alone = timed_search(free_row, 0, {}, {}, {}, nullptr, {}, Deadline());
  const std::vector<OtherPath> avoid{{1, &other.path}};
  const auto search = [&](World& world, const std::vector<OtherPath>& others, bool known_only) {
    return safe_interval_search(world, 0, {}, others, &alone.path, {.known_paths_only = known_only}, Deadline());
  };
  BOOST_TEST((search(free_row, avoid, true).status == Status::exhausted));
  BOOST_TEST((search(free_row, {}, true).status == Status::solved));
}

BOOST_AUTO_TEST_CASE(options_out_of_range_are_refused_by_name) {
  Scene scene(0);
  check_throws<InvalidArgument>([&] { scene.search({.weight = 0.5}); }, "safe_interval_search: weight is 0.5");
  check_throws<InvalidArgument>([&] { scene.search({.patient_weight = 0.5}); }, "patient_weight is 0.5");
}

BOOST_AUTO_TEST_SUITE_END()
