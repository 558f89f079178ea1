#include "srmp/multi/timed_search.hpp"

#include "multi/grids.hpp"
#include "srmp/core/error.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::multi;
using namespace srmp::multi::test;

namespace {

constexpr std::size_t me = 0;

/// Everybody's way alone, and how the world's first agent gets along with the others' ways and its own constraints.
struct Scene {
  explicit Scene(unsigned seed) : world(random_world(seed)) {
    for (std::size_t i = 0; i < world->size(); ++i) {
      TimedSearchResult alone = timed_search(*world, i, {}, {}, {}, nullptr, {}, Deadline());
      if (alone.status != Status::solved) return;
      ways.push_back(std::move(alone.path));
    }
    for (std::size_t i = 1; i < ways.size(); ++i) others.push_back({i, &ways[i]});
  }

  bool solvable_alone() const { return ways.size() == world->size(); }

  TimedSearchResult search(const TimedSearchOptions& options, const TimedPath* experience = nullptr) {
    return timed_search(*world, me, constraints, avoid, others, experience, options, Deadline());
  }

  bool may_make(const Move& move) {
    for (const Constraint& constraint : constraints)
      if (world->forbids(constraint, move)) return false;
    for (int step = move.start; step < move.end; ++step)
      for (const OtherPath& other : avoid)
        if (world->clash(me, {move.from, move.to}, other.agent, place_at(*other.path, step))) return false;
    return true;
  }

  /// Cheapest way, step by step over all states; infinity: there is none.
  double optimum() {
    constexpr int end = 60;  // all others have long arrived, and whoever has a way has got there
    TestAgent& agent = world->agents[me];
    const std::size_t states = agent.problem.h.size();
    std::vector<std::vector<double>> cost(end + 4, std::vector<double>(states, infinity));
    cost[0][agent.start()] = 0.0;
    double best = infinity;
    for (int step = 0; step < end; ++step) {
      const auto now = static_cast<std::size_t>(step);
      for (StateId s = 0; s < states; ++s) {
        if (cost[now][s] == infinity) continue;
        bool rests = agent.is_goal(s);
        for (int t = step; rests && t < end; ++t) rests = may_make({s, s, t, t + 1});
        if (rests) best = std::min(best, cost[now][s]);
        const auto go = [&](StateId to, int duration, double more) {
          double& there = cost[now + static_cast<std::size_t>(duration)][to];
          if (may_make({s, to, step, step + duration})) there = std::min(there, cost[now][s] + more);
        };
        go(s, 1, agent.wait);
        for (const auto& arc : agent.problem.graph.arcs[s]) go(arc.to, agent.duration(s, arc.to), arc.cost);
      }
    }
    return best;
  }

  std::unique_ptr<TestWorld> world;
  std::vector<TimedPath> ways;
  std::vector<OtherPath> others, avoid;
  std::vector<Constraint> constraints;
};

const std::vector<TimedSearchOptions> all_options{
    {},
    {.bound = 1.5, .focal = 1.5},
    {.bound = 2.0, .low_level_weight = 2.0},
    {.bound = 4.5, .low_level_weight = 3.0, .focal = 1.5},
    {.bound = 1.2, .low_level_weight = 10.0, .focal = 10.0},
    {.bound = infinity, .low_level_weight = 5.0, .focal = 5.0},
};

void check_way(Scene& scene, const TimedSearchResult& result, double bound, double optimum) {
  if (optimum == infinity) {
    BOOST_REQUIRE(result.status == Status::exhausted);
    return;
  }
  BOOST_REQUIRE(result.status == Status::solved);
  BOOST_REQUIRE_GE(result.path.cost, optimum * (1.0 - 1e-12));
  BOOST_REQUIRE_LE(result.lower, optimum * (1.0 + 1e-12));
  if (bound < infinity) BOOST_REQUIRE_LE(result.path.cost, bound * result.lower * (1.0 + 1e-12));
  for (const Move& move : result.path.moves) {
    const int end = move.end == forever ? move.start + 60 : move.end;
    for (int step = move.start; move.waits() && step < end; ++step)
      BOOST_REQUIRE(scene.may_make({move.from, move.to, step, step + 1}));
    BOOST_REQUIRE(move.waits() || scene.may_make(move));
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_way_around_others_costs_what_brute_force_says) {
  int solved = 0, exhausted = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      scene.avoid = scene.others;
      const double optimum = scene.optimum();
      ++(optimum < infinity ? solved : exhausted);
      for (const TimedSearchOptions& options : all_options) {
        check_way(scene, scene.search(options), options.bound, optimum);
        check_way(scene, scene.search(options, &scene.ways[me]), options.bound, optimum);
      }
    }
  }
  BOOST_TEST(solved > 150);
  BOOST_TEST(exhausted > 10);
}

BOOST_AUTO_TEST_CASE(constraints_one_after_another_are_kept_with_and_without_experience) {
  int most = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      const TimedSearchOptions& options = all_options[seed % all_options.size()];
      TimedPath last = scene.ways[me];
      for (int count = 0; count < 12; ++count) {  // whatever meets the first of the others that it meets is forbidden
        PathConflicts found;
        for (const OtherPath& other : scene.others)
          if (found.count == 0) found = conflicts_of(*scene.world, {me, &last}, other);
        if (found.count == 0) break;
        scene.constraints.push_back({found.first, 0});
        most = std::max(most, count + 1);
        const double optimum = scene.optimum();
        check_way(scene, scene.search(options), options.bound, optimum);
        const TimedSearchResult again = scene.search(options, &last);
        check_way(scene, again, options.bound, optimum);
        if (again.status != Status::solved) break;
        BOOST_REQUIRE(again.path.moves != last.moves);
        last = again.path;
      }
    }
  }
  BOOST_TEST(most == 12);
}

BOOST_AUTO_TEST_CASE(others_are_met_as_little_as_the_bound_allows) {
  GridWorld world = grid({"a..b", "...."}, {"b..a", "...."});
  const TimedPath straight = timed_search(world, 1, {}, {}, {}, nullptr, {}, Deadline()).path;
  const OtherPath other{1, &straight};
  const auto met = [&](const TimedSearchOptions& options) {
    const TimedSearchResult found = timed_search(world, 0, {}, {}, {&other, 1}, nullptr, options, Deadline());
    return std::pair(found.path.cost, conflicts_of(world, {0, &found.path}, other).count);
  };
  BOOST_TEST((met({}) == std::pair(3.0, 1)));
  BOOST_TEST((met({.bound = 1.7, .focal = 1.7}) == std::pair(5.0, 0)));
}

BOOST_AUTO_TEST_CASE(conflicts_of_finds_the_first_step_in_which_two_meet) {
  int met = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      for (const OtherPath& other : scene.others) {
        const TimedPath& mine = scene.ways[me];
        int first = -1;
        for (int step = 0; first < 0 && step <= std::max(mine.arrival(), other.path->arrival()); ++step)
          if (scene.world->clash(me, place_at(mine, step), other.agent, place_at(*other.path, step))) first = step;
        const PathConflicts found = conflicts_of(*scene.world, {me, &mine}, other);
        BOOST_REQUIRE_EQUAL(found.count > 0, first >= 0);
        if (first < 0) continue;
        ++met;
        BOOST_REQUIRE_EQUAL(found.first.step, first);
        BOOST_REQUIRE(scene.world->meet(me, found.first.moves[0], other.agent, found.first.moves[1]));
        for (const Move& move : found.first.moves) {
          BOOST_REQUIRE(move.start <= first && first < move.end);
          BOOST_REQUIRE(move.end < forever);
          if (move.waits()) BOOST_REQUIRE_EQUAL(move.end, move.start + 1);
        }
      }
    }
  }
  BOOST_TEST(met > 100);
}

BOOST_AUTO_TEST_CASE(a_search_stops_after_as_many_looks_as_allowed) {
  GridWorld world = grid({"a....", "....."}, {".....", "....a"});
  const auto search = [&](std::uint64_t most) {
    return timed_search(world, 0, {}, {}, {}, nullptr, {.max_evaluations = most}, Deadline());
  };
  const std::uint64_t needed = search(1000).statistics.evaluations;
  BOOST_TEST((search(needed).status == Status::solved));
  const TimedSearchResult less = search(needed - 1);
  BOOST_TEST((less.status == Status::timed_out));
  BOOST_TEST(less.lower == 5.0);
  BOOST_TEST(less.path.moves.empty());
}

BOOST_AUTO_TEST_CASE(a_start_without_a_goal_is_exhausted_whatever_is_known) {
  GridWorld world = grid({"a#."}, {".#a"});
  const TimedPath known{{{0, 0, 0, 1}, {0, 0, 1, forever}}, 1.0};
  const TimedSearchResult result = timed_search(world, 0, {}, {}, {}, &known, {}, Deadline());
  BOOST_TEST((result.status == Status::exhausted));
  BOOST_TEST(result.statistics.expansions == 0u);
}

BOOST_AUTO_TEST_CASE(bad_options_of_a_timed_search_are_refused) {
  GridWorld world = grid({"a."}, {".a"});
  const auto search = [&](const TimedSearchOptions& options) {
    timed_search(world, 0, {}, {}, {}, nullptr, options, Deadline());
  };
  for (const double bad : {std::nan(""), 0.99, -1.0}) {
    const std::string text = " is " + to_text(bad) + ", it must be";
    check_throws<InvalidArgument>([&] { search({.bound = bad}); }, "timed_search: bound" + text);
    check_throws<InvalidArgument>([&] { search({.low_level_weight = bad}); }, "timed_search: low_level_weight" + text);
    check_throws<InvalidArgument>([&] { search({.focal = bad}); }, "timed_search: focal" + text);
  }
  check_throws<InvalidArgument>([&] { search({.focal = infinity}); }, "timed_search: focal is inf");
}
