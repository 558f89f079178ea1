#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <limits>

#include "srmp/collision/scene_checker.hpp"
#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

namespace {

using srmp::GoalConstraint;
using srmp::RowMatrix;
using srmp::Trajectory;
using Q = Eigen::Vector2d;

const srmp::XECBS patient{.common = {.time_limit = 120}};  // under sanitizers too

/// Two planar arms whose stretched arms reach into each other's half:   left ·──·──      ──·──· right
srmp::PlannerInterface two_arms(const srmp::PlannerOptions& options = patient) {
  srmp::PlannerInterface planner;
  for (const std::string name : {"left", "right"}) {
    srmp::RobotDescription description = robots::planar_description();
    description.name = name;
    planner.add_articulation(description, srmp::Pose::from_rpy({name == "left" ? 0.0 : 3.0, 0.0, 0.0},
                                                               {0.0, 0.0, name == "left" ? 0.0 : M_PI}));
  }
  planner.make_planner({"left"}, options);
  return planner;
}

/// Straight from row to row, with no velocities.
Trajectory motion(const std::vector<double>& times, const std::vector<Q>& rows) {
  Trajectory result{.joint_names = {"a", "b"}, .positions = RowMatrix(static_cast<Eigen::Index>(rows.size()), 2)};
  for (std::size_t i = 0; i < rows.size(); ++i)
    result.positions.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  return result;
}

/// The third stands above the middle and reaches down into it.
void add_third(srmp::PlannerInterface& planner, const srmp::PlannerOptions& options = patient) {
  srmp::RobotDescription third = robots::planar_description();
  third.name = "third";
  planner.add_articulation(third, srmp::Pose::from_rpy({1.5, 2.4, 0.0}, {0.0, 0.0, -M_PI / 2.0}));
  planner.make_planner({"left", "third"}, options);
}

/// Stretched, from one side through the middle to the other.
Trajectory sweep(double duration = 3.0) { return motion({0.0, duration}, {Q(-1.2, 0.0), Q(1.2, 0.0)}); }

const Q start(-1.2, 0.0), goal(1.2, 0.0);  // across the middle too, towards the other one

Trajectory plan(srmp::PlannerInterface& planner, const Trajectory& obstacle, const Q& from = start,
                const Q& to = goal) {
  return planner.plan_multi({{"left", from}}, {{"left", GoalConstraint::joints(to)}}, {{"right", obstacle}}).at("left");
}

/// The smallest distance at instants 1 ms apart.
double distance(const srmp::PlannerInterface& planner, const Trajectory& left, const Trajectory& right,
                const std::string& one = "left", const std::string& other = "right") {
  const srmp::SceneChecker both(planner.scene(), one,
                                {.mode = srmp::CheckMode::coal, .other_robots = {other}, .other_robots_only = true});
  const auto workspace = both.make_workspace();
  double least = 1e9;
  for (double t = 0.0; t <= std::max(left.duration(), right.duration()); t += 1e-3) {
    Eigen::Vector4d q;
    q << left.sample(t), right.sample(t);
    least = std::min(least, both.nearest(q, *workspace)->distance);
  }
  return least;
}

double wait(const Trajectory& trajectory) {
  Eigen::Index row = 0;
  while (trajectory.positions.row(row + 1) == trajectory.positions.row(0)) ++row;
  return trajectory.times[row];
}

}  // namespace

BOOST_AUTO_TEST_SUITE(committed)

BOOST_AUTO_TEST_CASE(a_robot_waits_until_the_other_has_passed) {
  for (const double duration : {2.0, 3.0, 8.0}) {
    auto planner = two_arms();
    const Trajectory obstacle = sweep(duration);
    const Trajectory left = plan(planner, obstacle);
    BOOST_CHECK_GT(distance(planner, left, obstacle), 0.0);
    BOOST_CHECK_EQUAL(left.times[0], 0.0);
    BOOST_CHECK_LE(wait(left), duration);
    BOOST_CHECK(left.velocities.row(0).isZero(0.0));
    BOOST_REQUIRE(left.certificate);
    BOOST_CHECK(left.certificate->holds() && left.certificate->proved_free());
    BOOST_CHECK(left.certificate->body_b.starts_with("right/"));
    BOOST_CHECK_GT(left.certificate->clearance_proved, 0.0);
    BOOST_CHECK_LE(left.certificate->clearance_proved, distance(planner, left, obstacle) + 1e-9);
    BOOST_CHECK_LT(left.certificate->goal_error, 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(no_longer_than_it_must) {
  auto planner = two_arms();
  const Trajectory obstacle = sweep(1.5);
  const Trajectory left = plan(planner, obstacle);
  const double delay = wait(left);
  BOOST_REQUIRE_GT(delay, 0.05);
  for (double sooner = 0.0; sooner < delay - 0.05; sooner += 0.1) {
    Trajectory begun = left;
    begun.times = (left.times.array() - delay + sooner).max(0.0);
    BOOST_CHECK_LE(distance(planner, begun.slice(0.0, begun.duration()), obstacle), 1e-3);
  }
}

BOOST_AUTO_TEST_CASE(nobody_waits_for_one_who_is_not_in_the_way) {
  auto planner = two_arms();
  const Trajectory obstacle = motion({0.0, 2.0}, {Q(-3.0, 0.0), Q(-2.0, 0.0)});
  BOOST_CHECK_EQUAL(wait(plan(planner, obstacle)), 0.0);
  BOOST_CHECK_NE(planner.get_planning_stats().found_by, "safe-interval path planning");
}

BOOST_AUTO_TEST_CASE(statistics_count_the_wait) {
  auto planner = two_arms();
  const Trajectory left = plan(planner, sweep());
  const srmp::PlanStatistics& statistics = planner.get_planning_stats();
  BOOST_CHECK_EQUAL(statistics.makespan_s, left.duration());
  BOOST_CHECK_CLOSE(statistics.flow_time_s, left.duration(), 1e-9);
  BOOST_CHECK(statistics.status == srmp::Status::solved);
}

BOOST_AUTO_TEST_CASE(the_same_on_every_run) {
  auto first = two_arms(), second = two_arms();
  BOOST_CHECK(plan(first, sweep()).positions == plan(second, sweep()).positions);
  BOOST_CHECK(plan(first, sweep()).times == plan(second, sweep()).times);
}

BOOST_AUTO_TEST_CASE(where_an_obstacle_ends_nobody_else_can) {
  auto planner = two_arms();
  const Trajectory obstacle = motion({0.0, 2.0}, {Q(1.5, 0.0), Q(0.0, 0.0)});
  try {
    plan(planner, obstacle, start, Q(0.0, 0.0));
    BOOST_ERROR("planned");
  } catch (const srmp::PlanningError& error) {
    BOOST_CHECK(error.status() == srmp::Status::goal_invalid);
    BOOST_CHECK_NE(std::string(error.what()).find("right/lower"), std::string::npos);
    BOOST_CHECK(planner.get_planning_stats().status == srmp::Status::goal_invalid);
  }
}

BOOST_AUTO_TEST_CASE(what_no_wait_helps_is_said_with_links_and_time) {
  const auto fails = [](const Trajectory& obstacle, const Q& from, srmp::Status status, const std::string& sentence) {
    auto planner = two_arms();
    try {
      plan(planner, obstacle, from, goal);
      BOOST_ERROR("planned: " + sentence);
    } catch (const srmp::PlanningError& error) {
      BOOST_CHECK_EQUAL(to_string(error.status()), to_string(status));
      BOOST_TEST(std::string(error.what()).find(sentence) != std::string::npos, error.what());
      BOOST_CHECK_EQUAL(planner.get_planning_stats().reason, error.what());
    }
  };
  // The left arm waits in the middle, where the right one soon passes.
  fails(sweep(0.6), Q(0.3, 0.0), srmp::Status::exhausted, "passes through where a robot waits");
  fails(sweep(0.6), Q(0.3, 0.0), srmp::Status::exhausted, "'left/lower' and 'right/lower' touch at ");
  fails(motion({0.0, 1.0}, {Q(0.0, 0.0), Q(2.0, 0.0)}), Q(0.0, 0.0), srmp::Status::start_invalid,
        "begins where 'left' starts: 'left/lower' and 'right/lower'");
  fails(motion({0.0, 0.1}, {Q(2.0, 0.0), Q(0.0, 0.0)}), Q(0.0, 0.0), srmp::Status::start_invalid,
        "ends where 'left' starts: 'left/lower' and 'right/lower'");
}

BOOST_AUTO_TEST_CASE(a_robot_leaves_where_the_other_passes) {
  struct Question {
    Trajectory obstacle;
    Q from, to;
  };
  const std::vector<Question> questions{
      {sweep(), Q(0.3, 0.0), goal},                                        // leaves in time
      {sweep(), Q(0.3, 0.0), Q(0.3, 0.0)},                                 // makes way and comes back
      {motion({0.0, 3.0}, {Q(2.0, 0.0), Q(0.0, 0.0)}), Q(0.0, 0.0), goal}  // the other ends there
  };
  for (const auto& [obstacle, from, to] : questions) {
    auto planner = two_arms();
    BOOST_CHECK_LE(distance(planner, motion({0.0, 3.0}, {from, from}), obstacle), 0.0);
    const Trajectory left = plan(planner, obstacle, from, to);
    BOOST_CHECK_GT(distance(planner, left, obstacle), 0.0);
    BOOST_REQUIRE(left.certificate);
    BOOST_CHECK(left.certificate->holds() && left.certificate->proved_free());
    BOOST_CHECK(left.positions.row(0) == from.transpose());
    BOOST_CHECK(left.positions.bottomRows(1) == to.transpose());
    BOOST_CHECK_LT(left.certificate->goal_error, 1e-9);
    const srmp::PlanStatistics& statistics = planner.get_planning_stats();
    BOOST_CHECK(statistics.status == srmp::Status::solved && statistics.reason.empty());
    BOOST_CHECK_EQUAL(statistics.makespan_s, left.duration());
    auto again = two_arms();
    const Trajectory same = plan(again, obstacle, from, to);
    BOOST_CHECK(same.positions == left.positions && same.times == left.times);
  }
}

BOOST_AUTO_TEST_CASE(several_robots_make_way_for_the_others_and_for_each_other) {
  auto planner = two_arms();
  add_third(planner);  // the right one passes both
  const std::map<std::string, Eigen::VectorXd> starts{{"left", Q(-0.2, 0.0)}, {"third", Q(0.0, 0.0)}};
  const std::map<std::string, GoalConstraint> goals{{"left", GoalConstraint::joints(Q(-0.2, 0.0))},
                                                    {"third", GoalConstraint::joints(Q(0.0, 0.0))}};
  const Trajectory obstacle = motion({0.0, 4.0}, {Q(1.2, 0.0), Q(-1.2, 0.0)});
  const auto found = planner.plan_multi(starts, goals, {{"right", obstacle}});
  for (const std::string name : {"left", "third"}) {
    const Trajectory& trajectory = found.at(name);
    BOOST_REQUIRE(trajectory.certificate);
    BOOST_CHECK(trajectory.certificate->holds() && trajectory.certificate->proved_free());
    BOOST_CHECK(trajectory.positions.bottomRows(1) == starts.at(name).transpose());
  }
  BOOST_CHECK_GT(distance(planner, found.at("left"), obstacle), 0.0);
  BOOST_CHECK_GT(distance(planner, found.at("third"), obstacle, "third", "right"), 0.0);
  BOOST_CHECK_GT(distance(planner, found.at("left"), found.at("third"), "left", "third"), 0.0);
  const srmp::PlanStatistics& statistics = planner.get_planning_stats();
  BOOST_CHECK_EQUAL(statistics.makespan_s, found.duration());
  BOOST_CHECK(statistics.memory_bytes > 0 && statistics.edge_checks > 0);
  BOOST_CHECK(statistics.plan_time_s > 0.0 && statistics.plan_time_s <= statistics.total_time_s);
}

BOOST_AUTO_TEST_CASE(starts_and_goals_are_judged_before_anybody_is_planned_around) {
  const auto fails = [](const Q& right_end, const Q& left, const Q& left_goal, const Q& third, const Q& third_goal,
                        srmp::Status status, const std::string& sentence) {
    auto planner = two_arms();
    add_third(planner);
    const Trajectory obstacle = motion({0.0, 3.0}, {Q(2.0, 0.0), right_end});  // where the left one starts
    try {
      planner.plan_multi({{"left", left}, {"third", third}},
                         {{"left", GoalConstraint::joints(left_goal)}, {"third", GoalConstraint::joints(third_goal)}},
                         {{"right", obstacle}});
      BOOST_ERROR("planned: " + sentence);
    } catch (const srmp::PlanningError& error) {
      BOOST_CHECK_EQUAL(to_string(error.status()), to_string(status));
      BOOST_TEST(std::string(error.what()).find(sentence) != std::string::npos, error.what());
      BOOST_CHECK_EQUAL(planner.get_planning_stats().robot_cost_rad.size(), 2u);
      BOOST_CHECK(planner.last_result() && !std::get<srmp::MultiPlanResult>(*planner.last_result()).solved());
    }
  };
  const Q middle(0.0, 0.0), up(M_PI / 2.0, 0.0);
  fails(Q(-0.3, 0.0), Q(0.3, 0.0), Q(1.2, 0.0), Q(0.2, 0.0), up, srmp::Status::start_invalid,
        "the starts are invalid: 'left' and 'third'");
  fails(middle, middle, middle, up, up, srmp::Status::goal_invalid,
        "robot 'left': the goal is invalid: link 'lower' and link 'right/lower'");
  fails(middle, middle, Q(0.5, 0.0), up, Q(-0.3, 0.0), srmp::Status::goal_invalid,
        "the goals cannot be reached together");
}

BOOST_AUTO_TEST_CASE(statistics_of_a_plan_of_many_name_its_robots_even_if_it_ends_at_once) {
  auto planner = two_arms();
  add_third(planner);
  const std::map<std::string, GoalConstraint> goals{{"left", GoalConstraint::joints(goal)}};
  const std::map<std::string, double> none{{"left", 0.0}};
  planner.add_sphere("sphere", 0.2, {.p = {1.5, 1.4, 0.0}});  // in the third arm, which holds
  BOOST_CHECK_THROW(planner.plan_multi({{"left", start}, {"third", Q(0.0, 0.0)}}, goals), srmp::PlanningError);
  BOOST_CHECK(planner.get_planning_stats().robot_cost_rad == none);
  planner.remove_object("sphere");
  planner.make_planner({"left"}, patient);
  BOOST_CHECK_THROW(
      planner.plan_multi({{"left", Q(0.0, 0.0)}}, goals, {{"right", motion({0.0, 1.0}, {Q(0.0, 0.0), Q(1.2, 0.0)})}}),
      srmp::PlanningError);
  BOOST_CHECK(planner.get_planning_stats().robot_cost_rad == none);
}

BOOST_AUTO_TEST_CASE(short_of_time_it_says_so_or_returns_what_holds) {
  // A wait helps the first question, the others only what is planned in time; for the last two there is nothing.
  const std::vector<std::pair<Trajectory, Q>> questions{{sweep(8.0), start},
                                                        {motion({0.0, 30.0}, {Q(-0.1, 0.9), Q(0.1, 0.9)}), start},
                                                        {sweep(), Q(0.3, 0.0)},
                                                        {sweep(0.6), Q(0.3, 0.0)},
                                                        {sweep(100.0), Q(0.3, 0.0)}};
  for (const auto& [obstacle, from] : questions)
    for (const double limit : {1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1}) {
      auto planner = two_arms(srmp::XECBS{.common = {.time_limit = limit}});
      try {
        const Trajectory left = plan(planner, obstacle, from);
        BOOST_REQUIRE(left.certificate);
        BOOST_CHECK(left.certificate->holds());
        const srmp::PlanStatistics& statistics = planner.get_planning_stats();
        BOOST_CHECK(left.certificate->proved_free() || statistics.total_time_s > limit);
        BOOST_CHECK_GT(distance(planner, left, obstacle), 0.0);
      } catch (const srmp::PlanningError& error) {
        const bool never = from != start && obstacle.duration() == 0.6;
        BOOST_CHECK(error.status() == srmp::Status::timed_out || (never && error.status() == srmp::Status::exhausted));
        BOOST_CHECK(planner.get_planning_stats().status == error.status());
      }
    }
}

BOOST_AUTO_TEST_CASE(it_can_be_interrupted_at_any_time) {
  const std::vector<std::pair<Trajectory, Q>> questions{{sweep(8.0), start}, {sweep(0.6), Q(0.3, 0.0)}};
  for (const auto& [obstacle, from] : questions)
    for (const int calls : {0, 1, 2, 5, 10}) {
      auto planner = two_arms();
      int called = 0;
      const auto interrupt = [&] { return called++ >= calls; };
      try {
        const auto found = planner.plan_multi({{"left", from}}, {{"left", GoalConstraint::joints(goal)}},
                                              {{"right", obstacle}}, interrupt);
        BOOST_CHECK(found.at("left").certificate->holds());
      } catch (const srmp::PlanningError& error) {
        BOOST_CHECK(error.status() == (called > calls ? srmp::Status::cancelled : srmp::Status::exhausted));
      }
    }
}

BOOST_AUTO_TEST_CASE(a_way_round_that_ends_sooner_is_preferred) {
  auto planner = two_arms();
  const Trajectory slow = motion({0.0, 30.0}, {Q(-0.1, 0.9), Q(0.1, 0.9)});  // in the middle all the while
  const Trajectory left = plan(planner, slow);
  BOOST_CHECK_LT(left.duration(), 10.0);
  BOOST_CHECK_GT(distance(planner, left, slow), 0.0);
  BOOST_CHECK_EQUAL(planner.get_planning_stats().bound, std::numeric_limits<double>::infinity());
  BOOST_CHECK_EQUAL(planner.get_planning_stats().makespan_s, left.duration());
  BOOST_CHECK_EQUAL(planner.get_planning_stats().found_by, "safe-interval path planning");
}

BOOST_AUTO_TEST_CASE(one_that_may_end_anywhere_is_passed) {
  auto planner = two_arms();
  const auto found =
      planner.plan_multi({{"left", Q(0.0, 0.0)}}, {{"left", GoalConstraint::any()}}, {{"right", sweep()}});
  BOOST_CHECK_GT(distance(planner, found.at("left"), sweep()), 0.0);
}

BOOST_AUTO_TEST_CASE(a_robot_that_holds_cannot_be_run_into) {
  auto planner = two_arms();
  srmp::RobotDescription third = robots::planar_description();
  third.name = "third";
  planner.add_articulation(third, {.p = {1.5, -10.0, 0.0}});
  planner.make_planner({"left", "third"}, patient);
  const auto call = [&] {
    planner.plan_multi({{"left", Q(0.0, 0.0)}, {"third", Q(0.0, 0.0)}},
                       {{"third", GoalConstraint::joints(Q(1.0, 0.0))}}, {{"right", sweep()}});
  };
  check_throws<srmp::PlanningError>(call, "'right' passes through 'left', which holds: 'left/lower' and 'right/lower'");
}

BOOST_AUTO_TEST_CASE(between_rows_and_at_corners_too) {
  // Rows that are free, and a way between them that is not: it goes through the middle.
  auto planner = two_arms();
  const Trajectory obstacle = motion({0.0, 0.01, 5.0}, {Q(1.2, 0.0), Q(-1.2, 0.0), Q(-1.25, 0.0)});
  check_throws<srmp::PlanningError>([&] { plan(planner, obstacle, Q(0.2, 0.0), goal); }, "touch at 0.00");
}

BOOST_AUTO_TEST_CASE(wrong_obstacles_are_refused) {
  auto planner = two_arms();
  const auto refused = [&](const std::string& name, const Trajectory& obstacle, const std::string& sentence) {
    const auto call = [&] {
      planner.plan_multi({{"left", start}}, {{"left", GoalConstraint::joints(goal)}}, {{name, obstacle}});
    };
    check_throws<srmp::InvalidArgument>(call, sentence);
  };
  refused("rihgt", sweep(), "did you mean 'right'?");
  refused("left", sweep(), "robot 'left' has a start and is an obstacle too");
  Trajectory wrong = sweep();
  wrong.joint_names = {"a", "c"};
  refused("right", wrong, "obstacle 'right': the joints are 'a' and 'c', but those of robot 'right' are 'a' and 'b'");
  wrong = sweep();
  wrong.times.resize(0);
  refused("right", wrong, "obstacle 'right': the trajectory has no times");
  wrong = sweep();
  wrong.times.array() += 1.0;
  refused("right", wrong, "obstacle 'right': the trajectory begins at 1 s");
  wrong = sweep();
  wrong.positions(1, 0) = NAN;
  refused("right", wrong, "obstacle 'right': trajectory: positions, row 1");
  wrong = sweep();
  wrong.positions(1, 0) = 3.5;
  refused("right", wrong, "obstacle 'right': a: the position is 3.5");
  refused("right", Trajectory{}, "obstacle 'right': trajectory: it has no rows");
  planner.make_planner({"left"}, srmp::XECBS{.common = {.timing = "none"}});
  refused("right", sweep(), "timing is 'none'");
  planner.make_planner({"left"}, srmp::WAStar{});
  refused("right", sweep(), "planner 'wAstar' plans for one robot");
}

BOOST_AUTO_TEST_SUITE_END()
