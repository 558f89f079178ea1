// Plans from MoveIt's files: a planning scene and a motion plan request, both in YAML.
//
// The Python program 04_moveit_files.py does the same and prints the same numbers. On the command line, `srmp plan`
// does it.

#include <cstdio>
#include <string>

#include "printing.hpp"
#include "srmp/moveit_request.hpp"
#include "srmp/planner_interface.hpp"

int main() {
  const std::string files = SRMP_EXAMPLES_DIR "/moveit/";

  srmp::PlannerInterface planner;
  planner.add_articulation({.urdf_path = SRMP_DATA_DIR "/arm7.urdf",
                            .srdf_path = SRMP_DATA_DIR "/arm7.srdf",
                            .name = "arm",
                            .end_effector = "arm7_hand"});
  planner.load_moveit_scene(files + "scene.yaml");
  const srmp::MoveItProblem problem =
      planner.apply_moveit_request("arm", srmp::io::read_moveit_request(files + "request.yaml"));

  planner.make_planner({"arm"}, srmp::WAStar{.common = {.time_limit = 30}});
  const srmp::Trajectory trajectory = planner.plan("arm", problem.start, problem.goals);

  const char* separator = "";
  for (const std::string& name : planner.object_names())
    std::printf("%s%s", std::exchange(separator, " "), name.c_str());
  std::printf("\n%.17g s\n", trajectory.duration());
  for (const auto& q : trajectory.waypoints.rowwise()) print_numbers(q);
}
