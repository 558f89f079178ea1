#include "srmp/facade/problem_file.hpp"

#include <boost/test/unit_test.hpp>

#include "io/temp_file.hpp"
#include "io/worlds.hpp"
#include "srmp/io/scene_file.hpp"
#include "srmp/io/trajectory_file.hpp"
#include "srmp/planner_interface.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"

namespace {

using srmp::GoalConstraint;
using srmp::PlannerInterface;

/// The arm of worlds::every_kind with a planner.
PlannerInterface planner_among_every_kind() {
  const TemporaryDirectory directory;
  srmp::io::save_scene(worlds::every_kind(), directory.path("scene.json"));
  PlannerInterface planner;
  planner.load_scene(directory.path("scene.json"));
  planner.make_planner({"planar"}, srmp::MHAStar{});
  return planner;
}

const Eigen::Vector2d start(-1.0, 0.2);

std::vector<GoalConstraint> goals() {
  GoalConstraint pose = GoalConstraint::pose({{1.0, 1.0, 0.0}, Eigen::Quaterniond::Identity()});
  pose.rotation_tolerance = {0.1, 0.1 / 3, std::numeric_limits<double>::infinity()};
  GoalConstraint position = GoalConstraint::position({1.2, 0.4, 0.03});
  position.position_tolerance = {0.01, 0.01, std::numeric_limits<double>::infinity()};
  return {pose, position, GoalConstraint::joints(Eigen::Vector2d(0.7, 0.1))};
}

PlannerInterface reloaded(const PlannerInterface& planner) {
  const TemporaryDirectory directory;
  planner.save(directory.path("p.json"));
  return PlannerInterface::load(directory.path("p.json"));
}

std::string text_of(const PlannerInterface& planner) {
  const TemporaryDirectory directory;
  planner.save(directory.path("p.json"));
  std::ifstream stream(directory.path("p.json"));
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool same(const srmp::Trajectory& a, const srmp::Trajectory& b) {
  return a.joint_names == b.joint_names && a.positions == b.positions && a.velocities == b.velocities &&
         a.accelerations == b.accelerations && a.times == b.times && a.waypoints == b.waypoints;
}

const srmp::PlanRequest& request_of(const PlannerInterface& planner) {
  return std::get<srmp::PlanRequest>(*planner.last_request());
}
const srmp::PlanResult& result_of(const PlannerInterface& planner) {
  return std::get<srmp::PlanResult>(*planner.last_result());
}

}  // namespace

BOOST_AUTO_TEST_SUITE(problem_file)

BOOST_AUTO_TEST_CASE(a_problem_plans_again_to_the_same_answer) {
  auto planner = planner_among_every_kind();
  const srmp::Trajectory trajectory = planner.plan("planar", start, goals());
  auto read = reloaded(planner);
  BOOST_CHECK_EQUAL(text_of(read), text_of(planner));
  BOOST_REQUIRE(read.last_request() && read.last_result());
  BOOST_CHECK(same(result_of(read).trajectory(), trajectory));
  BOOST_CHECK_EQUAL(read.get_planning_stats().plan_time_s, planner.get_planning_stats().plan_time_s);
  BOOST_CHECK_EQUAL(read.get_planning_stats().expansions, planner.get_planning_stats().expansions);
  const auto& request = request_of(read);
  BOOST_CHECK(request.start == start);
  BOOST_REQUIRE_EQUAL(request.goals.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    BOOST_CHECK(request.goals[i].type == goals()[i].type && request.goals[i].targets == goals()[i].targets);
    BOOST_CHECK(request.goals[i].position_tolerance == goals()[i].position_tolerance);
    BOOST_CHECK(request.goals[i].rotation_tolerance == goals()[i].rotation_tolerance);
  }
  BOOST_CHECK(same(read.plan(request.robot, request.start, request.goals), trajectory));
  BOOST_CHECK_EQUAL(read.get_planning_stats().expansions, planner.get_planning_stats().expansions);
}

BOOST_AUTO_TEST_CASE(limits_that_were_set_are_saved_and_no_others) {
  auto planner = planner_among_every_kind();
  BOOST_CHECK(text_of(planner).find("\"motion_limits\"") == std::string::npos);
  srmp::MotionLimits limits = planner.motion_limits("planar");
  limits.velocity = Eigen::Vector2d(1.0 / 3, 0.7);
  limits.jerk[0] = 1.0 / 7;
  planner.set_motion_limits("planar", limits);
  const srmp::Trajectory trajectory = planner.plan("planar", start, goals());
  auto read = reloaded(planner);
  BOOST_CHECK_EQUAL(text_of(read), text_of(planner));
  BOOST_CHECK(read.motion_limits("planar").velocity == limits.velocity);
  BOOST_CHECK(read.motion_limits("planar").jerk == limits.jerk);
  BOOST_CHECK(same(read.plan("planar", start, goals()), trajectory));
}

BOOST_AUTO_TEST_CASE(limits_stay_while_the_joints_do) {
  const TemporaryDirectory directory;
  auto planner = planner_among_every_kind();
  planner.save_scene(directory.path("same.json"));
  srmp::Scene other;
  other.add_robot(robots::planar3());
  srmp::io::save_scene(other, directory.path("other.json"));
  const std::string text = read_text(directory.path("other.json"));
  directory.write("other.json", replaced(text, "\"name\": \"planar3\"", "\"name\": \"planar\""));

  srmp::MotionLimits limits = planner.motion_limits("planar");
  limits.velocity = Eigen::Vector2d(0.3, 0.7);
  planner.set_motion_limits("planar", limits);
  planner.load_scene(directory.path("same.json"));
  BOOST_CHECK(planner.motion_limits("planar").velocity == limits.velocity);
  planner.load_scene(directory.path("other.json"));
  BOOST_CHECK(planner.motion_limits("planar").velocity == Eigen::Vector3d(2, 2, 2));
}

BOOST_AUTO_TEST_CASE(every_planner_keeps_its_options) {
  auto planner = planner_among_every_kind();
  for (const srmp::PlannerInfo& info : srmp::available_planners()) {
    planner.make_planner({"planar"},
                         srmp::OptionMap{{"planner_id", info.id}, {"time_limit", 1.0 / 3}, {"heuristic", "bfs(0.1)"}});
    BOOST_CHECK(srmp::to_map(reloaded(planner).planner_options({"planar"})) ==
                srmp::to_map(planner.planner_options({"planar"})));
  }
}

BOOST_AUTO_TEST_CASE(an_unsolved_request_is_kept_with_its_reason) {
  auto planner = planner_among_every_kind();
  BOOST_CHECK_THROW(planner.plan("planar", start, GoalConstraint::position({5, 5, 5})), srmp::PlanningError);
  const auto read = reloaded(planner);
  BOOST_REQUIRE(read.last_result());
  BOOST_CHECK(!result_of(read).solved());
  BOOST_CHECK(result_of(read).status() == srmp::Status::goal_invalid);
  BOOST_CHECK_EQUAL(result_of(read).reason(), planner.get_planning_stats().reason);
}

BOOST_AUTO_TEST_CASE(a_result_goes_when_what_it_depends_on_changes) {
  auto planner = planner_among_every_kind();
  BOOST_CHECK(!planner.last_request() && !planner.last_result());
  const auto plan = [&] {
    planner.plan("planar", start, goals());
    BOOST_CHECK(planner.last_request() && planner.last_result());
  };
  plan();
  planner.set_padding("box", 0.02);
  BOOST_CHECK(planner.last_request() && !planner.last_result());
  BOOST_CHECK(reloaded(planner).last_request() && !reloaded(planner).last_result());
  plan();
  planner.make_planner({"planar"}, srmp::WAStar{});
  BOOST_CHECK(planner.last_request() && !planner.last_result());
  plan();
  BOOST_CHECK_THROW(planner.plan("planar", Eigen::Vector3d(0, 0, 0), goals()), srmp::InvalidArgument);
  BOOST_CHECK(planner.last_request() && planner.last_result());  // a refused call changes nothing
  planner.remove_articulation("planar");
  BOOST_CHECK(!planner.last_request() && !planner.last_result());
}

BOOST_AUTO_TEST_CASE(heuristics_of_the_user_are_refused_only_where_they_are_named) {
  auto planner = planner_among_every_kind();
  planner.add_heuristic("mine", [](srmp::ConstRows q, srmp::ConstRows) { return Eigen::VectorXd::Zero(q.rows()); });
  BOOST_CHECK_NO_THROW(reloaded(planner));
  srmp::MHAStar options;
  options.inadmissible_heuristics.push_back("mine");
  planner.make_planner({"planar"}, options);
  const TemporaryDirectory directory;
  check_throws<srmp::InvalidArgument>([&] { planner.save(directory.path("p.json")); },
                                      "the planner of 'planar' uses the heuristic 'mine' of yours");
  BOOST_CHECK(!std::filesystem::exists(directory.path("p.json")));
}

BOOST_AUTO_TEST_CASE(a_scene_replaces_another_or_changes_nothing) {
  const TemporaryDirectory directory;
  auto planner = planner_among_every_kind();
  planner.plan("planar", start, goals());
  planner.save(directory.path("p.json"));
  planner.save_scene(directory.path("s.json"));
  for (const char* file : {"p.json", "s.json"}) {  // a problem holds a scene too
    PlannerInterface other;
    other.add_box("gone", {1, 1, 1}, {});
    other.load_scene(directory.path(file));
    BOOST_CHECK(other.object_names() == planner.object_names());
    BOOST_TEST((srmp::to_map(other.planner_options({"planar"})) == srmp::to_map(srmp::Auto{})));
  }
  directory.write("broken.json", "{");
  check_throws<srmp::FileError>([&] { planner.load_scene(directory.path("broken.json")); }, "broken.json:");
  BOOST_CHECK(planner.last_result() && planner.object_names().size() == 9u);
  planner.load_scene(directory.path("s.json"));
  BOOST_CHECK(!planner.last_request());
  BOOST_CHECK_NO_THROW(planner.plan("planar", start, goals()));  // its planner is still there
}

BOOST_AUTO_TEST_CASE(trajectories_of_problem_files) {
  const TemporaryDirectory directory;
  auto planner = planner_among_every_kind();
  planner.save(directory.path("p.json"));
  check_throws<srmp::FileError>([&] { srmp::io::load_trajectory(directory.path("p.json")); }, "it holds no trajectory");
  const auto trajectory = planner.plan("planar", start, goals());
  planner.save(directory.path("p.json"));
  BOOST_CHECK(same(srmp::io::load_trajectory(directory.path("p.json")), trajectory));
}

BOOST_AUTO_TEST_CASE(wrong_problems_are_refused_with_the_place) {
  auto planner = planner_among_every_kind();
  planner.set_motion_limits("planar", planner.motion_limits("planar"));
  planner.plan("planar", start, goals());
  const std::string text = text_of(planner);
  const auto check = [&](const std::string& from, const std::string& to, const std::string& fragment) {
    const TemporaryDirectory directory;
    const std::size_t at = text.rfind(from);
    BOOST_REQUIRE_MESSAGE(at != std::string::npos, from);
    const std::string path = directory.write("p.json", std::string(text).replace(at, from.size(), to));
    check_throws<srmp::FileError>([&] { PlannerInterface::load(path); }, fragment);
    check_throws<srmp::FileError>([&] { PlannerInterface::load(path); }, path + ":");
  };
  check("\"MHAstar\"", "\"MHBstar\"", "planners[0]: there is no planner 'MHBstar'");
  check("\"w1\"", "\"w7\"", "planners[0]: planner 'MHAstar' has no option 'w7'");
  check("\"time_limit\": 5", "\"time_limit\": -5", "planners[0]: option 'time_limit' is -5");
  check("\"joint_proximal\"", "\"mine\"", "planners[0]: option 'inadmissible_heuristics' is 'mine'");
  check("\"robots\": [\"planar\"]", "\"robots\": [\"plan\"]", "planners[0]: unknown robot 'plan'");
  check("\"robots\": [\"planar\"]", "\"robots\": []", "planners[0]: make_planner needs");
  check("\"robot\": \"planar\"", "\"robot\": \"planer\"", "request: unknown robot 'planer'");
  check("\"start\": [-1, 0.2]", "\"start\": [-1]", "request: start of 'planar'");
  check("\"type\": \"joints\"", "\"type\": \"joint\"",
        "request.goals[2].type is 'joint'; known are 'joints', 'pose', 'position', 'hold' and 'any'");
  check("\"type\": \"joints\"", "\"type\": \"pose\"", "request: a pose is 7 numbers");
  check("\"type\": \"joints\"", "\"type\": \"hold\"", "request: a goal of type 'hold' has no target");
  check("\"status\": \"solved\"", "\"status\": \"fine\"", "result.statistics.status is 'fine'; known are 'solved'");
  check("\"status\": \"solved\"", "\"status\": \"exhausted\"", "the status is 'exhausted', but there is a trajectory");
  check("\"expansions\":", "\"expansions\": -1, \"expnsions\":", "expansions must be a whole number, 0 or above");
  check("\"request\":", "\"requests\":", "it has a result, but no request");
  check("\"joint_names\": [\"a\", \"b\"]", "\"joint_names\": [\"a\", \"c\"]",
        "result.trajectory: the joints are 'a' and 'c', but those of robot 'planar' are 'a' and 'b'");
  check("\"format\": \"srmp problem\"", "\"format\": \"srmp trajectory\"", "the format is 'srmp trajectory'; expected");
  const std::string limits = "\"motion_limits\": {\n\"planar\": {\n  ";
  check(limits + "\"velocity\": [2, 2]", limits + "\"velocity\": [2, 0]",
        "motion_limits: b: the velocity limit is 0; it must be");
  check(limits + "\"velocity\": [2, 2]", limits + "\"velocity\": [2]", "motion_limits: velocity limits: got 1, but");
  check(limits + "\"velocity\"", limits + "\"speed\"", "motion_limits.planar: it has no 'velocity'");
  check("\"motion_limits\": {\n\"planar\"", "\"motion_limits\": {\n\"plan\"", "motion_limits: unknown robot 'plan'");
  check("\"format\": \"srmp problem\"", "\"format\": \"srmp scene\"", "unknown key 'planners'");
}

BOOST_AUTO_TEST_SUITE_END()
