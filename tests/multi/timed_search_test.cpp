#include "srmp/multi/timed_search.hpp"

#include "multi/grids.hpp"
#include "srmp/core/error.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace srmp::multi;
using namespace srmp::multi::test;

namespace {

constexpr std::size_t me = 0;

/// Every agent's single-agent path, and searches of the first agent among the others' paths under constraints.
struct Scene {
  explicit Scene(unsigned seed) : world(random_world(seed)) {
    for (std::size_t i = 0; i < world->size(); ++i) {
      TimedSearchResult found = timed_search(*world, i, {}, {}, {}, nullptr, {}, Deadline());
      if (found.status != Status::solved) return;
      paths.push_back(std::move(found.path));
    }
    for (std::size_t i = 1; i < paths.size(); ++i) others.push_back({i, &paths[i]});
  }

  bool solvable_alone() const { return paths.size() == world->size(); }

  TimedSearchResult search(const TimedSearchOptions& options, const TimedPath* experience = nullptr) {
    return timed_search(*world, me, constraints, avoid, others, experience, options, Deadline());
  }

  bool may_make(const Move& move) {
    for (const Constraint& constraint : constraints)
      if (forbids(*world, constraint, me, move)) return false;
    for (int step = move.start; step < move.end; ++step)
      for (const OtherPath& other : avoid)
        if (world->collide(me, {move.from, move.to}, other.agent, place_at(*other.path, step))) return false;
    return true;
  }

  /// The cost of the cheapest path, step by step over all states; infinity: there is none.
  double optimum() {
    constexpr int end = 60;  // later than all others arrive, and than any optimal path ends
    TestAgent& agent = world->agents[me];
    const std::size_t states = agent.problem.h.size();
    std::vector<std::vector<double>> cost(end + 4, std::vector<double>(states, infinity));
    cost[0][agent.start()] = 0.0;
    double best = infinity;
    for (int step = 0; step < end; ++step) {
      const auto now = static_cast<std::size_t>(step);
      for (StateId s = 0; s < states; ++s) {
        if (cost[now][s] == infinity) continue;
        bool stays = agent.is_goal(s);
        for (int t = step; stays && t < end; ++t) stays = may_make({s, s, t, t + 1});
        if (stays) best = std::min(best, cost[now][s]);
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
  std::vector<TimedPath> paths;
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

void check_path(Scene& scene, const TimedSearchResult& result, double bound, double optimum) {
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

BOOST_AUTO_TEST_CASE(a_path_among_others_costs_what_brute_force_says) {
  int solved = 0, exhausted = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      scene.avoid = scene.others;
      const double optimum = scene.optimum();
      ++(optimum < infinity ? solved : exhausted);
      for (const TimedSearchOptions& options : all_options) {
        check_path(scene, scene.search(options), options.bound, optimum);
        check_path(scene, scene.search(options, &scene.paths[me]), options.bound, optimum);
      }
    }
  }
  BOOST_TEST(solved > 150);
  BOOST_TEST(exhausted > 10);
}

BOOST_AUTO_TEST_CASE(constraints_are_kept_with_and_without_experience) {
  int max_count = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      const TimedSearchOptions& options = all_options[seed % all_options.size()];
      TimedPath last = scene.paths[me];
      for (int count = 0; count < 12; ++count) {  // the first conflict with any of the others is forbidden
        PathConflicts found;
        for (const OtherPath& other : scene.others)
          if (found.count == 0) found = conflicts_of(*scene.world, {me, &last}, other);
        if (found.count == 0) break;
        const std::size_t kind = mixed({seed, static_cast<std::uint64_t>(count)}) % 3;
        const Move& own = last.moves[count % last.moves.size()];
        if (kind == 0 && own != found.first.moves[0] && own.end != forever)
          scene.constraints.push_back({me, own, true});
        if (kind == 1)
          scene.constraints.push_back({found.first.agents[1], found.first.moves[1], true});
        else
          scene.constraints.push_back({me, found.first.moves[0], false});
        max_count = std::max(max_count, count + 1);
        const double optimum = scene.optimum();
        check_path(scene, scene.search(options), options.bound, optimum);
        const TimedSearchResult again = scene.search(options, &last);
        check_path(scene, again, options.bound, optimum);
        if (again.status != Status::solved) break;
        BOOST_REQUIRE(again.path.moves != last.moves);
        last = again.path;
      }
    }
  }
  BOOST_TEST(max_count == 12);
}

BOOST_AUTO_TEST_CASE(a_constraint_splits_the_solutions_in_two) {
  GridWorld world = grid({"a.b", "..."}, {"b.a", "..."});
  const Move right{0, 1, 0, 1}, wait{0, 0, 0, 1}, later{0, 1, 1, 2}, there{2, 1, 0, 1}, down{2, 5, 0, 1};
  const Constraint never{0, right, false}, always{0, right, true};
  for (const Move& move : {right, wait}) BOOST_TEST(forbids(world, never, 0, move) != forbids(world, always, 0, move));
  BOOST_TEST(forbids(world, never, 0, right));
  for (const Constraint& constraint : {never, always}) {
    BOOST_TEST(!forbids(world, constraint, 0, later));  // it has ended
    BOOST_TEST(!forbids(world, constraint, 1, down));
    BOOST_TEST(forbids(world, constraint, 1, there) == constraint.required);
  }
}

BOOST_AUTO_TEST_CASE(conflicts_with_others_are_as_few_as_the_bound_allows) {
  GridWorld world = grid({"a..b", "...."}, {"b..a", "...."});
  const TimedPath straight = timed_search(world, 1, {}, {}, {}, nullptr, {}, Deadline()).path;
  const OtherPath other{1, &straight};
  const auto conflicts = [&](const TimedSearchOptions& options) {
    const TimedSearchResult found = timed_search(world, 0, {}, {}, {&other, 1}, nullptr, options, Deadline());
    return std::pair(found.path.cost, conflicts_of(world, {0, &found.path}, other).count);
  };
  BOOST_TEST((conflicts({}) == std::pair(3.0, 1)));
  BOOST_TEST((conflicts({.bound = 1.7, .focal = 1.7}) == std::pair(5.0, 0)));
}

BOOST_AUTO_TEST_CASE(conflicts_of_finds_the_first_step_in_which_two_collide) {
  int conflicts = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    BOOST_TEST_CONTEXT("seed " << seed) {
      Scene scene(seed);
      if (!scene.solvable_alone()) continue;
      for (const OtherPath& other : scene.others) {
        const TimedPath& mine = scene.paths[me];
        int first = -1;
        for (int step = 0; first < 0 && step <= std::max(mine.arrival(), other.path->arrival()); ++step)
          if (scene.world->collide(me, place_at(mine, step), other.agent, place_at(*other.path, step))) first = step;
        const PathConflicts found = conflicts_of(*scene.world, {me, &mine}, other);
        BOOST_REQUIRE_EQUAL(found.count > 0, first >= 0);
        if (first < 0) continue;
        ++conflicts;
        BOOST_REQUIRE_EQUAL(found.first.step, first);
        BOOST_REQUIRE(scene.world->in_conflict(me, found.first.moves[0], other.agent, found.first.moves[1]));
        for (const Move& move : found.first.moves) {
          BOOST_REQUIRE(move.start <= first && first < move.end);
          BOOST_REQUIRE(move.end < forever);
          if (move.waits()) BOOST_REQUIRE_EQUAL(move.end, move.start + 1);
        }
      }
    }
  }
  BOOST_TEST(conflicts > 100);
}

BOOST_AUTO_TEST_CASE(a_search_stops_after_max_evaluations) {
  GridWorld world = grid({"a....", "....."}, {".....", "....a"});
  const auto search = [&](std::uint64_t max_evaluations) {
    return timed_search(world, 0, {}, {}, {}, nullptr, {.max_evaluations = max_evaluations}, Deadline());
  };
  const std::uint64_t needed = search(1000).statistics.evaluations;
  BOOST_TEST((search(needed).status == Status::solved));
  const TimedSearchResult less = search(needed - 1);
  BOOST_TEST((less.status == Status::timed_out));
  BOOST_TEST(less.lower == 5.0);
  BOOST_TEST(less.path.moves.empty());
}

BOOST_AUTO_TEST_CASE(a_start_without_a_goal_is_exhausted_even_with_experience) {
  GridWorld world = grid({"a#."}, {".#a"});
  const TimedPath known{{{0, 0, 0, 1}, {0, 0, 1, forever}}, 1.0};
  const TimedSearchResult result = timed_search(world, 0, {}, {}, {}, &known, {}, Deadline());
  BOOST_TEST((result.status == Status::exhausted));
  BOOST_TEST(result.statistics.expansions == 0u);
}

BOOST_AUTO_TEST_CASE(nothing_is_exhausted_once_the_deadline_has_passed) {  // some edges may not have been checked
  GridWorld world = grid({"a#."}, {".#a"});
  BOOST_TEST((timed_search(world, 0, {}, {}, {}, nullptr, {}, Deadline(0.0)).status == Status::timed_out));
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
