#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "support/amount.hpp"
#include "support/data.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

const Eigen::VectorXd home = (Eigen::VectorXd(7) << 0.0, 0.4, 0.0, -1.6, 0.0, 1.0, 0.0).finished();

PlannerInterface arm() {
  PlannerInterface planner;
  planner.add_articulation(arm7());
  return planner;
}

Pose beside(const Pose& pose, double x, double y, double z, double turn = 0.0) {
  return {pose.p + Eigen::Vector3d(x, y, z),
          Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ())) * pose.q};
}

/// Distance from the segment between two poses, at instants 1 ms apart, by forward kinematics alone.
double worst_distance(const PlannerInterface& planner, const Trajectory& motion, const Pose& a, const Pose& b) {
  double worst = 0.0;
  const Eigen::Vector3d along = (b.p - a.p).normalized();
  for (double t = 0.0; t <= motion.duration(); t += 1e-3) {
    const Eigen::Vector3d off = planner.compute_fk("arm7", motion.sample(t)).p - a.p;
    const double passed = std::clamp(off.dot(along), 0.0, (b.p - a.p).norm());
    worst = std::max(worst, (off - passed * along).norm());
  }
  return worst;
}

void check_exhausted(PlannerInterface& planner, const std::vector<Pose>& poses, const std::string& sentence) {
  try {
    planner.follow("arm7", home, poses);
    BOOST_ERROR("no exception, expected '" + sentence + "'");
  } catch (const PlanningError& error) {
    BOOST_CHECK(error.status() == Status::exhausted);
    BOOST_TEST(std::string(error.what()).find(sentence) != std::string::npos, error.what());
    BOOST_CHECK_EQUAL(planner.get_planning_stats().reason, error.what());
  }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(follow_poses)

BOOST_AUTO_TEST_CASE(lines_are_straight_timed_and_certified) {
  PlannerInterface planner = arm();
  const Pose start = planner.compute_fk("arm7", home);
  for (const Pose& goal : {beside(start, 0.0, 0.0, -0.15), beside(start, 0.0, 0.2, 0.1), beside(start, 0, 0, 0, 0.8),
                           beside(start, -0.1, -0.15, 0.05, -0.5)}) {
    const Trajectory motion = planner.plan_linear("arm7", home, goal);
    BOOST_REQUIRE(motion.certificate);
    BOOST_TEST(motion.certificate->holds());
    BOOST_TEST(motion.certificate->proved_free());
    const auto& deviation = motion.certificate->cartesian_deviation;
    BOOST_REQUIRE(deviation.has_value());
    BOOST_TEST(deviation->position <= 1e-3);
    BOOST_TEST(deviation->rotation <= M_PI / 360.0);
    BOOST_TEST(worst_distance(planner, motion, start, goal) <= deviation->position);
    const Pose end = planner.compute_fk("arm7", motion.positions.bottomRows(1).transpose());
    BOOST_TEST((end.p - goal.p).norm() < 1e-4);
    BOOST_TEST(end.q.angularDistance(goal.q) < 1e-3);
    BOOST_TEST(planner.get_planning_stats().bound >= 1.0);
    const Trajectory again = planner.plan_linear("arm7", home, goal);
    BOOST_TEST((again.positions == motion.positions && again.times == motion.times));
  }
}

BOOST_AUTO_TEST_CASE(tolerances_are_kept_whatever_they_are) {
  PlannerInterface planner = arm();
  const Pose start = planner.compute_fk("arm7", home), goal = beside(start, 0.0, 0.2, 0.0);
  for (const double most : {1e-4, 1e-3, 1e-2}) {
    const Trajectory motion = planner.plan_linear("arm7", home, goal, {.max_deviation = most, .max_rotation = most});
    BOOST_TEST(motion.certificate->cartesian_deviation->position <= most);
    BOOST_TEST(motion.certificate->cartesian_deviation->rotation <= most);
    BOOST_TEST(worst_distance(planner, motion, start, goal) <= most);
  }
}

BOOST_AUTO_TEST_CASE(several_poses_are_passed_in_order) {
  PlannerInterface planner = arm();
  const Pose start = planner.compute_fk("arm7", home);
  const std::vector<Pose> square{beside(start, 0, 0.1, 0), beside(start, 0, 0.1, -0.1), beside(start, 0, 0, -0.1),
                                 start};
  const Trajectory motion = planner.follow("arm7", home, square);
  BOOST_TEST(motion.certificate->cartesian_deviation->position <= 1e-3);
  std::size_t next = 0;
  for (double t = 0.0; t <= motion.duration() && next < square.size(); t += 1e-3)
    if ((planner.compute_fk("arm7", motion.sample(t)).p - square[next].p).norm() <= 1e-3) ++next;
  BOOST_TEST(next >= square.size() - 1);
  BOOST_TEST((planner.compute_fk("arm7", motion.positions.bottomRows(1).transpose()).p - start.p).norm() < 1e-4);
}

BOOST_AUTO_TEST_CASE(spare_joints_avoid_what_the_shortest_motion_hits) {
  PlannerInterface free = arm(), blocked = arm();
  const Pose start = free.compute_fk("arm7", home), goal = beside(start, 0.0, 0.0, -0.2);
  const Trajectory direct = free.plan_linear("arm7", home, goal);
  // Where the elbow is in the middle of that motion.
  const std::string elbow = free.get_link_names("arm7")[4];
  const Eigen::VectorXd middle = direct.sample(direct.duration());
  const Eigen::Vector3d at = free.compute_fk("arm7", middle, elbow).p;
  blocked.add_sphere("bead", 0.02, Pose{at + Eigen::Vector3d(0.0, 0.0, 0.14), Eigen::Quaterniond::Identity()});
  try {
    const Trajectory around = blocked.plan_linear("arm7", home, goal);
    BOOST_TEST(around.certificate->proved_free());
    BOOST_TEST(around.certificate->cartesian_deviation->position <= 1e-3);
  } catch (const PlanningError& error) {
    BOOST_TEST(std::string(error.what()).find("bead") != std::string::npos, error.what());
  }
}

BOOST_AUTO_TEST_CASE(a_path_that_cannot_be_followed_says_how_far_it_came_and_why) {
  PlannerInterface planner = arm();
  const Pose start = planner.compute_fk("arm7", home);
  check_exhausted(planner, {beside(start, 0.0, 3.0, 0.0)}, "no configuration");
  const Pose wall_at = beside(start, 0.0, 0.25, 0.0);
  planner.add_box("wall", {1.0, 0.02, 1.0}, {wall_at.p, Eigen::Quaterniond::Identity()});
  check_exhausted(planner, {beside(start, 0.0, 0.4, 0.0)}, "wall");
  check_exhausted(planner, {beside(start, 0.0, 0.4, 0.0)}, "of 0.4 m along its path");
}

BOOST_AUTO_TEST_CASE(other_links_can_follow_poses_too) {
  PlannerInterface planner = arm();
  const std::string link = planner.get_link_names("arm7")[6];
  const Pose start = planner.compute_fk("arm7", home, link);
  const Pose goal = beside(start, 0.0, 0.05, 0.0);
  const Trajectory motion = planner.plan_linear("arm7", home, goal, {.link = link});
  BOOST_TEST((planner.compute_fk("arm7", motion.positions.bottomRows(1).transpose(), link).p - goal.p).norm() < 1e-4);
}

BOOST_AUTO_TEST_CASE(wrong_requests_are_refused_and_change_nothing) {
  PlannerInterface planner = arm();
  const Pose start = planner.compute_fk("arm7", home), goal = beside(start, 0.0, 0.1, 0.0);
  check_throws<InvalidArgument>([&] { planner.follow("arm7", home, {}); }, "no poses to follow");
  check_throws<InvalidArgument>([&] { planner.plan_linear("arm8", home, goal); }, "arm7");
  check_throws<InvalidArgument>([&] { planner.plan_linear("arm7", home.head(3), goal); }, "3");
  check_throws<InvalidArgument>([&] { planner.plan_linear("arm7", home, goal, {.link = "hnad"}); }, "hnad");
  check_throws<InvalidArgument>(
      [&] { planner.plan_linear("arm7", home, goal, {.link = planner.get_link_names("arm7")[0]}); },
      "no planned joint moves it");
  check_throws<InvalidArgument>([&] { planner.plan_linear("arm7", home, goal, {.max_deviation = 0.0}); },
                                "max_deviation is 0; it must be above 0");
  check_throws<InvalidArgument>([&] { planner.plan_linear("arm7", home, goal, {.max_rotation = 2.0}); },
                                "max_rotation is 2");
  const Pose nan{{std::nan(""), 0.0, 0.0}, Eigen::Quaterniond::Identity()};
  check_throws<InvalidArgument>([&] { planner.plan_linear("arm7", home, nan); }, "pose 0");
}

BOOST_AUTO_TEST_CASE(the_clearance_is_kept_and_relaxed_near_ends_that_are_closer) {
  PlannerInterface planner = arm();
  const Eigen::VectorXd down = (Eigen::VectorXd(7) << 0, 0, 0, M_PI / 2, 0, M_PI / 2, 0).finished();
  const Pose above = planner.compute_fk("arm7", down);
  planner.add_box("table", {0.3, 0.3, 0.05}, {above.p - Eigen::Vector3d(0, 0, 0.125)});
  planner.make_planner({"arm7"}, OptionMap{{"clearance", 0.02}});
  const Trajectory motion = planner.plan_linear("arm7", down, beside(above, 0, 0, -0.095));
  BOOST_REQUIRE(motion.certificate);
  BOOST_TEST(motion.certificate->holds());
  const auto& kept = motion.certificate->clearance_kept;
  BOOST_REQUIRE(kept);
  BOOST_TEST(kept->violation == 0.0);
  BOOST_TEST(kept->from == 0.0);
  BOOST_TEST(kept->to < motion.duration());
  BOOST_REQUIRE(!kept->relaxed.empty());
  const Trajectory up = planner.plan_linear("arm7", motion.positions.bottomRows(1).transpose(), above);
  BOOST_TEST(up.certificate->clearance_kept->from > 0.0);
  BOOST_TEST(up.certificate->clearance_kept->to == up.duration());
}

BOOST_AUTO_TEST_CASE(path_constraints_of_another_link_are_kept) {
  PlannerInterface planner = arm();
  const Pose start = planner.compute_fk("arm7", home);
  const std::string link = planner.get_link_names("arm7")[4];
  PathConstraint box = PathConstraint::box({0.1, 0.1, 0.1}, planner.compute_fk("arm7", home, link));
  box.link = link;
  const CartesianOptions options{.constraints = {box}};
  const Trajectory motion = planner.plan_linear("arm7", home, beside(start, 0, 0.1, 0), options);
  BOOST_REQUIRE_EQUAL(motion.certificate->constraints.size(), 1u);
  BOOST_TEST(motion.certificate->constraints[0].deviation <= motion.certificate->constraints[0].tolerance);
  box.link = "hnad";
  check_throws<InvalidArgument>(
      [&] { planner.plan_linear("arm7", home, beside(start, 0, 0.1, 0), {.constraints = {box}}); }, "hnad");
}

BOOST_AUTO_TEST_SUITE_END()
