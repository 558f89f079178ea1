#include "srmp/planning/constraints/constrained_inverse_kinematics.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>

#include "srmp/core/low_discrepancy.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"
#include "srmp/scene/scene.hpp"
#include "support/data.hpp"

using namespace srmp;

/// A cone about where the tool of the goal points keeps all configurations of the goal.
BOOST_AUTO_TEST_CASE(constraints_that_the_goal_keeps_leave_all_of_its_configurations) {
  RobotDescription description = arm7();
  description.end_effector = "arm7_hand";
  const auto robot = RobotModel::load(description);
  Scene scene;
  scene.add_robot(robot);
  const auto limits = [&](std::size_t j) { return robot->joints()[j]; };
  for (std::size_t i = 1; i <= 20; ++i) {
    Eigen::VectorXd q = low_discrepancy_point(i, 7);
    for (std::size_t j = 0; j < 7; ++j) {
      double& value = q[static_cast<Eigen::Index>(j)];
      value = limits(j).lower + value * (limits(j).upper - limits(j).lower);
    }
    const Pose goal = robot->compute_fk(q);
    const Eigen::Vector3d axis = goal.isometry().linear().col(2);
    const auto cone = place_constraints(scene, robot->name(), {PathConstraint::cone({0, 0, 1}, axis, 0.1)});
    const PlacedRobot placed{robot};
    IkOptions options;
    options.max_solutions = 4;  // of one link alone, all are wanted: the nearest may be in collision
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
