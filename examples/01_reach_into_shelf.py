"""Plans from a robot, a scene and a goal: the arm in srmp's data directory reaches into a shelf.

The C++ program 01_reach_into_shelf.cpp does the same and prints the same numbers.
"""

from math import pi

import srmp

planner = srmp.PlannerInterface()
planner.add_articulation(
    urdf_path=srmp.data_path("arm7.urdf"),
    srdf_path=srmp.data_path("arm7.srdf"),
    name="arm",
    end_effector="arm7_hand",
)
# All lengths are in metres; the pose of a box is that of its centre.
planner.add_box("floor", size=[2, 2, 0.1], pose=srmp.Pose(p=[0, 0, -0.051]))
planner.add_box("board_low", size=[0.3, 0.9, 0.02], pose=srmp.Pose(p=[0.6, 0, 0.3]))
planner.add_box("board_high", size=[0.3, 0.9, 0.02], pose=srmp.Pose(p=[0.6, 0, 0.65]))
planner.add_box("divider", size=[0.3, 0.02, 0.33], pose=srmp.Pose(p=[0.6, 0, 0.475]))
planner.add_cylinder("jar", radius=0.05, length=0.16, pose=srmp.Pose(p=[0.65, -0.32, 0.391]))

# The start is on the left of the divider, the goal on its right; the end effector's z axis points forward.
start = planner.compute_ik("arm", srmp.Pose.from_rpy([0.58, 0.2, 0.45], [0, pi / 2, 0]))[0]
goal = srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose.from_rpy([0.58, -0.2, 0.45], [0, pi / 2, 0]))

planner.make_planner("arm", {"planner_id": "wAstar", "time_limit": 30})
trajectory = planner.plan("arm", start, goal)

print(f"{len(trajectory.waypoints)} waypoints, {len(trajectory)} samples, {trajectory.duration:.17g} s")
for q in trajectory.waypoints:
    print(*(f"{x:.17g}" for x in q))
