"""Plans from MoveIt's files: a planning scene and a motion plan request, both in YAML.

The C++ program 04_moveit_files.cpp does the same and prints the same numbers. On the command line, `srmp plan` does it.
"""

from pathlib import Path

import srmp

files = Path(__file__).parent / "moveit"

planner = srmp.PlannerInterface()
planner.add_articulation(
    urdf_path=srmp.data_path("arm7.urdf"),
    srdf_path=srmp.data_path("arm7.srdf"),
    name="arm",
    end_effector="arm7_hand",
)
planner.load_moveit_scene(str(files / "scene.yaml"))
problem = planner.apply_moveit_request("arm", srmp.load_moveit_request(str(files / "request.yaml")))

planner.make_planner("arm", srmp.WAStar(time_limit=30))
trajectory = planner.plan("arm", problem.start, problem.goals)

print(*planner.object_names)
print(f"{trajectory.duration:.17g} s")
for q in trajectory.waypoints:
    print(*(f"{x:.17g}" for x in q))
