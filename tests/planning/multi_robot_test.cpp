#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

namespace {

using Eigen::Vector2d;
using srmp::GoalConstraint;
using Starts = std::map<std::string, Eigen::VectorXd>;
using Goals = std::map<std::string, GoalConstraint>;

/// Two planar arms face to face, 3 m apart: straight, each is 2 m long.
///
///     left ──────── ──────── right
srmp::PlannerInterface planar_pair(const srmp::PlannerOptions& options = srmp::XECBS{.common = {.time_limit = 20}}) {
  srmp::PlannerInterface planner;
  srmp::RobotDescription description = robots::planar_description();
  description.name = "left";
  planner.add_articulation(description);
  description.name = "right";
  planner.add_articulation(description, srmp::Pose::from_rpy({3, 0, 0}, {0, 0, M_PI}));
  planner.make_planner({"left", "right"}, options);
  return planner;
}

const Starts starts{{"left", Vector2d(1.2, 0.0)}, {"right", Vector2d(1.2, 0.0)}};
const Goals goals{{"left", GoalConstraint::joints(Vector2d(-1.2, 0.0))},
                  {"right", GoalConstraint::joints(Vector2d(-1.2, 0.0))}};

/// At instants 5 ms apart.
void check_apart(srmp::PlannerInterface& planner, const srmp::MultiTrajectory& motion) {
  for (double t = 0.0; t < motion.duration(); t += 0.005) {
    for (const auto& [name, one] : motion.robots)
      planner.set_qpos(name, one.state(std::min(t, one.duration())).position);
    for (const auto& [name, one] : motion.robots)
      BOOST_CHECK(!planner.is_state_colliding(name, planner.scene().robot(name).q));
  }
}

void check_refused(srmp::Status status, const Starts& from, const Goals& to, const std::string& sentence) {
  auto planner = planar_pair();
  try {
    planner.plan_multi(from, to);
    BOOST_ERROR("no exception, expected '" + sentence + "'");
  } catch (const srmp::PlanningError& error) {
    BOOST_CHECK(error.status() == status && planner.get_planning_stats().status == status);
    BOOST_TEST(std::string(error.what()).find(sentence) != std::string::npos, error.what());
    BOOST_CHECK_EQUAL(planner.get_planning_stats().reason, error.what());
  }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(multi_robot)

BOOST_AUTO_TEST_CASE(arms_in_each_others_way_reach_their_goals) {
  const srmp::CommonOptions common{.time_limit = 20};
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::Auto{common}), srmp::PlannerOptions(srmp::XECBS{common}),
        srmp::PlannerOptions(srmp::Prioritised{common})}) {
    BOOST_TEST_CONTEXT(srmp::planner_id(options)) {
      auto planner = planar_pair(options);
      const srmp::MultiTrajectory motion = planner.plan_multi(starts, goals);
      BOOST_REQUIRE_EQUAL(motion.robots.size(), 2u);
      for (const auto& [name, one] : motion.robots) {
        BOOST_CHECK(one.positions.row(0).transpose() == starts.at(name));
        BOOST_CHECK_SMALL((one.positions.bottomRows(1).transpose() - Vector2d(-1.2, 0.0)).norm(), 1e-12);
        BOOST_REQUIRE(one.certificate);
        BOOST_CHECK(one.certificate->holds() && one.certificate->proved_free());
      }
      check_apart(planner, motion);
      const srmp::PlanStatistics& statistics = planner.get_planning_stats();
      double sum = 0.0;
      for (const auto& [name, cost] : statistics.robot_cost_rad) sum += cost;
      BOOST_CHECK_CLOSE(sum, statistics.path_cost_rad, 1e-9);
      BOOST_CHECK(statistics.bound >= 1.0);
      BOOST_CHECK_EQUAL(std::isinf(statistics.bound), srmp::planner_id(options) == "prioritised");
      BOOST_CHECK_EQUAL(statistics.makespan_s, motion.duration());
    }
  }
}

BOOST_AUTO_TEST_CASE(the_same_bits_on_every_run) {
  auto planner = planar_pair(), other = planar_pair();
  const srmp::Trajectory first = planner.plan_multi(starts, goals).merged();
  for (auto* again : {&planner, &other}) {
    const srmp::Trajectory second = again->plan_multi(starts, goals).merged();
    BOOST_CHECK(second.positions == first.positions && second.times == first.times);
  }
  BOOST_CHECK_EQUAL(planner.get_planning_stats().expansions, other.get_planning_stats().expansions);
}

BOOST_AUTO_TEST_CASE(who_holds_stays_and_who_may_end_anywhere_moves) {
  auto planner = planar_pair();
  const Starts in_the_way{{"left", Vector2d(1.2, 0.0)}, {"right", Vector2d(0.0, 1.5)}};
  Goals only_left{{"left", goals.at("left")}};
  const srmp::MultiTrajectory held = planner.plan_multi(in_the_way, only_left);
  BOOST_CHECK_EQUAL(held.at("right").positions.rows(), 1);
  check_apart(planner, held);
  only_left.emplace("right", GoalConstraint::hold());
  BOOST_CHECK(planner.plan_multi(in_the_way, only_left).merged().positions == held.merged().positions);

  // Straight ahead, it leaves no room for the other's goal.
  const Starts blocked{{"left", Vector2d(1.2, 0.0)}, {"right", Vector2d(0.0, 0.0)}};
  const Goals there{{"left", GoalConstraint::joints(Vector2d(0.0, 0.0))}, {"right", GoalConstraint::any()}};
  const srmp::MultiTrajectory any = planner.plan_multi(blocked, there);
  BOOST_CHECK_GT((any.at("right").positions.bottomRows(1).transpose() - blocked.at("right")).norm(), 0.05);
  check_apart(planner, any);
}

BOOST_AUTO_TEST_CASE(a_robot_that_holds_is_without_times_where_the_others_are) {
  auto planner = planar_pair(srmp::XECBS{.common = {.timing = "none"}});
  const auto motion = planner.plan_multi(starts, {{"left", GoalConstraint::joints(Vector2d(1.3, 0.0))}});
  BOOST_CHECK(!motion.at("right").timed());
  BOOST_CHECK_EQUAL(motion.merged().positions.cols(), 4);
}

/// On one clock, since nothing is proved of groups that are timed apart.
BOOST_AUTO_TEST_CASE(pairs_that_do_not_reach_each_other_have_the_paths_of_each_pair) {
  const srmp::PlannerOptions untimed = srmp::Auto{.common = {.time_limit = 20, .timing = "none", .certify = false}};
  auto one_pair = planar_pair(untimed);
  one_pair.plan_multi(starts, goals);
  const std::map<std::string, double> of_one_pair = one_pair.get_planning_stats().robot_cost_rad;

  srmp::PlannerInterface planner;
  std::vector<std::string> names;
  Starts all_starts;
  Goals all_goals;
  srmp::RobotDescription description = robots::planar_description();
  for (const int pair : {0, 1, 2})
    for (const std::string side : {"left", "right"}) {
      names.push_back(description.name = side + std::to_string(pair));
      const bool turned = side == "right";
      planner.add_articulation(description,
                               srmp::Pose::from_rpy({turned ? 3 : 0, 10 * pair, 0}, {0, 0, turned ? M_PI : 0}));
      all_starts[names.back()] = starts.at(side);
      all_goals.emplace(names.back(), goals.at(side));
    }
  planner.make_planner(names, untimed);
  const srmp::MultiTrajectory motion = planner.plan_multi(all_starts, all_goals);
  const Eigen::Index rows = motion.at("left0").positions.rows();
  for (const std::string& name : names) {
    BOOST_CHECK_EQUAL(motion.at(name).positions.rows(), rows);
    BOOST_CHECK_CLOSE(planner.get_planning_stats().robot_cost_rad.at(name),
                      of_one_pair.at(name.substr(0, name.size() - 1)), 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(what_cannot_be_says_why) {
  using srmp::Status;
  const GoalConstraint ahead = GoalConstraint::joints(Vector2d::Zero());
  check_refused(Status::start_invalid, {{"left", Vector2d::Zero()}, {"right", Vector2d::Zero()}}, goals,
                "the starts are invalid: 'left' and 'right' are in collision: link 'lower' and link 'right/lower'");
  check_refused(Status::goal_invalid, starts, {{"left", ahead}, {"right", ahead}},
                "the goals cannot be reached together: at them 'left' and 'right' are in collision: link 'lower'");
  check_refused(Status::goal_invalid, starts, {{"left", GoalConstraint::position({9, 0, 0})}}, "robot 'left': ");
  check_refused(Status::start_invalid, {{"left", Vector2d(4.0, 0.0)}, {"right", Vector2d(1.2, 0.0)}}, goals,
                "robot 'left': the start is invalid: a: 4 rad is above the upper limit 3 rad");
}

BOOST_AUTO_TEST_CASE(wrong_questions_are_refused) {
  auto planner = planar_pair();
  const auto refused = [&](const Starts& from, const Goals& to, const std::string& sentence) {
    check_throws<srmp::InvalidArgument>([&] { planner.plan_multi(from, to); }, sentence);
  };
  refused({{"left", Vector2d::Zero()}}, goals, "robot 'right' has a goal but no start");
  refused(starts, {{"lft", goals.at("left")}}, "'lft', did you mean 'left'");
  refused({{"left", Eigen::Vector3d::Zero()}, {"right", Vector2d::Zero()}}, {}, "start of 'left' has 3 values");
  refused(starts, {{"left", GoalConstraint::joints(Vector2d(0.0, std::nan("")))}}, "NaN");
  refused(starts, {{"left", GoalConstraint::hold()}}, "plan_multi has nothing to plan: every robot with a start holds");
  check_throws<srmp::InvalidArgument>([&] { planner.make_planner({"left", "right"}, srmp::WAStar{}); },
                                      "plans for one robot, but 2 were named");
  planner.make_planner({"left"}, srmp::Auto{});
  check_throws<srmp::InvalidArgument>([&] { planner.plan("left", Vector2d::Zero(), GoalConstraint::any()); },
                                      "a goal of type 'any' is for plan_multi");
  GoalConstraint full = GoalConstraint::hold();
  full.targets.emplace_back(Vector2d::Zero());
  check_throws<srmp::InvalidArgument>([&] { full.validate(); }, "a goal of type 'hold' has no target");
}

BOOST_AUTO_TEST_CASE(an_interrupt_cancels_and_the_time_limit_is_kept) {
  auto planner = planar_pair(srmp::CBS{.common = {.time_limit = 60, .resolution = 1}});
  const auto status = [&](const srmp::PlannerInterface::Interrupt& interrupt) {
    try {
      planner.plan_multi(starts, goals, {}, interrupt);
      return srmp::Status::solved;
    } catch (const srmp::PlanningError& error) {
      return error.status();
    }
  };
  BOOST_CHECK(status([] { return true; }) == srmp::Status::cancelled);
  planner.make_planner({"left", "right"}, srmp::CBS{.common = {.time_limit = 0.02, .resolution = 1}});
  BOOST_CHECK(status({}) == srmp::Status::timed_out);
  BOOST_CHECK(planner.get_planning_stats().total_time_s < 10);
}

BOOST_AUTO_TEST_CASE(a_plan_that_is_cancelled_in_any_round_says_so) {
  // Lattices whose budget of an earlier round was used up have ended as timed_out.
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::ECBS{.common = {.time_limit = 60, .resolution = 1}}),
        srmp::PlannerOptions(srmp::XECBS{.common = {.time_limit = 60, .resolution = 1}}),
        srmp::PlannerOptions(srmp::CBS{.common = {.time_limit = 60, .resolution = 1}})})
    for (const int polls : {2, 5, 10, 20, 40}) {
      BOOST_TEST_CONTEXT(srmp::planner_id(options) << ", stopped at poll " << polls) {
        auto planner = planar_pair(options);
        int polled = 0;
        try {
          planner.plan_multi(starts, goals, {}, [&] { return ++polled >= polls; });
          BOOST_CHECK(polled < polls);
        } catch (const srmp::PlanningError& error) {
          BOOST_CHECK_MESSAGE(error.status() == srmp::Status::cancelled, error.what());
        }
      }
    }
}

BOOST_AUTO_TEST_CASE(a_robot_that_is_at_its_goal_gets_out_of_the_way_and_returns) {
  const srmp::CommonOptions common{.time_limit = 20};
  const Starts from{{"left", Vector2d(0.0, 0.0)}, {"right", Vector2d(1.2, 0.0)}};
  const Goals to{{"left", GoalConstraint::joints(Vector2d(0.0, 0.0))},
                 {"right", GoalConstraint::joints(Vector2d(-1.2, 0.0))}};
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::Auto{common}), srmp::PlannerOptions(srmp::XECBS{common}),
        srmp::PlannerOptions(srmp::Prioritised{common})}) {
    BOOST_TEST_CONTEXT(srmp::planner_id(options)) {
      auto planner = planar_pair(options);
      const srmp::MultiTrajectory motion = planner.plan_multi(from, to);
      check_apart(planner, motion);
      for (const auto& [name, one] : motion.robots)
        BOOST_TEST((one.positions.bottomRows(1).transpose() - Vector2d(name == "left" ? 0.0 : -1.2, 0.0)).norm() <
                   1e-12);
    }
  }
}

/// No random trees, no roadmaps, no composite space: the constraint tree finds the paths wherever robots interact.
BOOST_AUTO_TEST_CASE(planners_by_conflicts_search_by_conflicts_alone) {
  const srmp::CommonOptions common{.time_limit = 20};
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::XECBS{common}), srmp::PlannerOptions(srmp::Prioritised{common})}) {
    BOOST_TEST_CONTEXT(srmp::planner_id(options)) {
      auto planner = planar_pair(options);
      planner.plan_multi(starts, goals);
      const srmp::PlanStatistics& statistics = planner.get_planning_stats();
      BOOST_TEST(statistics.tree_nodes >= 1u);
      BOOST_TEST(statistics.samples == 0u);
      BOOST_TEST(statistics.found_by.starts_with("conflict-based search"), statistics.found_by);
    }
  }
}

BOOST_AUTO_TEST_CASE(rounds_of_improvement_are_the_same_every_time_and_never_for_the_worse) {
  double cost = INFINITY;
  std::string found_by;
  for (const int rounds : {0, 1, 6}) {
    const srmp::Auto options{.common = {.time_limit = 20}, .improve_rounds = rounds};
    auto planner = planar_pair(options), again = planar_pair(options);
    const srmp::MultiTrajectory motion = planner.plan_multi(starts, goals);
    check_apart(planner, motion);
    for (const auto& [name, trajectory] : again.plan_multi(starts, goals).robots)
      BOOST_TEST((trajectory.positions == motion.robots.at(name).positions));
    BOOST_TEST(planner.get_planning_stats().path_cost_rad <= cost);
    if (planner.get_planning_stats().path_cost_rad < cost && rounds > 0) found_by = "composite RRT-Connect";
    if (rounds == 0) found_by = planner.get_planning_stats().found_by;
    BOOST_TEST(planner.get_planning_stats().found_by == found_by);
    cost = planner.get_planning_stats().path_cost_rad;
  }
}

BOOST_AUTO_TEST_CASE(auto_improves_for_as_long_as_asked_and_never_for_the_worse) {
  auto first = planar_pair(srmp::Auto{.common = {.time_limit = 20}});
  first.plan_multi(starts, goals);
  const double cost = first.get_planning_stats().path_cost_rad;
  BOOST_TEST(first.get_planning_stats().solutions.size() == 1u);

  auto planner = planar_pair(srmp::Auto{.common = {.time_limit = 20}, .improve_time = 0.5});
  const srmp::MultiTrajectory motion = planner.plan_multi(starts, goals);
  check_apart(planner, motion);
  const srmp::PlanStatistics& statistics = planner.get_planning_stats();
  BOOST_TEST(statistics.path_cost_rad <= cost);
  BOOST_TEST(statistics.plan_time_s < 5);
  for (std::size_t i = 1; i < statistics.solutions.size(); ++i) {
    BOOST_TEST(statistics.solutions[i].cost_rad < statistics.solutions[i - 1].cost_rad);
    BOOST_TEST(statistics.solutions[i].bound <= statistics.solutions[i - 1].bound);
  }
  BOOST_TEST(statistics.solutions.back().cost_rad == statistics.path_cost_rad);

  BOOST_CHECK_THROW(planar_pair(srmp::Auto{.improve_rounds = -1}), srmp::InvalidArgument);

  auto enough = planar_pair(srmp::Auto{.common = {.time_limit = 20}, .improve_time = 10, .final_weight = 50});
  enough.plan_multi(starts, goals);
  BOOST_TEST(enough.get_planning_stats().plan_time_s < 5);  // the bound that was asked for is there at once
}

BOOST_AUTO_TEST_SUITE_END()
