#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "srmp/planning/smoothing/joint_shortcut.hpp"
#include "srmp/planning/smoothing/large_neighbourhood_search.hpp"
#include "srmp/planning/strategies/composite_roadmap.hpp"
#include "srmp/planning/strategies/composite_sampling.hpp"
#include "srmp/planning/strategies/composite_search.hpp"
#include "support/robots.hpp"

namespace {

using Eigen::Vector2d;
using srmp::JointPath;

const Vector2d start(1.2, 0.0);
const std::vector<std::size_t> both{0, 1};

srmp::WorldTask task_to(const Vector2d& goal) { return {start, {goal}, {start, goal}}; }

/// Two planar arms face to face, 3 m apart, each 2 m long when straight, that pass each other.
///
///     left ──────── ──────── right
struct Pair {
  explicit Pair(const Vector2d& goal = {-1.2, 0.0}) : Pair(task_to(goal), task_to(goal)) {}
  Pair(const srmp::WorldTask& left, const srmp::WorldTask& right) {
    srmp::RobotDescription description = robots::planar_description();
    description.name = "left";
    planner.add_articulation(description);
    description.name = "right";
    planner.add_articulation(description, srmp::Pose::from_rpy({3, 0, 0}, {0, 0, M_PI}));
    checkers = std::make_unique<srmp::GroupCheckers>(planner.scene(), std::vector<std::string>{"left", "right"},
                                                     srmp::CheckerOptions{});
    world = std::make_unique<srmp::MultiRobotWorld>(*checkers, std::vector{left, right},
                                                    srmp::MultiRobotWorld::Options{22.5 * M_PI / 180, 0.1});
  }

  void check_free(const JointPath& path) {
    for (std::size_t row = 0; row + 1 < path.size(); ++row) {
      std::vector<Eigen::VectorXd> from, to;
      for (std::size_t i = 0; i < 2; ++i) {
        from.push_back(srmp::position_at(path, i, path.steps[row]));
        to.push_back(srmp::position_at(path, i, path.steps[row + 1]));
        BOOST_TEST(world->is_free_for_one(i, from[i], to[i]));
      }
      BOOST_TEST(world->are_collision_free(0, from[0], to[0], 1, from[1], to[1]));
    }
  }

  srmp::PlannerInterface planner;
  std::unique_ptr<srmp::GroupCheckers> checkers;
  std::unique_ptr<srmp::MultiRobotWorld> world;
};

/// Where nothing collides, but checks take so long that a deadline cuts them off.
class Slow final : public srmp::Checker {
 public:
  Slow(const srmp::Scene& scene, const std::string& robot, const srmp::CheckerOptions& options)
      : Checker(scene, robot, options) {}

 private:
  static bool is_checked(const Workspace& workspace) {
    if (workspace.deadline && workspace.deadline->expired()) throw srmp::MotionCheckStopped();
    return true;
  }
  bool do_is_free(srmp::ConstVector, Workspace& workspace) const override { return is_checked(workspace); }
  bool do_is_motion_free(srmp::ConstVector, srmp::ConstVector, Workspace& workspace,
                         const srmp::MotionQuery&) const override {
    return is_checked(workspace);
  }
  std::vector<srmp::Contact> do_contacts(srmp::ConstVector, Workspace&) const override { return {}; }
  std::optional<srmp::Contact> do_nearest(srmp::ConstVector, Workspace&) const override { return std::nullopt; }
};

}  // namespace

BOOST_AUTO_TEST_SUITE(composite)

BOOST_AUTO_TEST_CASE(rrt_connect_and_lattices_find_free_paths_from_start_to_goal) {
  Pair pair;
  const srmp::CompositeSpace space(*pair.world, both);
  srmp::search::RrtConnect trees(srmp::rrt_space(space));
  const auto grown = trees.grow(10'000, {});
  BOOST_REQUIRE(grown.has_value());
  const auto found = srmp::composite_search(space, {.max_expansions = 10'000}, {});
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  for (const JointPath& path : {space.path(*grown), found.path}) {
    pair.check_free(path);
    for (const srmp::RowMatrix& q : path.positions) {
      BOOST_TEST((q.row(0).transpose() == start));
      BOOST_TEST((q.bottomRows(1).transpose() - Vector2d(-1.2, 0.0)).norm() < 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(no_path_leads_to_goals_in_collision) {
  Pair apart(Vector2d(0.0, 0.0));  // both straight: the robots collide
  const srmp::CompositeSpace nowhere(*apart.world, both);
  BOOST_TEST(!srmp::search::RrtConnect(srmp::rrt_space(nowhere)).grow(1'000, {}).has_value());
}

BOOST_AUTO_TEST_CASE(a_robot_that_needs_no_detour_is_rerouted) {
  Pair pair;
  const Vector2d goal(-1.2, 0.0), any(1.2, 2.0);
  // The left one goes first; the right one makes a needless detour to a retreat and waits there.
  JointPath path = srmp::joint_path(*pair.world, both, {{start, start, goal, goal}, {start, any, any, goal}});
  const double before = path.length(1);
  const JointPath better = srmp::reroute_one_robot(path, *pair.world, {});
  pair.check_free(better);
  BOOST_TEST(better.length(0) <= path.length(0) + 1e-9);
  BOOST_TEST(better.length(1) < 0.95 * before);
  BOOST_TEST((better.positions[1].row(0).transpose() == start));
  BOOST_TEST((better.positions[1].bottomRows(1).transpose() - goal).norm() < 1e-12);
  const JointPath unchanged = srmp::reroute_one_robot(path, *pair.world, srmp::Deadline(1e-9));
  BOOST_TEST(unchanged.length() == path.length());
}

BOOST_AUTO_TEST_CASE(a_robot_that_retreats_for_another_comes_back) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), any(1.2, 0.5);
  Pair pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});  // the right one blocks the left one's path
  const JointPath path = srmp::joint_path(*pair.world, both, {{up, up, down, down}, {straight, any, any, straight}});
  pair.check_free(path);
  const JointPath better = srmp::reroute_one_robot(path, *pair.world, {});
  pair.check_free(better);
  BOOST_TEST((better.positions[1].bottomRows(1).transpose() == straight));
}

BOOST_AUTO_TEST_CASE(a_robot_is_rerouted_through_a_nearer_configuration) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), far(1.6, 1.0), near(1.2, 0.5);
  Pair pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});
  const JointPath path = srmp::joint_path(*pair.world, both, {{up, up, down, down}, {straight, far, far, straight}});
  pair.check_free(path);
  const JointPath better = srmp::reroute_one_robot(path, *pair.world, {}, {{}, {near}});
  pair.check_free(better);
  BOOST_TEST(better.length(1) < 0.95 * path.length(1));
  BOOST_TEST(better.length(1) < srmp::reroute_one_robot(path, *pair.world, {}).length(1));
}

BOOST_AUTO_TEST_CASE(tightened_paths_detour_no_more_than_necessary) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), far(1.6, 1.0);
  Pair pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});
  const JointPath path = srmp::joint_path(*pair.world, both, {{up, up, down, down}, {straight, far, far, straight}});
  const JointPath tight = srmp::tightened(path, *pair.world, {});
  pair.check_free(tight);
  BOOST_TEST(tight.length(0) <= path.length(0));
  BOOST_TEST(tight.length(1) < 0.95 * path.length(1));
  for (std::size_t robot : both) {
    BOOST_TEST((tight.positions[robot].row(0) == path.positions[robot].row(0)));
    BOOST_TEST((tight.positions[robot].bottomRows(1) == path.positions[robot].bottomRows(1)));
  }
  BOOST_TEST(srmp::tightened(path, *pair.world, srmp::Deadline(1e-9)).length() == path.length());
}

BOOST_AUTO_TEST_CASE(roadmaps_give_shorter_paths_for_smaller_weights) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0);
  Pair pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});
  srmp::CompositeRoadmap roadmaps(*pair.world, {.retreats = 8});
  using Budget = srmp::CompositeRoadmap::SearchBudget;
  const auto run = [&](const Budget& budget) { return roadmaps.run(both, budget, {}); };
  const auto greedy = run({.max_expansions = 10'000, .max_checks = 10'000});
  BOOST_REQUIRE(greedy.status == srmp::Status::solved);
  pair.check_free(greedy.path);
  BOOST_TEST(greedy.path.length() <= greedy.cost);
  const auto best = run({.max_expansions = 10'000, .max_checks = 10'000, .weight = 1.0});
  BOOST_REQUIRE(best.status == srmp::Status::solved);
  pair.check_free(best.path);
  BOOST_TEST(best.cost <= greedy.cost);
  for (const double weight : {1.0, 1.5, 3.0}) {
    const auto none = run({.max_expansions = 10'000, .max_checks = 10'000, .weight = weight, .max_cost = best.cost});
    BOOST_TEST((none.status == srmp::Status::exhausted));  // no path costs less than the best
    const auto some =
        run({.max_expansions = 10'000, .max_checks = 10'000, .weight = weight, .max_cost = best.cost + 1e-9});
    BOOST_TEST((some.status == srmp::Status::solved));
    BOOST_TEST(some.cost <= best.cost + 1e-9);
  }
  BOOST_TEST((run({.max_expansions = 1, .max_checks = 10'000}).status == srmp::Status::timed_out));
}

BOOST_AUTO_TEST_CASE(checks_that_the_deadline_cuts_off_are_not_remembered_as_collisions) {
  Pair pair;
  const srmp::GroupCheckers checkers(pair.planner.scene(), {"left", "right"}, {}, 1,
                                     [](const auto&... of) { return std::make_unique<const Slow>(of...); });
  const srmp::Deadline passed(-1.0), never;
  srmp::MultiRobotWorld world(checkers, {task_to({-1.2, 0.0}), task_to({-1.2, 0.0})}, {22.5 * M_PI / 180, 0.1});
  std::vector<srmp::search::Successor> next;
  for (const std::size_t i : both) world.agent(i).successors(0, next);
  const srmp::search::StateId state = next.front().state;
  const srmp::multi::Move move{0, state, 0, 5};
  srmp::CompositeRoadmap roadmaps(world);
  const srmp::CompositeRoadmap::SearchBudget budget{.max_expansions = 10'000, .max_checks = 10'000};
  roadmaps.run(both, {.max_expansions = 1, .max_checks = 1}, never);  // for the roadmaps themselves
  world.stop_at(passed);
  BOOST_TEST(world.agent(0).evaluate(0, state) == srmp::search::infinity);
  BOOST_TEST(world.in_conflict(0, move, 1, move));
  BOOST_TEST((roadmaps.run(both, budget, never).status != srmp::Status::solved));
  world.stop_at(never);
  BOOST_TEST(world.agent(0).evaluate(0, state) < srmp::search::infinity);
  BOOST_TEST(!world.in_conflict(0, move, 1, move));
  BOOST_TEST((roadmaps.run(both, budget, never).status == srmp::Status::solved));
}

BOOST_AUTO_TEST_CASE(roadmaps_refuse_options_out_of_range) {
  Pair pair;
  for (const srmp::CompositeRoadmapOptions& options :
       std::vector<srmp::CompositeRoadmapOptions>{{.retreats = 0},
                                                  {.retreat_candidates = 0},
                                                  {.branch_points = 0},
                                                  {.spacing = 0.0},
                                                  {.max_vertices = 65'536},
                                                  {.block = 0},
                                                  {.step_cost = -1.0},
                                                  {.joint_offsets = {NAN}}})
    BOOST_CHECK_THROW(srmp::CompositeRoadmap(*pair.world, options), srmp::InvalidArgument);
}

BOOST_AUTO_TEST_CASE(robots_arrive_at_their_goals_exactly) {
  const Vector2d goal(-1.1, 0.3);
  Pair pair(goal);
  const Vector2d by(0.7, -0.9);  // 1.2 + (by - 1.2) is not by
  const JointPath path = srmp::joint_path(*pair.world, both, {{start, by, goal}, {start, by, goal}});
  for (const srmp::RowMatrix& q : path.positions) {
    BOOST_TEST((q.row(1).transpose() == by));
    BOOST_TEST((q.row(2).transpose() == goal));
  }
}

BOOST_AUTO_TEST_SUITE_END()
