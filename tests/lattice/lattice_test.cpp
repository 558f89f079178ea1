#include "srmp/lattice/lattice.hpp"

#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "srmp/core/error.hpp"
#include "srmp/search/alternating_search.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/wpase.hpp"
#include "support/data.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace srmp;
using Eigen::Vector2d;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

bool always_free(std::size_t, const Eigen::VectorXd&, const Eigen::VectorXd&) { return true; }

Lattice make_lattice(const RobotModel& robot, const Vector2d& start, std::vector<Eigen::VectorXd> goals,
                     double step_degrees = 10, MotionValidator validator = always_free,
                     double connection_distance = search::infinity) {
  Lattice::Options options{
      axis_primitives(robot.joints(), Vector2d::Constant(step_degrees * degree)), connection_distance, {}};
  return Lattice(robot, {start}, std::move(goals), options, std::move(validator));
}

std::vector<search::Successor> successors(Lattice& lattice, search::StateId state) {
  std::vector<search::Successor> out;
  lattice.successors(state, out);
  return out;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_joint_moves_by_a_step_and_near_the_ends_by_a_third_of_one) {
  const auto robot = robots::planar();
  Lattice lattice = make_lattice(*robot, {0, 0}, {Vector2d(2, 2)}, 30);
  const auto from_start = successors(lattice, 0);
  BOOST_TEST(from_start.size() == 1 + 4 + 4);                            // connection, whole, third
  BOOST_TEST(successors(lattice, from_start[1].state).size() == 1 + 4);  // 30 degrees away: far from both ends
  Lattice no_connection = make_lattice(*robot, {0, 0}, {Vector2d(2, 2)}, 30, always_free, 1.0);
  BOOST_TEST(successors(no_connection, 0).size() == 4 + 4);
}

BOOST_AUTO_TEST_CASE(default_primitives_are_the_rich_ones_and_short_moves_near_the_ends) {
  const auto robot = robots::planar3();
  const Eigen::VectorXd step = Eigen::Vector3d::Constant(30 * degree);
  const auto pairs = parallel_pairs(*robot);
  const auto moves = [](const PrimitiveSet& set) {
    std::size_t count = 0;
    for (const PrimitiveFamily& family : set.families) count += family.moves.size();
    return count;
  };
  const PrimitiveSet set = default_primitives(robot->joints(), step, pairs);
  BOOST_TEST(moves(set) == moves(rich_primitives(robot->joints(), step, pairs)) + 6);
  BOOST_TEST(set.near_distance == 15 * degree);
  Lattice lattice(*robot, {Eigen::Vector3d(0, 0, 0)}, {Eigen::Vector3d(2, 2, 2)}, {set, 0.0}, always_free);
  const auto from_start = successors(lattice, 0);
  BOOST_TEST(from_start.size() == moves(set));
  BOOST_TEST(successors(lattice, from_start.back().state).size() == moves(set));       // 10 degrees away
  BOOST_TEST(successors(lattice, from_start.front().state).size() == moves(set) - 6);  // a whole step
}

BOOST_AUTO_TEST_CASE(limits_end_the_lattice) {
  const auto robot = robots::planar();
  Lattice lattice = make_lattice(*robot, {2.95, 0}, {Vector2d(0, 0)});
  for (const auto& next : successors(lattice, 0)) BOOST_TEST(lattice.configuration(next.state)[0] <= 3.0 + 1e-9);
}

BOOST_AUTO_TEST_CASE(different_moves_meet_in_one_state) {
  const auto robot = robots::planar();
  Lattice lattice = make_lattice(*robot, {0.123, -0.456}, {Vector2d(2, 2)}, 9);
  // One whole move ends where three thirds do.
  const auto whole = successors(lattice, 0)[1].state;
  search::StateId state = 0;
  for (int third = 0; third < 3; ++third) state = successors(lattice, state)[5].state;
  BOOST_TEST(state == whole);
  BOOST_TEST((lattice.configuration(whole) - Vector2d(0.123 + 9 * degree, -0.456)).norm() < 1e-9);
}

BOOST_AUTO_TEST_CASE(edge_costs_are_joint_space_lengths_and_the_heuristic_is_consistent) {
  const auto robot = robots::planar("continuous");
  Lattice lattice = make_lattice(*robot, {3.0, 0.5}, {Vector2d(-2.5, -1), Vector2d(1, 2)});
  for (search::StateId state = 0; state < 2000; ++state) {
    if (state >= lattice.size()) break;
    for (const auto& next : successors(lattice, state)) {
      const double length = lattice.distance(lattice.configuration(state), lattice.configuration(next.state));
      BOOST_TEST(std::abs(length - next.cost) < 1e-9);
      BOOST_TEST(lattice.distance_to_targets(state) <= next.cost + lattice.distance_to_targets(next.state) + 1e-9);
    }
  }
}

/// The laws of the joint-space distance: h(a) <= cost(a, b) + h(b) on the edges of random walks, h = 0 at the targets.
void check_consistency(const RobotModel& robot) {
  std::mt19937 random(7);
  const auto draw = [&] {
    Eigen::VectorXd q(robot.dof());
    for (std::size_t j = 0; j < robot.dof(); ++j) {
      const double low = std::max(robot.joints()[j].lower, -3.0), high = std::min(robot.joints()[j].upper, 3.0);
      q[static_cast<Eigen::Index>(j)] = low + (high - low) * (random() / 4294967296.0);
    }
    return q;
  };
  const Eigen::VectorXd step = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(robot.dof()), 15 * degree);
  for (const PrimitiveSet& primitives :
       {axis_primitives(robot.joints(), step), default_primitives(robot.joints(), step, parallel_pairs(robot))}) {
    Lattice lattice(robot, {draw(), draw()}, {draw(), draw(), draw()}, {.primitives = primitives}, always_free);
    const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
    for (search::StateId target = 2; target < 5; ++target) BOOST_TEST(h(target) == 0.0);
    for (int walk = 0; walk < 20; ++walk) {
      search::StateId at = static_cast<search::StateId>(walk % 2);
      for (int i = 0; i < 50; ++i) {
        const auto next = successors(lattice, at);
        for (const search::Successor& edge : next) {
          BOOST_TEST(h(at) <= edge.cost + h(edge.state) + 1e-9);
          BOOST_TEST(h(edge.state) <= edge.cost + h(at) + 1e-9);  // the same edge in a backward search
        }
        if (lattice.is_goal(at = next[random() % next.size()].state)) break;
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_joint_distance_is_consistent_on_real_robots) {
  check_consistency(*RobotModel::load(arm7()));
  for (const auto& [robot, group] : {std::pair{"panda", "panda_arm"}, std::pair{"fetch", "arm_with_torso"}}) {
    const std::string urdf = mbm_file(robot, std::string(robot) + ".urdf");
    if (urdf.empty()) continue;
    RobotDescription description;
    description.urdf_path = urdf;
    description.srdf_path = mbm_file(robot, std::string(robot) + ".srdf");
    description.group = group;
    check_consistency(*RobotModel::load(description));
  }
}

BOOST_AUTO_TEST_CASE(continuous_joints_wrap_and_paths_unwrap) {
  const auto robot = robots::planar("continuous");
  Lattice lattice = make_lattice(*robot, {3.0, 0}, {Vector2d(-3.0, 0)});
  const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
  const auto result = search::weighted_astar(lattice, lattice.starts(), h, {.weight = 1.0}, Deadline());
  BOOST_REQUIRE(result.status == Status::solved);
  BOOST_TEST(std::abs(result.cost - (2 * std::numbers::pi - 6.0)) < 1e-9);
  const auto path = lattice.configurations(result.path);
  BOOST_TEST(std::abs(path.back()[0] - (2 * std::numbers::pi - 3.0)) < 1e-9);
  // A full turn on the grid ends in the same state.
  Lattice round = make_lattice(*robot, {0, 0}, {Vector2d(0, 3)}, 90, always_free, 0.0);
  search::StateId state = 0;
  for (int quarter = 0; quarter < 4; ++quarter) state = successors(round, state)[0].state;
  BOOST_TEST(state == 0u);
}

BOOST_AUTO_TEST_CASE(paths_lead_around_a_wall_and_a_closed_room_is_exhausted) {
  const auto robot = robots::planar();
  const auto wall = [](std::size_t, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const auto blocked = [](const Eigen::VectorXd& q) { return std::abs(q[0] - 1.0) < 0.3 && q[1] < 1.5; };
    for (int i = 0; i <= 50; ++i)
      if (blocked(a + (b - a) * (i / 50.0))) return false;
    return true;
  };
  Lattice lattice = make_lattice(*robot, {0, 0}, {Vector2d(2, 0)}, 10, wall);
  const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
  const auto result = search::weighted_astar(lattice, lattice.starts(), h, {.weight = 1.0}, Deadline());
  BOOST_REQUIRE(result.status == Status::solved);
  BOOST_TEST(result.cost > 2.5);

  Lattice closed =
      make_lattice(*robot, {0, 0}, {Vector2d(2, 0)}, 10,
                   [](std::size_t, const Eigen::VectorXd&, const Eigen::VectorXd& b) { return b.norm() < 1.0; });
  const auto to_closed = [&](search::StateId s) { return closed.distance_to_targets(s); };
  const auto none = search::weighted_astar(closed, closed.starts(), to_closed, {.weight = 1.0}, Deadline());
  BOOST_TEST((none.status == Status::exhausted));
}

BOOST_AUTO_TEST_CASE(primitives_are_checked) {
  const auto robot = robots::planar();
  check_throws<InvalidArgument>([&] { axis_primitives(robot->joints(), Vector2d(0.1, 0.0)); },
                                "resolution of joint 'b'");
  PrimitiveSet zero{{{"stay", PrimitiveUse::always, {Vector2d(0, 0)}}}};
  check_throws<InvalidArgument>([&] { Lattice(*robot, {Vector2d(0, 0)}, {Vector2d(1, 1)}, {zero}, always_free); },
                                "'stay' has a move of zero length");
}

BOOST_AUTO_TEST_CASE(all_joints_at_once_move_towards_each_target) {
  const auto robot = robots::planar3("continuous");
  const Eigen::Vector3d start(3.0, 0.0, 0.0), step = Eigen::Vector3d::Constant(10 * degree);
  const std::vector<Eigen::VectorXd> goals{Eigen::Vector3d(-3.0, 1.0, -1.0), Eigen::Vector3d(2.0, 1.0, 0.01),
                                           Eigen::Vector3d(-2.0, 2.0, -2.0)};
  Lattice lattice(*robot, {start}, goals, {rich_primitives(robot->joints(), step, parallel_pairs(*robot)), 0.0},
                  always_free);
  const auto next = successors(lattice, 0);
  // The first and the last target give the same move; the second leaves two joints to move, which give none.
  BOOST_REQUIRE(next.size() == 1 + 6 + 3 * 4);
  const Eigen::VectorXd there = lattice.configuration(next[0].state);
  BOOST_TEST(std::abs(std::remainder(there[0] - 3.0 - step[0], 2 * std::numbers::pi)) < 1e-5);  // over the seam
  BOOST_TEST((there - start - Eigen::Vector3d(0, step[1], -step[2])).tail(2).norm() < 1e-5);
  BOOST_TEST(std::abs(next[0].cost - lattice.distance(start, there)) < 1e-9);
}

BOOST_AUTO_TEST_CASE(pairs_are_joints_with_parallel_axes) {
  const auto pairs = parallel_pairs(*robots::planar3());
  BOOST_TEST((pairs == std::vector<JointPair>{{0, 1}, {0, 2}, {1, 2}}));
  BOOST_TEST((parallel_pairs(*robots::planar3("prismatic")) == std::vector<JointPair>{{1, 2}}));
}

BOOST_AUTO_TEST_CASE(rich_lattices_keep_the_laws) {
  const auto robot = robots::planar3("continuous");
  const Eigen::Vector3d start(3.0, 0.5, 0.1);
  Lattice lattice(*robot, {start}, {Eigen::Vector3d(-2.5, -1, 0.3), Eigen::Vector3d(1, 2, -1)},
                  {rich_primitives(robot->joints(), Eigen::Vector3d::Constant(7 * degree), parallel_pairs(*robot))},
                  always_free);
  for (search::StateId state = 0; state < 500; ++state) {
    const auto next = successors(lattice, state);
    BOOST_TEST(std::abs(lattice.distance_from_roots(state) - lattice.distance(start, lattice.configuration(state))) <
               1e-9);
    for (std::size_t i = 0; i < next.size(); ++i) {
      const double length = lattice.distance(lattice.configuration(state), lattice.configuration(next[i].state));
      BOOST_TEST(std::abs(length - next[i].cost) < 1e-9);
      BOOST_TEST(lattice.distance_to_targets(state) <= length + lattice.distance_to_targets(next[i].state) + 1e-9);
      BOOST_TEST(next[i].state != state);
      for (std::size_t k = 0; k < i; ++k) BOOST_TEST(next[k].state != next[i].state);
    }
  }
}

BOOST_AUTO_TEST_CASE(several_distances_to_the_targets) {
  const auto robot = robots::planar();
  Lattice lattice = make_lattice(*robot, {0, 0}, {Vector2d(2, 1), Vector2d(0, -2)});
  RowMatrix weights(2, 2);
  weights << 1.0, 1.0, 0.5, 2.0;
  std::array<double, 3> out{};
  lattice.distances_to_targets(0, weights, out);
  BOOST_TEST(std::abs(out[0] - 2.0) < 1e-12);
  BOOST_TEST(std::abs(out[1] - std::sqrt(5.0)) < 1e-12);
  BOOST_TEST(std::abs(out[2] - 2.0) < 1e-12);
  lattice.distances_to_targets(1, weights, out);  // a target
  BOOST_TEST((out == std::array<double, 3>{}));
}

// --- goals that are found while the search runs

namespace {

/// The planar arm among discs in its joint space. Any q with q0 + q1 = 2 is a goal, as of a redundant arm; only
/// `targets` are known beforehand; a state within 0.6 of the others is connected with the nearest, at times with two.
struct ConnectionWorld {
  explicit ConnectionWorld(unsigned seed) : dice(seed) {
    for (unsigned i = 0; i < 10 + seed / 3; ++i) discs.emplace_back(in(-2.5, 2.5), in(-2.5, 2.5));
    do start = {in(-2.5, 0.5), in(-2.5, 0.5)};
    while (!is_free(start, start));
    while (targets.size() < 2) {
      const double along = in(-0.5, 2.5);
      if (is_free(Vector2d(along, 2 - along), Vector2d(along, 2 - along)))
        targets.push_back(Vector2d(along, 2 - along));
    }
  }

  double in(double low, double high) { return low + (high - low) * (dice() / 4294967296.0); }

  bool is_free(const Vector2d& a, const Vector2d& b) const {
    return std::none_of(discs.begin(), discs.end(), [&](const Vector2d& disc) {
      const Vector2d ab = b - a;
      const double t = std::clamp((disc - a).dot(ab) / std::max(ab.squaredNorm(), 1e-18), 0.0, 1.0);
      return (a + t * ab - disc).norm() < 0.55;
    });
  }

  static std::vector<ConnectedGoal> goals_near(const Eigen::VectorXd& q) {
    const double off = (q[0] + q[1] - 2.0) / 2.0;
    std::vector<ConnectedGoal> goals;
    if (std::abs(off) < 0.4) goals.push_back({q - Vector2d(off, off), 7});
    if (std::abs(off) < 0.1) goals.push_back({q - Vector2d(2 * off, 0), 8});
    return goals;
  }

  Lattice lattice(const RobotModel& robot, bool connections) const {
    return lattice(robot, {start}, targets, connections ? GoalConnection(goals_near) : GoalConnection());
  }
  Lattice lattice(const RobotModel& robot, std::vector<Eigen::VectorXd> roots, std::vector<Eigen::VectorXd> ends,
                  GoalConnection connection = {}) const {
    return Lattice(robot, std::move(roots), std::move(ends),
                   {axis_primitives(robot.joints(), Vector2d::Constant(25 * degree)), 1.0, std::move(connection)},
                   [this](std::size_t, const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_free(a, b); });
  }

  std::mt19937 dice;
  std::vector<Vector2d> discs;
  Vector2d start;
  std::vector<Eigen::VectorXd> targets;
};

/// The cost of the cheapest path to any goal, and to any target, by relaxing all edges until nothing changes.
std::pair<double, double> brute_force(Lattice& lattice) {
  std::vector<search::Edge> edges;
  for (search::StateId state = 0; state < lattice.size(); ++state)
    for (const auto& next : successors(lattice, state)) edges.push_back({state, next.state, next.cost});
  std::vector<double> costs(edges.size());
  lattice.evaluate(edges, costs);
  std::vector<double> to(lattice.size(), search::infinity);
  to[0] = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (to[edges[i].from] + costs[i] < to[edges[i].to]) {
        to[edges[i].to] = to[edges[i].from] + costs[i];
        changed = true;
      }
  }
  double any = search::infinity, target = search::infinity;
  for (search::StateId state = 0; state < lattice.size(); ++state) {
    if (!lattice.is_goal(state)) continue;
    any = std::min(any, to[state]);
    if (!lattice.connected_goal(state)) target = std::min(target, to[state]);
  }
  return {any, target};
}

/// How many of the results below were of which kind.
struct Counts {
  int by_connection{}, cheaper{}, only_by_connection{}, exhausted{};
};

/// The path, which is free and costs what is said.
std::vector<Eigen::VectorXd> free_path(const ConnectionWorld& world, const Lattice& lattice,
                                       const search::Result& result) {
  std::vector<Eigen::VectorXd> path = lattice.configurations(result.path);
  double cost = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    cost += lattice.distance(path[i - 1], path[i]);
    BOOST_TEST(world.is_free(path[i - 1], path[i]));
  }
  BOOST_TEST(std::abs(cost - result.cost) < 1e-9);
  return path;
}

/// The result is a path of the lattice with goal connections and keeps its bound on the optimum without them, `target`;
/// `any` is the optimum with them.
void check_connection_result(const ConnectionWorld& world, const Lattice& lattice, const search::Result& result,
                             double weight, double any, double target, Counts& counts) {
  if (any == search::infinity) {
    ++counts.exhausted;
    BOOST_TEST((result.status == Status::exhausted));
    return;
  }
  BOOST_REQUIRE(result.status == Status::solved);
  BOOST_TEST(lattice.is_goal(result.path.back()));
  const auto path = free_path(world, lattice, result);
  BOOST_TEST(result.cost >= any - 1e-9);
  BOOST_TEST(result.bound <= weight);
  BOOST_TEST(result.cost <= result.bound * target + 1e-9);
  BOOST_TEST(result.cost / result.bound <= target + 1e-9);
  const ConnectedGoal* connected = lattice.connected_goal(result.path.back());
  counts.by_connection += connected != nullptr;
  counts.only_by_connection += target == search::infinity;
  counts.cheaper += result.cost < target - 1e-9;
  if (connected) BOOST_TEST((connected->goal == 7 || connected->goal == 8));
  if (connected) BOOST_TEST((path.back() - connected->q).norm() < 1e-12);
}

/// Calls check(weight, run) for searches with guarantees; run(lattice, heuristic) gives the result.
template <class Check>
void for_each_search(double target, Check&& check) {
  using namespace search;
  for (const double w : {1.0, 3.0, 50.0}) {
    check(w, [&](Lattice& g, const auto& h) { return weighted_astar(g, g.starts(), h, {.weight = w}, Deadline()); });
    for (const std::size_t batch : {1, 4})
      check(w, [&](Lattice& g, const auto& h) {
        return wpase(g, g.starts(), h, {.weight = w, .batch_size = batch}, Deadline());
      });
    check(w * 2.0, [&](Lattice& g, const auto& h) {
      const std::vector<InadmissibleHeuristic> others{[&](StateId s) { return g.distance_from_roots(s); }};
      return mha_star(g, g.starts(), h, others, {.w1 = w, .w2 = 2.0}, Deadline());
    });
    check(w, [&](Lattice& g, const auto& h) {
      const auto values = [&](std::span<const StateId> states, std::span<double> out) {
        std::transform(states.begin(), states.end(), out.begin(), [&](StateId s) { return h(s); });
      };
      AlternatingSearch search(g, g.starts(), h, InadmissibleHeuristics{1, values}, w);
      return search.result(search.improve(Deadline(), 1'000'000));
    });
  }
  check(1.0, [&](Lattice& g, const auto& h) {
    AraOptions options{.initial_weight = 50.0, .weight_delta = 20.0, .final_weight = 1.0, .on_solution = {}};
    options.on_solution = [&](const Result& better) {
      BOOST_TEST(better.cost <= better.bound * target + 1e-9);
      return true;
    };
    return ara_star(g, g.starts(), h, options, Deadline());
  });
}

}  // namespace

BOOST_AUTO_TEST_CASE(goal_connections_keep_every_bound_of_the_lattice_without_them) {
  const auto robot = robots::planar();
  Counts counts;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const ConnectionWorld world(seed);
    Lattice whole = world.lattice(*robot, true), plain = world.lattice(*robot, false);
    const auto [any, target] = brute_force(whole);
    BOOST_TEST(target == brute_force(plain).second);  // goal connections change no other cost
    for_each_search(target, [&, any = any, target = target](double weight, const auto& run) {
      Lattice lattice = world.lattice(*robot, true);
      const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
      check_connection_result(world, lattice, run(lattice, h), weight, any, target, counts);
    });
  }
  BOOST_TEST(counts.by_connection > 100);  // the worlds are of every kind
  BOOST_TEST(counts.cheaper > 20);
  BOOST_TEST(counts.only_by_connection > 0);
  BOOST_TEST(counts.exhausted > 0);
}

BOOST_AUTO_TEST_CASE(goal_connections_generated_again_are_the_same_states) {
  const auto robot = robots::planar();
  Lattice lattice(*robot, {Vector2d(1, 0.95)}, {Vector2d(2, 0)},
                  {axis_primitives(robot->joints(), Vector2d::Constant(10 * degree)), 0.0, ConnectionWorld::goals_near},
                  always_free);
  const auto first = successors(lattice, 0), again = successors(lattice, 0);
  BOOST_REQUIRE_EQUAL(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) BOOST_TEST(first[i].state == again[i].state);
  BOOST_TEST(lattice.connected_goal(first[0].state)->goal == 7);
  BOOST_TEST(lattice.connected_goal(first[1].state)->goal == 8);
  for (int i : {0, 1}) {
    const auto goal = first[static_cast<std::size_t>(i)].state;
    BOOST_TEST(lattice.is_goal(goal));
    BOOST_TEST(lattice.distance_to_targets(goal) == 0.0);
    BOOST_TEST(successors(lattice, goal).empty());
    BOOST_TEST(std::abs(lattice.configuration(goal).sum() - 2.0) < 1e-12);
  }
  BOOST_TEST(lattice.connected_goal(1) == nullptr);  // a target
  BOOST_TEST(lattice.is_goal(1));
  BOOST_TEST(!lattice.is_goal(0));
}

// --- searches from both ends that are connected

namespace {

/// What a search from the targets has expanded after `expansions`.
search::ConfigurationTree expanded_from_targets(const ConnectionWorld& world, const RobotModel& robot,
                                                std::uint64_t expansions) {
  search::ConfigurationTree tree;
  const search::ConfigurationTree other;
  Lattice lattice = world.lattice(robot, world.targets, {world.start});
  lattice.connect_trees(tree, other);
  const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
  search::WeightedAstar search(lattice, lattice.starts(), h, {.weight = 5.0});
  search.improve(Deadline(), expansions);
  return tree;
}

}  // namespace

BOOST_AUTO_TEST_CASE(searches_from_both_ends_are_connected_and_keep_every_bound_of_the_lattice) {
  const auto robot = robots::planar();
  int solved = 0, longer = 0, only_by_connection = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const ConnectionWorld world(seed);
    Lattice plain = world.lattice(*robot, false);
    const double target = brute_force(plain).second;
    const search::ConfigurationTree other = expanded_from_targets(world, *robot, 1 + seed);
    for_each_search(target, [&](double weight, const auto& run) {
      search::ConfigurationTree own;
      Lattice lattice = world.lattice(*robot, false);
      lattice.connect_trees(own, other);
      const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
      const search::Result result = run(lattice, h);
      BOOST_TEST(own.size() >= result.statistics.expansions);
      if (result.status != Status::solved) {
        BOOST_TEST((result.status == Status::exhausted));
        BOOST_TEST(target == search::infinity);
        return;
      }
      const auto path = free_path(world, lattice, result);
      BOOST_TEST((path.front() == world.start));
      BOOST_TEST((path.back() == world.targets[lattice.target_of(result.path.back())]));
      BOOST_TEST(result.bound <= weight);
      BOOST_TEST(result.cost <= result.bound * target + 1e-9);
      BOOST_TEST(result.cost / result.bound <= target + 1e-9);
      ++solved;
      longer += path.size() > result.path.size();  // on in the other tree
      only_by_connection += target == search::infinity;
    });
  }
  BOOST_TEST(solved > 500);
  BOOST_TEST(longer > 50);
  BOOST_TEST(only_by_connection > 0);
}

BOOST_AUTO_TEST_CASE(every_state_is_connected_with_every_waypoint_which_has_a_grid_of_its_own) {
  const auto robot = robots::planar();
  const Vector2d waypoint(0.567, -0.321);
  Lattice lattice(*robot, {Vector2d(0, 0)}, {Vector2d(2, 2)},
                  {axis_primitives(robot->joints(), Vector2d::Constant(10 * degree)), search::infinity, {}, {waypoint}},
                  always_free);
  const auto find = [&](search::StateId from, const Vector2d& q) {
    for (const auto& next : successors(lattice, from))
      if ((lattice.configuration(next.state) - q).norm() < 1e-5) return std::optional(next);  // two grid units
    return std::optional<search::Successor>();
  };
  const auto edge = find(0, waypoint);
  BOOST_REQUIRE(edge);
  BOOST_TEST(edge->cost == waypoint.norm(), boost::test_tools::tolerance(1e-12));
  BOOST_TEST(!lattice.is_goal(edge->state));
  BOOST_TEST(lattice.starts().size() == 1u);
  BOOST_TEST(lattice.root_count() == 1u);
  BOOST_TEST(find(successors(lattice, 0)[3].state, waypoint).has_value());  // from every state
  BOOST_TEST(find(edge->state, waypoint + Vector2d(10 * degree, 0)).has_value());
  BOOST_TEST(find(edge->state, Vector2d(2, 2)).has_value());
}

BOOST_AUTO_TEST_CASE(joints_of_two_robots_make_one_lattice) {
  const auto a = robots::planar(), b = robots::planar3();
  std::vector<Joint> joints = a->joints();
  joints.insert(joints.end(), b->joints().begin(), b->joints().end());
  const Eigen::VectorXd start = Eigen::VectorXd::Zero(5), goal = Eigen::VectorXd::Constant(5, 0.5);
  Lattice lattice(joints, {start}, {goal}, {axis_primitives(joints, Eigen::VectorXd::Constant(5, 30 * degree)), 0.0},
                  always_free);
  BOOST_TEST(successors(lattice, 0).size() == 10 + 10);  // whole and third
  BOOST_TEST(lattice.distance(start, goal) == goal.norm(), boost::test_tools::tolerance(1e-12));
  Lattice alone(*a, {Vector2d(0, 0)}, {Vector2d(0.5, 0.5)},
                {axis_primitives(a->joints(), Vector2d::Constant(30 * degree)), 0.0}, always_free);
  Lattice from_joints(a->joints(), {Vector2d(0, 0)}, {Vector2d(0.5, 0.5)},
                      {axis_primitives(a->joints(), Vector2d::Constant(30 * degree)), 0.0}, always_free);
  const auto one = successors(alone, 0), other = successors(from_joints, 0);
  BOOST_REQUIRE(one.size() == other.size());
  for (std::size_t i = 0; i < one.size(); ++i) BOOST_TEST(one[i].cost == other[i].cost);
}

BOOST_AUTO_TEST_CASE(a_state_is_on_the_grids_whose_steps_divide_its_distance_from_its_root) {
  const auto robot = robots::planar();
  const Eigen::VectorXd fine = Vector2d::Constant(30 * degree), coarse = Vector2d::Constant(60 * degree);
  const Vector2d root(0.1, -0.2);
  Lattice lattice(*robot, {root}, {Vector2d(2, 2)},
                  {.primitives = axis_primitives(robot->joints(), fine),
                   .coarser = {{coarse, rich_primitives(robot->joints(), coarse, parallel_pairs(*robot))}}},
                  always_free);
  BOOST_REQUIRE_EQUAL(lattice.levels(), 2u);
  std::array<int, 2> on{};
  for (const std::size_t level : {0, 1}) {
    std::vector<search::Successor> next;
    lattice.successors(0, level, next);
    BOOST_TEST(!next.empty());
    for (const search::Successor& successor : next) {
      BOOST_TEST(!lattice.is_goal(successor.state));  // those are connections
      BOOST_TEST(lattice.is_on(successor.state, 0));
      const Vector2d steps = (lattice.configuration(successor.state) - root) / (60 * degree);
      const bool whole = (steps - steps.array().round().matrix()).norm() < 1e-3;
      BOOST_TEST(lattice.is_on(successor.state, 1) == whole);
      ++on[whole];
    }
  }
  BOOST_TEST(on[0] > 0);
  BOOST_TEST(on[1] > 0);

  std::vector<search::Successor> connections;
  lattice.connections(0, connections);
  BOOST_REQUIRE_EQUAL(connections.size(), 1u);
  BOOST_TEST(lattice.is_goal(connections[0].state));
}

BOOST_AUTO_TEST_CASE(an_observer_is_told_of_expansions_and_checks_and_changes_nothing) {
  const auto robot = robots::planar();
  const auto plan = [&](LatticeObserver observer) {
    Lattice::Options options{axis_primitives(robot->joints(), Vector2d::Constant(10 * degree)), 0.5, {}};
    options.observer = std::move(observer);
    const auto not_far = [](std::size_t, const Eigen::VectorXd&, const Eigen::VectorXd& b) { return b[1] < 1.0; };
    Lattice lattice(*robot, {Vector2d(0, 0)}, {Vector2d(0.9, 0.9)}, options, not_far);
    const auto h = [&](search::StateId s) { return lattice.distance_to_targets(s); };
    return search::weighted_astar(lattice, lattice.starts(), h, {.weight = 1.0}, Deadline());
  };
  std::uint64_t expanded = 0, evaluated = 0;
  const search::Result plain = plan({});
  const search::Result watched = plan({.expanded =
                                           [&](const Eigen::VectorXd& q, double to_targets) {
                                             ++expanded;
                                             BOOST_TEST(to_targets == (q - Vector2d(0.9, 0.9)).norm());
                                           },
                                       .evaluated =
                                           [&](const Eigen::VectorXd&, const Eigen::VectorXd& to, bool free) {
                                             ++evaluated;
                                             BOOST_TEST(free == (to[1] < 1.0));
                                           }});
  BOOST_TEST(watched.path == plain.path, boost::test_tools::per_element());
  BOOST_TEST(watched.statistics.evaluations == evaluated);
  BOOST_TEST(watched.statistics.expansions == expanded);
}
