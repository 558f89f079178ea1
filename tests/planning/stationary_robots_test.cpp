#include <boost/test/unit_test.hpp>

#include "srmp/collision/scene_checker.hpp"
#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

namespace {

using Eigen::Vector2d;
using srmp::Certificate;
using srmp::GoalConstraint;
using srmp::MultiTrajectory;
using srmp::Trajectory;
using Starts = std::map<std::string, Eigen::VectorXd>;
using Goals = std::map<std::string, GoalConstraint>;

/// Planar arms, 2 m long: `holder` stands between, and stretches towards the line between the other two.
///
///     left ──────── ──────── right
srmp::PlannerInterface three_arms(const srmp::CommonOptions& common = {.time_limit = 20}) {
  srmp::PlannerInterface planner;
  srmp::RobotDescription description = robots::planar_description();
  description.name = "left";
  planner.add_articulation(description);
  description.name = "right";
  planner.add_articulation(description, srmp::Pose::from_rpy({3, 0, 0}, {0, 0, M_PI}));
  description.name = "holder";
  planner.add_articulation(description, srmp::Pose::from_rpy({1.5, 3.1, 0}, {0, 0, -M_PI / 2}));
  planner.make_planner({"holder", "left", "right"}, srmp::XECBS{.common = common});
  return planner;
}

const Starts starts{{"left", Vector2d(0.45, 0.0)}, {"right", Vector2d(1.2, 0.0)}, {"holder", Vector2d(0.0, 0.0)}};
const Goals goals{{"left", GoalConstraint::joints(Vector2d(-0.45, 0.0))},
                  {"right", GoalConstraint::joints(Vector2d(1.0, 0.0))}};

/// The smallest distance of the holder from the others, at instants 2 ms apart.
double distance(const srmp::PlannerInterface& planner, const MultiTrajectory& motion) {
  const srmp::SceneChecker all(planner.scene(), "holder",
                               {.mode = srmp::CheckMode::coal, .other_robots = {"left", "right"}});
  const auto workspace = all.make_workspace();
  double least = 1e9;
  for (double t = 0.0; t <= motion.duration(); t += 2e-3) {
    Eigen::VectorXd q(6);
    q << starts.at("holder"), motion.at("left").sample(t), motion.at("right").sample(t);
    least = std::min(least, all.nearest(q, *workspace)->distance);
  }
  return least;
}

bool names(const Certificate& certificate, const std::string& other) { return certificate.body_b.starts_with(other); }

}  // namespace

BOOST_AUTO_TEST_SUITE(holding)

BOOST_AUTO_TEST_CASE(who_holds_has_a_certificate_as_the_others_have) {
  auto planner = three_arms();
  const MultiTrajectory motion = planner.plan_multi(starts, goals);
  const Certificate& held = *motion.at("holder").certificate;
  BOOST_CHECK(held.holds() && held.proved_free());
  BOOST_CHECK(names(held, "left/"));
  const double least = distance(planner, motion);
  BOOST_CHECK_LE(held.clearance_proved, least + 1e-9);
  BOOST_CHECK_SMALL(held.clearance - least, 1e-3);
  BOOST_CHECK_SMALL(held.clearance - motion.at("left").certificate->clearance, 1e-9);  // the same pair
  BOOST_CHECK_EQUAL(held.bound, planner.get_planning_stats().bound);
  BOOST_CHECK_EQUAL(held.bound_graph, planner.get_planning_stats().bound_graph);
  BOOST_CHECK(std::isnan(held.goal_error));
  BOOST_CHECK(held.limits.velocity == planner.motion_limits("holder").velocity);
}

BOOST_AUTO_TEST_CASE(with_every_timing_and_only_if_asked_for) {
  for (const char* timing : {"toppra", "ruckig", "none"}) {
    const auto held = [&](bool certify) {
      auto planner = three_arms({.time_limit = 20, .timing = timing, .certify = certify});
      return planner.plan_multi(starts, goals).at("holder").certificate;
    };
    BOOST_REQUIRE(held(true));
    BOOST_CHECK(held(true)->holds() && held(true)->proved_free());
    BOOST_CHECK(names(*held(true), "left/"));
    BOOST_CHECK(!held(false));
  }
}

BOOST_AUTO_TEST_CASE(committed_motions_are_covered_too) {
  auto planner = three_arms();
  Trajectory sweep{.joint_names = {"a", "b"}, .positions = srmp::RowMatrix(2, 2)};
  sweep.positions << 0.45, 0.0, -0.45, 0.0;
  sweep.times = Vector2d(0.0, 2.0);
  planner.make_planner({"holder", "right"}, srmp::XECBS{.common = {.time_limit = 20}});
  const Starts two{{"holder", starts.at("holder")}, {"right", starts.at("right")}};
  const auto motion = planner.plan_multi(two, {{"right", goals.at("right")}}, {{"left", sweep}});
  const Certificate& held = *motion.at("holder").certificate;
  BOOST_CHECK(held.proved_free() && names(held, "left/"));
  BOOST_CHECK_CLOSE(held.clearance, three_arms().plan_multi(starts, goals).at("holder").certificate->clearance, 2.0);
}

BOOST_AUTO_TEST_CASE(who_cannot_stand_there_is_told_so) {
  const auto fails = [](srmp::PlannerInterface& planner, const Vector2d& holder, const std::string& sentence) {
    Starts from = starts;
    from.at("holder") = holder;
    try {
      planner.plan_multi(from, goals);
      BOOST_ERROR("planned: " + sentence);
    } catch (const srmp::PlanningError& error) {
      BOOST_CHECK(error.status() == srmp::Status::start_invalid);
      BOOST_TEST(std::string(error.what()).find(sentence) != std::string::npos, error.what());
      BOOST_CHECK(planner.get_planning_stats().status == srmp::Status::start_invalid);
      BOOST_CHECK_EQUAL(planner.get_planning_stats().reason, error.what());
    }
  };
  auto planner = three_arms();
  planner.add_box("box", {0.2, 0.2, 0.2}, srmp::Pose::from_rpy({1.5, 2.0, 0}, {0, 0, 0}));
  fails(planner, Vector2d::Zero(), "robot 'holder': the start is invalid: link 'lower' and object 'box' overlap by");
  fails(planner, Vector2d(4.0, 0.0), "robot 'holder': the start is invalid: a: 4 rad is above the upper limit 3 rad");
  planner = three_arms();
  planner.remove_articulation("right");
  srmp::RobotDescription description = robots::planar_description();
  description.name = "right";  // stands in the holder's way, and is not asked about or holds too
  planner.add_articulation(description, srmp::Pose::from_rpy({0.9, 2.5, 0}, {0, 0, 0}));
  planner.make_planner({"holder", "left"}, srmp::XECBS{});
  planner.make_planner({"holder", "left", "right"}, srmp::XECBS{});
  for (const bool too : {false, true}) {
    Starts from = starts;
    if (too)
      from.at("right").setZero();
    else
      from.erase("right");
    check_throws<srmp::PlanningError>([&] { planner.plan_multi(from, {{"left", goals.at("left")}}); },
                                      "robot 'holder': the start is invalid: link 'upper' and link 'right/");
  }
}

BOOST_AUTO_TEST_CASE(a_hair_outside_a_limit_is_on_it) {
  auto planner = three_arms();
  Starts from = starts;
  from.at("holder") = Vector2d(3.0 + 5e-7, 0.0);
  const MultiTrajectory motion = planner.plan_multi(from, goals);
  BOOST_CHECK_EQUAL(motion.at("holder").positions(0, 0), 3.0);
  BOOST_CHECK(motion.at("holder").certificate->holds());
}

// --- verify_multi

BOOST_AUTO_TEST_CASE(verify_finds_what_the_planner_found) {
  auto planner = three_arms();
  const MultiTrajectory motion = planner.plan_multi(starts, goals);
  const auto certificates = planner.verify_multi(motion, {.starts = starts, .goals = goals});
  BOOST_REQUIRE_EQUAL(certificates.size(), 3u);
  for (const auto& [name, certificate] : certificates) {
    BOOST_CHECK(certificate.holds() && certificate.proved_free());
    BOOST_CHECK_CLOSE(certificate.clearance, motion.at(name).certificate->clearance, 1e-9);
  }
  Goals all = goals;
  all.emplace("holder", GoalConstraint::hold());
  BOOST_CHECK_EQUAL(planner.verify_multi(motion, {.starts = starts, .goals = all}).at("holder").goal_error, 0.0);
}

BOOST_AUTO_TEST_CASE(verify_names_every_fault) {
  auto planner = three_arms();
  const MultiTrajectory motion = planner.plan_multi(starts, goals);
  const auto faults = [&](const MultiTrajectory& of, const srmp::MultiVerifyOptions& options = {}) {
    std::map<std::string, std::vector<srmp::Fault>> found;
    for (const auto& [name, certificate] : planner.verify_multi(of, options)) found[name] = certificate.faults;
    return found;
  };
  const auto is = [](const std::vector<srmp::Fault>& found, srmp::FaultKind kind, const std::string& text) {
    BOOST_REQUIRE(!found.empty());
    BOOST_CHECK(found.front().kind == kind);
    BOOST_TEST(found.front().text.find(text) != std::string::npos, found.front().text);
  };

  MultiTrajectory wrong = motion;
  wrong.robots.at("holder").positions(0, 0) = 0.5;  // elsewhere
  is(faults(wrong, {.starts = starts}).at("holder"), srmp::FaultKind::start,
     "a: the trajectory starts at 0.5, not at 0");

  Trajectory& left = (wrong = motion).robots.at("left");  // through the holder
  for (Eigen::Index i = 0; i < left.positions.rows(); ++i) left.positions(i, 0) += 0.4;
  BOOST_CHECK(!faults(wrong).at("left").empty());
  is(faults(wrong).at("holder"), srmp::FaultKind::collision, "'lower' and 'left/lower' touch at");
  BOOST_CHECK(faults(wrong).at("right").empty());
  is(faults(wrong, {.goals = goals}).at("left"), srmp::FaultKind::goal, "the end misses the goal by 0.4");

  (wrong = motion).robots.at("left").times.array() += 0.5;
  is(faults(wrong).at("left"), srmp::FaultKind::times, "the trajectory begins at 0.5 s; motions on one clock begin at");
  is(faults(wrong).at("holder"), srmp::FaultKind::times,
     "'left' cannot be kept clear of: the trajectory begins at 0.5");
  (wrong = motion).robots.at("left").positions(1, 1) = std::nan("");
  is(faults(wrong).at("left"), srmp::FaultKind::not_finite, "row 1 holds NaN");
  is(faults(wrong).at("right"), srmp::FaultKind::not_finite, "'left' cannot be kept clear of: row 1 holds NaN");

  MultiTrajectory alone = motion;  // the holder is committed: not judged, but in the way
  const Trajectory holder = alone.robots.at("holder");
  alone.robots.erase("holder");
  BOOST_CHECK_EQUAL(planner.verify_multi(alone, {.obstacles = {{"holder", holder}}}).at("left").clearance,
                    motion.at("left").certificate->clearance);
}

BOOST_AUTO_TEST_CASE(verify_refuses_what_does_not_fit) {
  auto planner = three_arms();
  const MultiTrajectory motion = planner.plan_multi(starts, goals);
  const auto refused = [&](const MultiTrajectory& of, const srmp::MultiVerifyOptions& options, const std::string& why) {
    check_throws<srmp::InvalidArgument>([&] { planner.verify_multi(of, options); }, why);
  };
  refused(motion, {.starts = {{"lft", starts.at("left")}}}, "robot 'lft' has a start, but no trajectory to verify");
  refused(motion, {.goals = {{"lft", goals.at("left")}}}, "robot 'lft' has a goal, but no trajectory to verify");
  refused(motion, {.obstacles = {{"left", motion.at("left")}}}, "robot 'left' has a trajectory to verify and is an");
  refused(motion, {.obstacles = {{"lft", motion.at("left")}}}, "unknown robot 'lft', did you mean 'left'");
  refused({{{"lft", motion.at("left")}}}, {}, "unknown robot 'lft', did you mean 'left'");
  refused(motion, {.starts = {{"left", Eigen::Vector3d::Zero()}}}, "start of 'left' has 3 values");
  refused(motion, {.goals = {{"left", GoalConstraint::joints(Eigen::Vector3d::Zero())}}},
          "goal of 'left' has 3 values");
  refused(motion, {.max_deviation = -1.0}, "max_deviation is -1");
  refused(motion, {.gap_tolerance = 1.0}, "gap_tolerance is 1");
}

// --- memory

BOOST_AUTO_TEST_CASE(statistics_count_the_memory_of_every_planner) {
  const srmp::CommonOptions common{.time_limit = 20};
  auto planner = three_arms();
  const auto memory = [&](const srmp::PlannerOptions& options, const Goals& to) {
    planner.make_planner({"holder", "left", "right"}, options);
    planner.plan_multi(starts, to);
    return planner.get_planning_stats().memory_bytes;
  };
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::CBS{common}), srmp::PlannerOptions(srmp::ECBS{common})})
    BOOST_CHECK_GT(memory(options, goals), 0u);
  Goals crossing = goals;  // arms that meet, and are planned together
  crossing.at("right") = GoalConstraint::joints(Vector2d(-1.2, 0.0));
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::Auto{common}), srmp::PlannerOptions(srmp::XECBS{common}),
        srmp::PlannerOptions(srmp::Prioritised{common})}) {
    BOOST_TEST_CONTEXT(srmp::planner_id(options)) {
      const std::uint64_t apart = memory(options, goals);
      BOOST_CHECK_GT(apart, 0u);
      BOOST_CHECK_EQUAL(memory(options, goals), apart);
      BOOST_CHECK_GT(memory(options, crossing), apart);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
