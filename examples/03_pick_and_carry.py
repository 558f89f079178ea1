"""Pick and place: the robot grasps a can, carries it around a wall, puts it down and retreats.

The C++ program 03_pick_and_carry.cpp does the same and prints the same numbers.
"""

from math import pi

import srmp
from srmp import GoalConstraint, GoalType, Pose

planner = srmp.PlannerInterface()
planner.add_articulation(
    urdf_path=srmp.data_path("arm7.urdf"),
    srdf_path=srmp.data_path("arm7.srdf"),
    name="arm",
    end_effector="arm7_hand",
)
planner.add_box("floor", size=[2, 2, 0.1], pose=Pose(p=[0, 0, -0.051]))
planner.add_box("stand_left", size=[0.2, 0.2, 0.3], pose=Pose(p=[0.55, 0.3, 0.15]))
planner.add_box("stand_right", size=[0.2, 0.2, 0.4], pose=Pose(p=[0.55, -0.3, 0.2]))
planner.add_box("wall", size=[0.4, 0.02, 0.7], pose=Pose(p=[0.6, 0, 0.35]))
# An attached object must not touch its support either, so it starts, and is put down, 1 mm above its stand.
planner.add_cylinder("can", radius=0.028, length=0.14, pose=Pose(p=[0.55, 0.3, 0.371]))
planner.make_planner("arm", srmp.WAStar(time_limit=30))


def move_to(what, goal):
    """Plans from the robot's current configuration and makes the last configuration the current one."""
    trajectory = planner.plan("arm", planner.get_qpos("arm"), goal)
    planner.set_qpos("arm", trajectory.positions[-1])
    print(f"{what}: {trajectory.duration:.17g} s")
    for q in trajectory.waypoints:
        print(*(f"{x:.17g}" for x in q))


def end_effector_at(p):
    """End effector at p, its z axis forward, fingers left and right."""
    return GoalConstraint(GoalType.POSE, Pose.from_rpy(p, [0, pi / 2, 0]))


ready = planner.get_group_states("arm")["ready"]
planner.set_qpos("arm", ready)
move_to("approach", end_effector_at([0.45, 0.3, 0.38]))
move_to("grasp", end_effector_at([0.55, 0.3, 0.38]))

# From here on the can moves with the robot. The closing fingers and the palm may touch it.
planner.attach_object("can", "arm", "arm7_hand", touch_links=["arm7_palm"])
move_to("carry", end_effector_at([0.55, -0.3, 0.48]))

planner.detach_object("can")
move_to("retreat", end_effector_at([0.42, -0.3, 0.48]))
move_to("return", GoalConstraint(GoalType.JOINTS, ready))
print(*(f"{x:.17g}" for x in planner.get_object_pose("can").p))
