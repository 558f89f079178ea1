// Plans from a robot, a scene and a goal: the arm in srmp's data directory reaches into a shelf.
//
// The Python program 01_reach_into_shelf.py does the same and prints the same numbers.

#include <cstdio>
#include <numbers>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

int main() {
  srmp::PlannerInterface planner;
  planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                            .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                            .name = "arm",
                            .end_effector = "arm7_hand"});
  // All lengths are in metres; the pose of a box is that of its centre.
  planner.add_box("floor", {2, 2, 0.1}, {.p = {0, 0, -0.051}});
  planner.add_box("board_low", {0.3, 0.9, 0.02}, {.p = {0.6, 0, 0.3}});
  planner.add_box("board_high", {0.3, 0.9, 0.02}, {.p = {0.6, 0, 0.65}});
  planner.add_box("divider", {0.3, 0.02, 0.33}, {.p = {0.6, 0, 0.475}});
  planner.add_cylinder("jar", 0.05, 0.16, {.p = {0.65, -0.32, 0.391}});

  // The start is on the left of the divider, the goal on its right; the end effector's z axis points forward.
  const Eigen::Vector3d forward(0, std::numbers::pi / 2, 0);
  const Eigen::VectorXd start = planner.compute_ik("arm", srmp::Pose::from_rpy({0.58, 0.2, 0.45}, forward)).at(0);
  const auto goal = srmp::GoalConstraint::pose(srmp::Pose::from_rpy({0.58, -0.2, 0.45}, forward));

  planner.make_planner({"arm"}, srmp::WAStar{.common = {.time_limit = 30}});
  const srmp::Trajectory trajectory = planner.plan("arm", start, goal);

  std::printf("%td waypoints, %zu samples, %.17g s\n", trajectory.waypoints.rows(), trajectory.size(),
              trajectory.duration());
  for (const auto& q : trajectory.waypoints.rowwise()) print_numbers(q);
}
