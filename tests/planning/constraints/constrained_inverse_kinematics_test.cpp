#include "srmp/planning/constraints/constrained_inverse_kinematics.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>

#include "srmp/core/low_discrepancy.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"
#include "srmp/scene/scene.hpp"
#include "support/data.hpp"

using namespace srmp;

namespace {

/// Configuration `index` of a sequence within the limits.
Eigen::VectorXd spread(const RobotModel& robot, std::size_t index) {
  Eigen::VectorXd q = low_discrepancy_point(index, static_cast<Eigen::Index>(robot.dof()));
  for (std::size_t j = 0; j < robot.dof(); ++j) {
    const Joint& joint = robot.joints()[j];
    double& value = q[static_cast<Eigen::Index>(j)];
    value = joint.lower + value * (joint.upper - joint.lower);
  }
  return q;
}

}  // namespace

/// A cone about where the tool of the goal points keeps all configurations of the goal.
BOOST_AUTO_TEST_CASE(constraints_that_the_goal_keeps_leave_all_of_its_configurations) {
  RobotDescription description = arm7();
  description.end_effector = "arm7_hand";
  const auto robot = RobotModel::load(description);
  Scene scene;
  scene.add_robot(robot);
  for (std::size_t i = 1; i <= 20; ++i) {
    const Eigen::VectorXd q = spread(*robot, i);
    const Pose goal = robot->compute_fk(q);
    const Eigen::Vector3d axis = goal.isometry().linear().col(2);
    const auto cone = place_constraints(scene, robot->name(), {PathConstraint::cone({0, 0, 1}, axis, 0.1)});
    const PlacedRobot placed{robot};
    IkOptions options;
    options.max_solutions = 4;  // of one link alone, all are found all the same: the nearest may be in collision
    const auto kept = constrained_inverse_kinematics(placed, cone.get(), {{"", goal, options}}, q, {});
    options.max_solutions = options.seeds;
    const auto all = inverse_kinematics(*robot, goal, q, options);
    BOOST_TEST(!all.empty());
    ConstraintChecker checker(*cone);
    for (const Eigen::VectorXd& each : kept) BOOST_TEST(checker.deviation(each) <= 1.0);
    for (const Eigen::VectorXd& each : all)
      BOOST_TEST(std::ranges::any_of(kept, [&](const Eigen::VectorXd& other) {
        return (each - other).cwiseAbs().maxCoeff() < 2.0 * options.distinct;
      }));
  }
}

/// Each hand has some configurations, and all combinations of these are found.
BOOST_AUTO_TEST_CASE(links_that_share_no_joint_are_solved_each_alone) {
  RobotDescription description;
  description.urdf_path = SRMP_SOURCE_DIR "/python/srmp/data/two_arms.urdf";
  description.srdf_path = SRMP_SOURCE_DIR "/python/srmp/data/two_arms.srdf";
  description.group = "both_arms";
  const auto robot = RobotModel::load(description);
  const std::string links[] = {"left_hand", "right_hand"};
  for (std::size_t i = 1; i <= 10; ++i) {
    const Eigen::VectorXd q = spread(*robot, i);
    std::vector<IkGoal> both;
    std::size_t combinations = 1;
    for (const std::string& link : links) {
      both.push_back({link, robot->compute_fk(q, link), {}});
      IkOptions all;
      all.max_solutions = all.seeds;
      combinations *= inverse_kinematics(*robot, both.back().in_base, q, all, link).size();
    }
    const auto found = constrained_inverse_kinematics({robot}, nullptr, both, q, {});
    BOOST_TEST(found.size() == std::min<std::size_t>(combinations, 256));
    BOOST_TEST((found.front() - q).cwiseAbs().maxCoeff() < 1e-3);
    for (const Eigen::VectorXd& each : found)
      for (const IkGoal& goal : both) {
        const Pose off = goal.in_base.inverse() * robot->compute_fk(each, goal.link);
        BOOST_TEST(off.p.norm() <= goal.options.position_tolerance.axes.maxCoeff());
        BOOST_TEST(std::abs(Eigen::AngleAxisd(off.isometry().linear()).angle()) <= 1e-3);
      }
  }
}
