// Plans one robot around a motion to which another robot is committed.
//
// The Python program 07_around_a_committed_motion.py does the same and prints the same numbers.

#include <cstdio>
#include <numbers>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

using srmp::GoalConstraint;
using std::numbers::pi;

int main() {
  srmp::PlannerInterface planner;
  for (const char* name : {"left", "right"}) {
    const bool left = name[0] == 'l';
    planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                              .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                              .name = name,
                              .end_effector = "arm7_hand"},
                             left ? srmp::Pose{} : srmp::Pose::from_rpy({0.6, 0, 0}, {0, 0, pi}));
  }
  planner.add_box("table", {3, 3, 0.1}, {.p = {0.3, 0, -0.051}});

  // The group state "ready" with the base joint at this angle.
  const auto turned = [&](double angle) {
    Eigen::VectorXd q = planner.robot("left").group_states().at("ready");
    q[0] = angle;
    return q;
  };

  // The right robot's motion may come from anywhere: another planner, another computer. Here it is planned first.
  planner.set_qpos("left", turned(-pi / 2));
  planner.make_planner({"right"}, srmp::WAStar{.common = {.time_limit = 30}});
  const srmp::Trajectory committed = planner.plan("right", turned(-0.9), GoalConstraint::joints(turned(0.9)));

  // The left robot crosses the same region in the other direction. It waits, moves away or takes another path.
  planner.make_planner({"left"}, srmp::XECBS{.common = {.time_limit = 30}});
  const srmp::MultiTrajectory planned = planner.plan_multi(
      {{"left", turned(-0.9)}}, {{"left", GoalConstraint::joints(turned(0.9))}}, {{"right", committed}});
  const srmp::Trajectory& trajectory = planned.at("left");

  std::printf("right: %.17g s\n", committed.duration());
  std::printf("left: %.17g s\n", trajectory.duration());
  std::printf("proved free: %s\n", trajectory.certificate->proved_free() ? "yes" : "no");
  for (const auto& q : trajectory.waypoints.rowwise()) print_numbers(q);
}
