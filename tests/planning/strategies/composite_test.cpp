#include <array>
#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "srmp/planning/strategies/composite_roadmap.hpp"
#include "srmp/planning/strategies/composite_sampling.hpp"
#include "srmp/planning/strategies/composite_search.hpp"
#include "srmp/planning/strategies/free_goals.hpp"
#include "srmp/planning/strategies/one_by_one.hpp"
#include "support/facing_arms.hpp"

namespace {

using Eigen::Vector2d;
using robots::FacingArms;
using srmp::JointPath;

const Vector2d start(1.2, 0.0);
const std::vector<std::size_t> both{0, 1};

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

/// The path is free and leads both from `from`, exactly, to `to`.
void check_path(FacingArms& pair, const JointPath& path, const std::array<Vector2d, 2>& from,
                const std::array<Vector2d, 2>& to) {
  pair.check_free(path);
  for (const std::size_t robot : both) {
    const srmp::RowMatrix& q = path.positions[robot];
    BOOST_TEST((q.row(0).transpose() == from[robot]));
    BOOST_TEST((q.bottomRows(1).transpose() - to[robot]).norm() < 1e-12);
  }
}

std::vector<std::vector<Eigen::VectorXd>> own_paths(srmp::MultiRobotWorld& world) {
  return srmp::paths_to_free_goals(world, both, {}).paths;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(composite)

BOOST_AUTO_TEST_CASE(goals_that_robots_choose_alone_give_way_to_others_that_are_free) {
  const Vector2d straight(0.0, 0.0), down(-1.2, 0.0), up(1.2, 0.1);
  srmp::WorldTask left = FacingArms::task_to(straight), right = left;  // both straight: the robots collide
  left.targets = right.targets = {straight, down, up};
  FacingArms pair(left, right);
  const srmp::FreeGoals found = srmp::paths_to_free_goals(*pair.world, both, {});
  BOOST_TEST((found.paths[0] == left.single_robot_path));  // the last robots first
  BOOST_TEST((found.paths[1].front() == start));
  BOOST_TEST((found.paths[1].back() == down));
  BOOST_TEST(found.attempts > 0u);
  for (std::size_t k = 1; k < found.paths[1].size(); ++k)
    BOOST_TEST(pair.world->is_free_for_one(1, found.paths[1][k - 1], found.paths[1][k]));
  const srmp::OneByOneResult all = srmp::one_by_one(*pair.world, both, found.paths, {}, {}, {});
  BOOST_REQUIRE(all.path.has_value());
  check_path(pair, *all.path, {start, start}, {straight, down});

  // Where nothing can be chosen, or found, the paths are their own.
  left.targets = right.targets = {straight};
  for (const srmp::FreeGoalsOptions& options :
       {srmp::FreeGoalsOptions{}, {.steps = 1}, {.attempts = 0}, {.paths = 0}}) {
    FacingArms same(left, right);
    const srmp::FreeGoals none = srmp::paths_to_free_goals(*same.world, both, {}, options);
    BOOST_TEST((none.paths == std::vector{left.single_robot_path, right.single_robot_path}));
    left.targets = right.targets = {straight, down};  // from the second time on
  }
  FacingArms stopped(left, right);
  BOOST_TEST(
      (srmp::paths_to_free_goals(*stopped.world, both, srmp::Deadline(0.0)).paths[1] == right.single_robot_path));

  // A robot that may end anywhere stays.
  left = {.start = straight, .targets = {}, .single_robot_path = {}, .anywhere = true};
  FacingArms beside(left, right);
  const srmp::FreeGoals around = srmp::paths_to_free_goals(*beside.world, both, {});
  BOOST_TEST((around.paths[0] == std::vector<Eigen::VectorXd>{straight}));
  BOOST_TEST((around.paths[1].back() == down));
}

BOOST_AUTO_TEST_CASE(rrt_connect_and_lattices_find_free_paths_from_start_to_goal) {
  FacingArms pair;
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
  FacingArms apart(Vector2d(0.0, 0.0));  // both straight: the robots collide
  const srmp::CompositeSpace nowhere(*apart.world, both);
  BOOST_TEST(!srmp::search::RrtConnect(srmp::rrt_space(nowhere)).grow(1'000, {}).has_value());
}

BOOST_AUTO_TEST_CASE(robots_move_one_after_the_other_around_those_that_stand) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0), bent(0.3, 2.0);
  // The left arm passes the right one, which is straight at its start and bent at its goal: it has to move first.
  FacingArms pair({up, {down}, {up, down}}, {straight, {bent}, {straight, bent}});
  for (const bool backwards : {false, true}) {
    const srmp::OneByOneResult found = srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {},
                                                        {.forwards = !backwards, .backwards = backwards}, {});
    BOOST_REQUIRE(found.path.has_value());
    check_path(pair, *found.path, {up, straight}, {down, bent});
    const std::vector<srmp::RowMatrix>& q = found.path->positions;
    for (Eigen::Index row = 1; row < q[0].rows(); ++row)  // never both at the same time
      BOOST_TEST((q[0].row(row) == q[0].row(row - 1) || q[1].row(row) == q[1].row(row - 1)));
  }
}

BOOST_AUTO_TEST_CASE(robots_that_cannot_pass_at_once_retreat) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0);
  FacingArms pair({up, {down}, {up, down}}, {straight, {straight}, {straight, Vector2d(0.05, 0.0), straight}});
  for (const bool backwards : {false, true}) {
    const srmp::OneByOneOptions without{.forwards = !backwards, .backwards = backwards, .retreats = 0},
        with{.attempts_of_all = 16'384,
             .forwards = !backwards,
             .backwards = backwards,
             .max_expansions = 4'096,
             .retreats = 32};
    BOOST_TEST(!srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {}, without, {}).path.has_value());
    const srmp::OneByOneResult found = srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {}, with, {});
    BOOST_REQUIRE(found.path.has_value());
    check_path(pair, *found.path, {up, straight}, {down, straight});
    // The same problem, the same path.
    BOOST_TEST((srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {}, with, {}).path->positions ==
                found.path->positions));
  }
}

BOOST_AUTO_TEST_CASE(robots_that_turn_round_begin_exactly_at_their_starts) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0);
  // The right arm does not move, so the left one goes round by pi, though its own path goes by 0.
  FacingArms pair({up, {down}, {up, down}}, {straight, {straight}, {straight}}, "continuous");
  for (const bool backwards : {false, true}) {
    const srmp::OneByOneOptions options{
        .attempts = 4'096, .attempts_of_all = 16'384, .forwards = !backwards, .backwards = backwards};
    const srmp::OneByOneResult found = srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {}, options, {});
    BOOST_REQUIRE(found.path.has_value());
    check_path(pair, *found.path, {up, straight}, {Vector2d(2 * M_PI - 1.2, 0.0), straight});
    const srmp::RowMatrix& q = found.path->positions[0];
    for (Eigen::Index row = 1; row < q.rows(); ++row)
      BOOST_TEST((q.row(row) - q.row(row - 1)).cwiseAbs().maxCoeff() < M_PI);
  }
}

BOOST_AUTO_TEST_CASE(robots_move_along_a_known_path_at_the_same_time) {
  FacingArms pair;
  const srmp::CompositeSpace space(*pair.world, both);
  const JointPath known = space.path({space.start(), (space.start() + space.targets()[0]) / 2, space.targets()[0]}),
                  elsewhere = space.path({space.start(), space.start() * 0.9});
  for (const bool backwards : {false, true}) {
    const srmp::OneByOneResult found = srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {&known},
                                                        {.forwards = !backwards, .backwards = backwards}, {});
    BOOST_REQUIRE(found.path.has_value());
    for (const std::size_t robot : both)
      BOOST_TEST((found.path->positions[robot] - known.positions[robot]).norm() < 1e-12);
    BOOST_TEST(found.work.attempts == 0u);
  }
  for (const bool backwards : {false, true}) {  // a path to other goals is no use
    const srmp::OneByOneOptions options{.forwards = !backwards, .backwards = backwards};
    const srmp::OneByOneResult other = srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {&elsewhere},
                                                        options, {}),
                               alone = srmp::one_by_one(*pair.world, both, own_paths(*pair.world), {}, options, {});
    BOOST_REQUIRE(other.path.has_value() == alone.path.has_value());
    if (alone.path) BOOST_TEST((other.path->positions == alone.path->positions));
  }
}

BOOST_AUTO_TEST_CASE(paths_from_their_ends) {
  srmp::RowMatrix q(3, 2);
  q << 1, 2, 3, 4, 5, 6;
  const JointPath path{{0}, {0.0, 1.0, 3.0}, {q}};
  const JointPath reversed = srmp::reversed(path);
  BOOST_TEST((reversed.steps == std::vector{0.0, 2.0, 3.0}));
  for (const double step : {0.0, 0.5, 1.0, 2.0, 3.0})
    BOOST_TEST((srmp::position_at(reversed, 0, 3.0 - step) - srmp::position_at(path, 0, step)).norm() < 1e-12);
  BOOST_TEST((srmp::reversed(reversed).positions == path.positions));
}

BOOST_AUTO_TEST_CASE(no_order_of_robots_leads_to_goals_in_collision) {
  FacingArms apart(Vector2d(0.0, 0.0));  // both straight: the robots collide
  for (const bool backwards : {false, true}) {
    const srmp::OneByOneResult found = srmp::one_by_one(*apart.world, both, own_paths(*apart.world), {},
                                                        {.forwards = !backwards, .backwards = backwards}, {});
    BOOST_TEST(!found.path.has_value());
    if (backwards) BOOST_TEST(found.work.attempts == 0u);  // there is no state to begin in
  }
}

BOOST_AUTO_TEST_CASE(roadmaps_give_shorter_paths_for_smaller_weights) {
  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0);
  FacingArms pair({up, {down}, {up, down}}, {straight, {straight}, {straight}});
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

BOOST_AUTO_TEST_CASE(robots_that_need_only_wait_for_each_other_need_no_retreats) {
  const srmp::CompositeRoadmap::SearchBudget with{.max_expansions = 10'000, .max_checks = 10'000},
      without{.max_expansions = 10'000, .max_checks = 10'000, .path_expansions = 1'000};
  FacingArms waiting;
  srmp::CompositeRoadmap roadmaps(*waiting.world);
  const auto found = roadmaps.run(both, without, {});
  BOOST_REQUIRE(found.status == srmp::Status::solved);
  waiting.check_free(found.path);
  for (const std::size_t robot : both) BOOST_TEST(roadmaps.retreats(robot).empty());
  BOOST_TEST((roadmaps.run(both, with, {}).status == srmp::Status::solved));
  for (const std::size_t robot : both) BOOST_TEST(!roadmaps.retreats(robot).empty());

  const Vector2d up(1.2, 0.0), down(-1.2, 0.0), straight(0.0, 0.0);
  FacingArms passing({up, {down}, {up, down}}, {straight, {straight}, {straight}});  // one is in the other's way
  srmp::CompositeRoadmap tried(*passing.world), untried(*passing.world);
  const auto late = tried.run(both, without, {}), early = untried.run(both, with, {});
  BOOST_REQUIRE(late.status == srmp::Status::solved);
  BOOST_TEST(late.cost == early.cost);
  BOOST_TEST(late.expansions > early.expansions);
}

BOOST_AUTO_TEST_CASE(checks_that_the_deadline_cuts_off_are_not_remembered_as_collisions) {
  FacingArms pair;
  const srmp::GroupCheckers checkers(pair.planner.scene(), {"left", "right"}, {}, 1,
                                     [](const auto&... of) { return std::make_unique<const Slow>(of...); });
  const srmp::Deadline passed(-1.0), never;
  srmp::MultiRobotWorld world(checkers, {FacingArms::task_to({-1.2, 0.0}), FacingArms::task_to({-1.2, 0.0})},
                              {22.5 * M_PI / 180, 0.1});
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
  FacingArms pair;
  for (const srmp::CompositeRoadmapOptions& options :
       std::vector<srmp::CompositeRoadmapOptions>{{.retreats = 0},
                                                  {.retreat_candidates = 0},
                                                  {.branch_points = 0},
                                                  {.spacing = 0.0},
                                                  {.max_vertices = 65'536},
                                                  {.block = 0},
                                                  {.step_cost = -1.0},
                                                  {.offsets = {.joint = {NAN}}}})
    BOOST_CHECK_THROW(srmp::CompositeRoadmap(*pair.world, options), srmp::InvalidArgument);
}

BOOST_AUTO_TEST_CASE(robots_arrive_at_their_goals_exactly) {
  const Vector2d goal(-1.1, 0.3);
  FacingArms pair(goal);
  const Vector2d by(0.7, -0.9);  // 1.2 + (by - 1.2) is not by
  const JointPath path = srmp::joint_path(*pair.world, both, {{start, by, goal}, {start, by, goal}});
  for (const srmp::RowMatrix& q : path.positions) {
    BOOST_TEST((q.row(1).transpose() == by));
    BOOST_TEST((q.row(2).transpose() == goal));
  }
}

BOOST_AUTO_TEST_SUITE_END()
