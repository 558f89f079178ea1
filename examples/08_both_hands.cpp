// A robot with two arms takes a box between its hands and carries it, tilted by no more than its grip allows.
//
// The Python program 08_both_hands.py does the same and prints the same numbers.

#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

using srmp::Pose;

namespace {

constexpr double pi = std::numbers::pi;

// The hands, in the frame of the box: 1 mm beside its sides, pointing inwards.
const Pose left = Pose::from_rpy({0, 0.151, 0}, {pi / 2, 0, 0}),
           right = Pose::from_rpy({0, -0.151, 0}, {-pi / 2, 0, 0});

/// Goals of both hands, for a pose of the box.
std::map<std::string, Pose> hands_on(const Pose& box) {
  return {{"left_hand", box * left}, {"right_hand", box * right}};
}

/// Prints a motion, with what is proved of it.
void show(const char* what, const srmp::Trajectory& motion) {
  std::printf("%s: %.17g s, %.17g m clear\n", what, motion.duration(), motion.certificate->clearance);
  for (const auto& kept : motion.certificate->constraints)
    std::printf("%s: %.17g of %.17g\n", kept.constraint.c_str(), kept.deviation, kept.tolerance);
  for (const auto& q : motion.waypoints.rowwise()) print_numbers(q);
}

}  // namespace

int main() {
  srmp::PlannerInterface planner;
  planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/two_arms.urdf",
                            .srdf_path = SRMP_DATA_DIR "/two_arms.srdf",
                            .name = "robot",
                            .group = "both_arms"});
  planner.make_planner({"robot"}, srmp::Auto{.common = {.time_limit = 30}});
  const Eigen::VectorXd ready = planner.robot("robot").group_states().at("ready");
  const Pose here{.p = {0.5, 0, 0.45}}, there = Pose::from_rpy({0.42, 0.1, 0.6}, {0, 0, 0.2});

  const srmp::Trajectory grasp = planner.plan(ready, hands_on(here));
  show("grasp", grasp);

  const Eigen::VectorXd held = grasp.positions.bottomRows(1).transpose();
  planner.add_box("box", {0.2, 0.3, 0.2}, here);
  planner.set_qpos("robot", held);
  planner.attach_object("box", "robot", "left_hand", {"right_hand"});

  // The right hand keeps its pose in the frame of the left one at every instant: along and about each axis to what
  // makes 1 mm and half a degree in all.
  const double metres = 1e-3 / std::sqrt(3.0), radians = 0.5 * (pi / 180.0) / std::sqrt(3.0);
  srmp::PathConstraint closed = srmp::PathConstraint::pose(left.inverse() * right, metres, radians);
  closed.link = "right_hand";
  closed.frame = "left_hand";
  srmp::PlanRequest request{.robot = "robot", .start = held, .goals = {planner.goal("robot", hands_on(there))}};
  request.constraints = {closed};
  show("carry", planner.plan(request));
}
