// Plans one motion with the installed library: from the group state "ready" to the other side of a post.

#include <iostream>

#include "srmp/core/version.hpp"
#include "srmp/planner_interface.hpp"

int main() {
  std::cout << "srmp " << srmp::version() << '\n';

  srmp::PlannerInterface planner;
  planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                            .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                            .name = "arm",
                            .end_effector = "arm7_hand"});
  planner.add_box("post", {0.1, 0.1, 0.8}, {.p = {0.35, 0.2, 0.4}});

  const Eigen::VectorXd start = planner.robot("arm").group_states().at("ready");
  const srmp::Pose target = srmp::Pose::from_rpy({0.1, 0.45, 0.4}, {0, 3.14159265358979, 0});  // fingers down
  planner.make_planner({"arm"}, srmp::WAStar{.common = {.time_limit = 30}, .weight = 10});
  try {
    const srmp::Trajectory trajectory = planner.plan("arm", start, srmp::GoalConstraint::pose(target));
    std::cout << "solved: " << trajectory.waypoints.rows() << " waypoints, " << trajectory.duration() << " s\n";
  } catch (const srmp::PlanningError& error) {
    std::cout << to_string(error.status()) << ": " << error.what() << '\n';
    return 1;
  }
}
