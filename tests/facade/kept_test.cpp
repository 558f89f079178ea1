#include <algorithm>
#include <array>
#include <boost/test/unit_test.hpp>
#include <limits>

#include "io/temp_file.hpp"
#include "srmp/io/trajectory_file.hpp"
#include "srmp/planner_interface.hpp"
#include "support/files.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

namespace {

using Eigen::Vector2d;
using srmp::GoalConstraint;
using srmp::MultiPlanRequest;
using srmp::MultiPlanResult;
using srmp::PlannerInterface;
using srmp::Trajectory;

const std::vector<std::string> asked{"holder", "idler", "left", "right"};

/// Planar arms, 2 m long; the first two are in each other's way.
///
///     left ──── ──── right      idler ────      holder and committed above and below
PlannerInterface five_arms(const srmp::PlannerOptions& options = srmp::XECBS{.common = {.time_limit = 20}}) {
  PlannerInterface planner;
  const std::map<std::string, std::array<double, 3>> bases{{"left", {0, 0, 0}},
                                                           {"right", {3, 0, M_PI}},
                                                           {"idler", {6, 0, 0}},
                                                           {"holder", {1.5, 4.6, -M_PI / 2}},
                                                           {"committed", {1.5, -4.6, M_PI / 2}}};
  srmp::RobotDescription description = robots::planar_description();
  for (const auto& [name, base] : bases) {
    description.name = name;
    planner.add_articulation(description, srmp::Pose::from_rpy({base[0], base[1], 0}, {0, 0, base[2]}));
  }
  planner.make_planner(asked, options);
  return planner;
}

/// Goals of every type, and a motion that is settled.
MultiPlanRequest request(const PlannerInterface& planner) {
  MultiPlanRequest r;
  r.starts = {{"left", Vector2d(1.2, 0.0)},
              {"right", Vector2d(1.2, 0.4)},
              {"idler", Vector2d(0.1 / 3, 0.0)},
              {"holder", Vector2d(0.0, 0.1 / 3)}};
  GoalConstraint pose = GoalConstraint::pose(planner.compute_fk("right", Vector2d(-1.2, 0.4)));
  pose.rotation_tolerance = {0.1, 0.1 / 3, std::numeric_limits<double>::infinity()};
  GoalConstraint either = GoalConstraint::joints(Vector2d(-1.2, 0.0));
  either.targets.emplace_back(Vector2d(-1.1, 0.0));
  r.goals = {{"left", either}, {"right", pose}, {"idler", GoalConstraint::any()}, {"holder", GoalConstraint::hold()}};
  Trajectory motion{.joint_names = {"a", "b"}, .positions = srmp::RowMatrix(2, 2)};
  motion.positions << -1.2, 0.0, 1.2, 0.1 / 3;
  motion.times = Vector2d(0.0, 2.0);
  r.obstacles = {{"committed", motion}};
  return r;
}

srmp::MultiTrajectory plan(PlannerInterface& planner) {
  const MultiPlanRequest r = request(planner);
  return planner.plan_multi(r.starts, r.goals, r.obstacles);
}

const MultiPlanRequest& request_of(const PlannerInterface& planner) {
  return std::get<MultiPlanRequest>(*planner.last_request());
}
const MultiPlanResult& result_of(const PlannerInterface& planner) {
  return std::get<MultiPlanResult>(*planner.last_result());
}

PlannerInterface reloaded(const PlannerInterface& planner) {
  const TemporaryDirectory directory;
  planner.save(directory.path("p.json"));
  return PlannerInterface::load(directory.path("p.json"));
}

std::string text_of(const PlannerInterface& planner) {
  const TemporaryDirectory directory;
  planner.save(directory.path("p.json"));
  return read_text(directory.path("p.json"));
}

bool same(const Trajectory& a, const Trajectory& b) {
  return a.joint_names == b.joint_names && a.positions == b.positions && a.velocities == b.velocities &&
         a.accelerations == b.accelerations && a.times == b.times && a.waypoints == b.waypoints;
}

bool same(const srmp::MultiTrajectory& a, const srmp::MultiTrajectory& b) {
  return a.robots.size() == b.robots.size() && std::all_of(a.robots.begin(), a.robots.end(), [&](const auto& one) {
           return same(one.second, b.at(one.first));
         });
}

}  // namespace

BOOST_AUTO_TEST_SUITE(kept)

BOOST_AUTO_TEST_CASE(a_question_to_many_plans_again_to_the_same_answer) {
  auto planner = five_arms();
  const srmp::MultiTrajectory motion = plan(planner);
  auto read = reloaded(planner);
  BOOST_CHECK_EQUAL(text_of(read), text_of(planner));
  BOOST_CHECK(same(result_of(read).trajectory(), motion));
  const MultiPlanRequest &back = request_of(read), there = request(planner);
  BOOST_CHECK(back.starts == there.starts);
  BOOST_REQUIRE_EQUAL(back.goals.size(), there.goals.size());
  for (const auto& [name, goal] : there.goals) {
    const GoalConstraint& its = back.goals.at(name);
    BOOST_CHECK(its.type == goal.type && its.targets == goal.targets);
    BOOST_CHECK(its.position_tolerance == goal.position_tolerance && its.rotation_tolerance == goal.rotation_tolerance);
  }
  BOOST_CHECK(same(back.obstacles.at("committed"), there.obstacles.at("committed")));
  const srmp::PlanStatistics &then = planner.get_planning_stats(), &now = read.get_planning_stats();
  BOOST_CHECK(now.robot_cost_rad == then.robot_cost_rad && now.tree_nodes == then.tree_nodes);
  BOOST_CHECK(now.makespan_s == then.makespan_s && now.flow_time_s == then.flow_time_s);
  BOOST_CHECK(same(read.plan_multi(back.starts, back.goals, back.obstacles), motion));  // its own, not a copy
  BOOST_CHECK_EQUAL(now.expansions, then.expansions);
}

BOOST_AUTO_TEST_CASE(the_last_question_counts_whatever_it_was) {
  auto planner = five_arms();
  planner.make_planner({"left"}, srmp::Auto{});
  plan(planner);
  BOOST_CHECK(std::holds_alternative<MultiPlanRequest>(*planner.last_request()));
  planner.plan("left", Vector2d(1.2, 0.0), GoalConstraint::joints(Vector2d(1.3, 0.0)));
  BOOST_CHECK(std::holds_alternative<srmp::PlanRequest>(*reloaded(planner).last_request()));
  BOOST_CHECK(std::holds_alternative<srmp::PlanResult>(*reloaded(planner).last_result()));
  BOOST_CHECK(reloaded(planner).get_planning_stats().robot_cost_rad.empty());
}

BOOST_AUTO_TEST_CASE(a_question_without_an_answer_is_kept_with_the_reason) {
  auto planner = five_arms();
  MultiPlanRequest r = request(planner);
  for (const char* robot : {"left", "holder"}) {  // one that moves, one that holds
    r.starts.at(robot) = Vector2d(0.0, 3.0);
    const auto far = [&] { planner.plan_multi(r.starts, {{"left", GoalConstraint::position({9, 9, 0})}}); };
    BOOST_CHECK_THROW(far(), srmp::PlanningError);
    const auto read = reloaded(planner);
    BOOST_CHECK(!result_of(read).solved());
    BOOST_CHECK(result_of(read).status() == planner.get_planning_stats().status);
    BOOST_CHECK_EQUAL(result_of(read).reason(), planner.get_planning_stats().reason);
    check_throws<srmp::PlanningError>([&] { result_of(read).trajectory(); }, planner.get_planning_stats().reason);
    BOOST_CHECK_EQUAL(request_of(read).goals.size(), 1u);
  }
}

BOOST_AUTO_TEST_CASE(an_answer_goes_when_what_it_depends_on_changes) {
  auto planner = five_arms();
  plan(planner);
  const MultiPlanRequest r = request(planner);
  check_throws<srmp::InvalidArgument>([&] { planner.plan_multi(r.starts, r.goals, {{"left", Trajectory{}}}); }, "left");
  BOOST_CHECK(planner.last_request() && planner.last_result());  // a refused call changes nothing
  planner.add_box("box", {0.1, 0.1, 0.1}, srmp::Pose::from_rpy({9, 9, 9}, {0, 0, 0}));
  BOOST_CHECK(planner.last_request() && !planner.last_result());
  BOOST_CHECK(reloaded(planner).last_request() && !reloaded(planner).last_result());
  planner.make_planner(asked, srmp::XECBS{.common = {.timing = "none"}});  // which takes no obstacles: asked before
  BOOST_CHECK(reloaded(planner).last_request());
  planner.remove_articulation("committed");
  BOOST_CHECK(!planner.last_request());
}

BOOST_AUTO_TEST_CASE(no_trajectory_of_one_robot_is_in_it) {
  auto planner = five_arms();
  plan(planner);
  const TemporaryDirectory directory;
  planner.save(directory.path("p.json"));
  check_throws<srmp::FileError>([&] { srmp::io::load_trajectory(directory.path("p.json")); },
                                "it holds the trajectories of a plan_multi, not one");
}

BOOST_AUTO_TEST_CASE(wrong_questions_are_refused_with_the_place) {
  auto planner = five_arms();
  plan(planner);
  const std::string text = text_of(planner);
  const std::size_t request_at = text.find("\"request\":"), result_at = text.find("\"result\":");
  BOOST_REQUIRE(request_at < result_at && result_at != std::string::npos);
  const auto check = [&](std::size_t after, const std::string& from, const std::string& to, const std::string& what) {
    const TemporaryDirectory directory;
    const std::size_t at = text.find(from, after);
    BOOST_REQUIRE_MESSAGE(at != std::string::npos, from);
    const std::string path = directory.write("p.json", std::string(text).replace(at, from.size(), to));
    check_throws<srmp::FileError>([&] { PlannerInterface::load(path); }, what);
    check_throws<srmp::FileError>([&] { PlannerInterface::load(path); }, path + ":");
  };
  const auto asks = [&](const std::string& from, const std::string& to, const std::string& what) {
    check(request_at, from, to, what);
  };
  const auto answers = [&](const std::string& from, const std::string& to, const std::string& what) {
    check(result_at, from, to, what);
  };
  asks("\"starts\":", "\"beginnings\":", "request: it has neither 'robot', as one of plan has, nor 'starts'");
  asks("\"goals\":", "\"aims\":", "request: it has no 'goals'");
  asks("\"obstacles\":", "\"others\":", "request: it has no 'obstacles'");
  asks("\"obstacles\":", "\"robot\": \"left\",\n\"obstacles\":", "unknown key 'robot' in request");
  asks("\"left\": [1.2, 0]", "\"lft\": [1.2, 0]", "request: unknown robot 'lft', did you mean 'left'");
  asks("\"holder\": [0, ", "\"hold\": [0, ", "request: unknown robot 'hold', did you mean 'holder'");
  asks("\"left\": [1.2, 0]", "\"left\": [1.2, 0],\n\"lft\": [1.2, 0]", "request: unknown robot 'lft', did you mean");
  asks("\"left\": [1.2, 0]", "\"left\": [1.2]", "request: start of 'left' has 1 values");
  asks("\"left\": [1.2, 0]", "\"left\": [1.2, \"nan\"]", "request: start of 'left': b is NaN");
  asks("\"left\": [1.2, 0]", "\"left\": \"up\"", "request.starts.left must be a list");
  asks("\"left\": {", "\"lft\": {", "request: unknown robot 'lft', did you mean 'left'");
  asks("\"type\": \"hold\"", "\"type\": \"holds\"", "request.goals.holder.type is 'holds'; known are 'joints'");
  asks("\"type\": \"hold\"", "\"type\": \"joints\"", "request: the goal has no target");
  asks("\"type\": \"joints\"", "\"type\": \"hold\"", "request: a goal of type 'hold' has no target");
  asks("\"type\": \"joints\"", "\"type\": \"pose\"", "request: a pose is 7 numbers");
  asks("[-1.1, 0]", "[-1.1]", "request: goal of 'left' has 1 values");
  asks("[-1.1, 0]", "[\"nan\", 0]", "request: goal joints");
  asks("\"committed\": {", "\"comitted\": {", "request: unknown robot 'comitted', did you mean 'committed'");
  asks("\"committed\": {", "\"left\": {", "request: robot 'left' has a start and is an obstacle too");
  asks("\"times\": [0, 2]", "\"times\": [1, 2]", "request: obstacle 'committed': the trajectory begins at 1 s");
  asks("\"times\": [0, 2]", "\"times\": [0]", "request.obstacles.committed: times has 1 numbers");
  asks("\"times\": [0, 2]", "\"times\": [0, \"nan\"]", "request: obstacle 'committed': ");
  asks("\"joint_names\": [\"a\", \"b\"]", "\"joint_names\": [\"b\", \"a\"]",
       "request: obstacle 'committed': the joints are in another order");
  answers("\"status\": \"solved\"", "\"status\": \"exhausted\"",
          "the status is 'exhausted', but there is a trajectory");
  answers("\"trajectories\":", "\"trajectory\":", "unknown key 'trajectory' in result, did you mean 'trajectories'");
  answers("\"tree_nodes\":", "\"nodes\":", "result.statistics: it has no 'tree_nodes'");
  const std::size_t trajectories = text.find("\"trajectories\":");
  check(trajectories, "\"left\": {", "\"lft\": {",
        "result: the trajectories are of 'holder', 'idler', 'lft' and 'right', but the request has starts of 'holder', "
        "'idler', 'left' and 'right'");
  check(trajectories, "\"positions\": [", "\"positions\": [\n[1, 2, 3],",
        "result.trajectories.holder.positions[1] is 2 numbers, but the row before it 3");
  check(trajectories, "\"joint_names\": [\"a\", \"b\"]", "\"joint_names\": [\"b\", \"a\"]",
        "result.trajectories.holder: the joints are 'b' and 'a', but those of robot 'holder' are 'a' and 'b'");
  check(trajectories, "\"times\": [", "\"times\": [\n9,", "result.trajectories.holder: times has");
}

BOOST_AUTO_TEST_SUITE_END()
