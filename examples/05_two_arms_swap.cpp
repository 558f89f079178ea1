// Two robots face to face swap places: each end effector moves over the tray that the other one leaves.
//
// The Python program 05_two_arms_swap.py does the same and prints the same numbers.

#include <cstdio>
#include <numbers>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

using srmp::GoalConstraint;
using srmp::Pose;

namespace {

constexpr double pi = std::numbers::pi;

/// Prints the motion of each robot; all of them start at the same time.
void show(const srmp::MultiTrajectory& trajectory) {
  for (const auto& [name, motion] : trajectory.robots) {
    std::printf("%s: %.17g s, %.17g m clear\n", name.c_str(), motion.duration(), motion.certificate->clearance);
    for (const auto& q : motion.waypoints.rowwise()) print_numbers(q);
  }
}

}  // namespace

int main() {
  srmp::PlannerInterface planner;
  srmp::RobotDescription description{.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                                     .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                                     .name = "left",
                                     .end_effector = "arm7_hand"};
  planner.add_articulation(description);
  description.name = "right";
  planner.add_articulation(description, Pose::from_rpy({0.8, 0, 0}, {0, 0, pi}));
  planner.add_box("table", {1.4, 1.0, 0.1}, {.p = {0.4, 0, -0.051}});
  planner.add_box("tray_a", {0.2, 0.2, 0.1}, {.p = {0.4, 0.2, 0.05}});
  planner.add_box("tray_b", {0.2, 0.2, 0.1}, {.p = {0.4, -0.2, 0.05}});
  planner.make_planner({"left", "right"}, srmp::XECBS{.common = {.time_limit = 30}});

  const Pose over_a = Pose::from_rpy({0.4, 0.2, 0.2}, {pi, 0, 0});  // fingers down
  const Pose over_b = Pose::from_rpy({0.4, -0.2, 0.2}, {pi, 0, 0});
  const Eigen::VectorXd ready = planner.robot("left").group_states().at("ready");
  const std::map<std::string, Eigen::VectorXd> starts{{"left", planner.compute_ik("left", over_a, ready)[0]},
                                                      {"right", planner.compute_ik("right", over_b, ready)[0]}};
  const auto to_b = GoalConstraint::pose(over_b), to_a = GoalConstraint::pose(over_a);

  show(planner.plan_multi(starts, {{"left", to_b}, {"right", to_a}}));

  // Only the left robot has a goal; the right one is in its way, and may move to any configuration.
  show(planner.plan_multi(starts, {{"left", to_b}, {"right", GoalConstraint::any()}}));

  // If the right robot must not move, no motion of the left one is collision-free.
  try {
    planner.plan_multi(starts, {{"left", to_b}, {"right", GoalConstraint::hold()}});
  } catch (const srmp::PlanningError& error) {
    std::printf("%s: %s\n", std::string(to_string(error.status())).c_str(), error.what());
  }
}
