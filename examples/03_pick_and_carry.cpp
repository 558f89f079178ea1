// Pick and place: the robot grasps a can, carries it around a wall, puts it down and retreats.
//
// The Python program 03_pick_and_carry.py does the same and prints the same numbers.

#include <cstdio>
#include <numbers>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

using srmp::GoalConstraint;

namespace {

/// Plans from the robot's current configuration and makes the last configuration the current one.
void move_to(srmp::PlannerInterface& planner, const char* what, const GoalConstraint& goal) {
  const srmp::Trajectory trajectory = planner.plan("arm", planner.scene().robot("arm").q, goal);
  planner.set_qpos("arm", trajectory.positions.row(trajectory.positions.rows() - 1).transpose());
  std::printf("%s: %.17g s\n", what, trajectory.duration());
  for (const auto& q : trajectory.waypoints.rowwise()) print_numbers(q);
}

/// End effector at p, its z axis forward, fingers left and right.
GoalConstraint end_effector_at(const Eigen::Vector3d& p) {
  return GoalConstraint::pose(srmp::Pose::from_rpy(p, {0, std::numbers::pi / 2, 0}));
}

}  // namespace

int main() {
  srmp::PlannerInterface planner;
  planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                            .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                            .name = "arm",
                            .end_effector = "arm7_hand"});
  planner.add_box("floor", {2, 2, 0.1}, {.p = {0, 0, -0.051}});
  planner.add_box("stand_left", {0.2, 0.2, 0.3}, {.p = {0.55, 0.3, 0.15}});
  planner.add_box("stand_right", {0.2, 0.2, 0.4}, {.p = {0.55, -0.3, 0.2}});
  planner.add_box("wall", {0.4, 0.02, 0.7}, {.p = {0.6, 0, 0.35}});
  // An attached object must not touch its support either, so it starts, and is put down, 1 mm above its stand.
  planner.add_cylinder("can", 0.028, 0.14, {.p = {0.55, 0.3, 0.371}});
  planner.make_planner({"arm"}, srmp::WAStar{.common = {.time_limit = 30}});

  const Eigen::VectorXd ready = planner.robot("arm").group_states().at("ready");
  planner.set_qpos("arm", ready);
  move_to(planner, "approach", end_effector_at({0.45, 0.3, 0.38}));
  move_to(planner, "grasp", end_effector_at({0.55, 0.3, 0.38}));

  // From here on the can moves with the robot. The closing fingers and the palm may touch it.
  planner.attach_object("can", "arm", "arm7_hand", {"arm7_palm"});
  move_to(planner, "carry", end_effector_at({0.55, -0.3, 0.48}));

  planner.detach_object("can");
  move_to(planner, "retreat", end_effector_at({0.42, -0.3, 0.48}));
  move_to(planner, "return", GoalConstraint::joints(ready));
  print_numbers(planner.scene().object_pose("can").p);
}
