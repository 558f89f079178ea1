// Four robots around four bins: each end effector moves to the next bin, which another one is leaving, and back.
//
// The Python program 06_four_arms_over_bins.py does the same and prints the same numbers.

#include <array>
#include <cstdio>
#include <numbers>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

using srmp::GoalConstraint;
using srmp::Pose;

int main() {
  constexpr double pi = std::numbers::pi;
  const std::vector<std::string> robots{"east", "north", "west", "south"};
  const std::array<Eigen::Vector3d, 4> bases{{{0.5, 0, pi}, {0, 0.5, -pi / 2}, {-0.5, 0, 0}, {0, -0.5, pi / 2}}};
  const std::array<Eigen::Vector2d, 4> bins{{{0.18, 0.18}, {-0.18, 0.18}, {-0.18, -0.18}, {0.18, -0.18}}};

  srmp::PlannerInterface planner;
  for (std::size_t i = 0; i < 4; ++i)
    planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                              .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                              .name = robots[i],
                              .end_effector = "arm7_hand"},
                             Pose::from_rpy({bases[i].x(), bases[i].y(), 0}, {0, 0, bases[i].z()}));
  planner.add_box("table", {1.6, 1.6, 0.1}, {.p = {0, 0, -0.051}});
  for (std::size_t i = 0; i < 4; ++i)
    planner.add_box("bin" + std::to_string(i), {0.16, 0.16, 0.14}, {.p = {bins[i].x(), bins[i].y(), 0.07}});
  planner.make_planner(robots, srmp::XECBS{.common = {.time_limit = 30}});

  const auto over = [&](std::size_t bin) {  // fingers down
    return Pose::from_rpy({bins[bin].x(), bins[bin].y(), 0.25}, {pi, 0, 0});
  };
  const Eigen::VectorXd ready = planner.robot("east").group_states().at("ready");
  std::map<std::string, Eigen::VectorXd> at;
  std::map<std::string, GoalConstraint> next_bins, own_bins;
  for (std::size_t i = 0; i < 4; ++i) {
    at[robots[i]] = planner.compute_ik(robots[i], over(i), ready)[0];
    next_bins[robots[i]] = GoalConstraint::pose(over((i + 3) % 4));
    own_bins[robots[i]] = GoalConstraint::joints(at[robots[i]]);
  }

  for (const auto& goals : {next_bins, own_bins}) {
    const srmp::MultiTrajectory trajectory = planner.plan_multi(at, goals);
    for (const auto& [name, motion] : trajectory.robots) {
      std::printf("%s: %.17g s, %.17g m clear\n", name.c_str(), motion.duration(), motion.certificate->clearance);
      for (const auto& q : motion.waypoints.rowwise()) print_numbers(q);
      at[name] = motion.positions.bottomRows(1).transpose();
    }
    const srmp::PlanStatistics& statistics = planner.get_planning_stats();
    std::printf("%.17g rad, at most %.17g times the optimum\n", statistics.path_cost_rad, statistics.bound);
  }
}
