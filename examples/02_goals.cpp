// Goal types, tolerances, several goals at once, and the errors when no trajectory is found.
//
// The Python program 02_goals.py does the same and prints the same numbers.

#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "printing.hpp"
#include "srmp/planner_interface.hpp"

using srmp::GoalConstraint;
using srmp::Pose;
using std::numbers::pi;

namespace {

Eigen::VectorXd joints(std::initializer_list<double> q) {
  return Eigen::Map<const Eigen::VectorXd>(q.begin(), static_cast<Eigen::Index>(q.size()));
}

const Eigen::VectorXd start = joints({0.9, 0, 0, 1.5, 0, 1.5, 0});

void report(srmp::PlannerInterface& planner, const char* what, const std::vector<GoalConstraint>& goals,
            const Eigen::VectorXd& q = start) {
  try {
    const srmp::Trajectory trajectory = planner.plan("arm", q, goals);
    std::printf("%s: goal %d, %.17g s, ends at\n", what, planner.get_planning_stats().goal_index,
                trajectory.duration());
    print_numbers(trajectory.positions.row(trajectory.positions.rows() - 1));
  } catch (const srmp::PlanningError& error) {
    std::printf("%s: %s: %s\n", what, std::string(to_string(error.status())).c_str(), error.what());
  }
}

}  // namespace

int main() {
  srmp::PlannerInterface planner;
  planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                            .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                            .name = "arm",
                            .end_effector = "arm7_hand"});
  planner.add_box("floor", {2, 2, 0.1}, {.p = {0, 0, -0.051}});
  planner.add_box("post", {0.1, 0.1, 0.8}, {.p = {0.35, 0, 0.4}});
  planner.make_planner({"arm"}, srmp::WAStar{.common = {.time_limit = 30}, .weight = 10});

  const Pose down = Pose::from_rpy({0.3, -0.4, 0.3}, {0, pi, 0});  // fingers down
  const Pose far = Pose::from_rpy({1.5, 0, 0.3}, {0, pi, 0});
  const Pose inside = Pose::from_rpy({0.35, 0, 0.4}, {0, pi, 0});
  const Eigen::VectorXd home = joints({-0.9, 0, 0, 1.5, 0, 1.5, 0});

  report(planner, "joints", {GoalConstraint::joints(home)});
  report(planner, "pose", {GoalConstraint::pose(down)});
  report(planner, "position", {GoalConstraint::position({0.3, -0.4, 0.3})});

  // Where inverse kinematics cannot reach the pose exactly, 1 cm and 5 degrees are accepted.
  GoalConstraint roughly = GoalConstraint::pose(down);
  roughly.position_tolerance = 0.01;
  roughly.rotation_tolerance = 5 * pi / 180;
  report(planner, "with tolerances", {roughly});

  // Any one of several: targets of one type in one goal, or a list of goals. Targets out of reach are ignored.
  GoalConstraint either = GoalConstraint::pose(far);
  either.targets.push_back(GoalConstraint::pose(down).targets[0]);
  report(planner, "one of two poses", {either});
  report(planner, "a pose or a configuration", {GoalConstraint::pose(far), GoalConstraint::joints(home)});

  // When no trajectory is found, the error has a status and a sentence that says why.
  report(planner, "out of reach", {GoalConstraint::pose(far)});
  report(planner, "inside the post", {GoalConstraint::pose(inside)});
  report(planner, "bad start", {GoalConstraint::pose(down)}, joints({0, 0.6, 0, 1.5, 0, 1, 0}));

  // An invalid argument raises another type of error and changes nothing.
  try {
    planner.plan("arm", start.head(6), GoalConstraint::pose(down));
  } catch (const srmp::InvalidArgument& error) {
    std::printf("refused: %s\n", error.what());
  }
}
