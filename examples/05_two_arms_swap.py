"""Two robots face to face swap places: each end effector moves over the tray that the other one leaves.

The C++ program 05_two_arms_swap.cpp does the same and prints the same numbers; figures.py draws it.
"""

from math import pi

import srmp
from srmp import GoalConstraint, GoalType, Pose

planner = srmp.PlannerInterface()
for name, x, yaw in (("left", 0.0, 0.0), ("right", 0.8, pi)):
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name=name,
        end_effector="arm7_hand",
        base_pose=Pose.from_rpy([x, 0, 0], [0, 0, yaw]),
    )
planner.add_box("table", size=[1.4, 1.0, 0.1], pose=Pose(p=[0.4, 0, -0.051]))
planner.add_box("tray_a", size=[0.2, 0.2, 0.1], pose=Pose(p=[0.4, 0.2, 0.05]))
planner.add_box("tray_b", size=[0.2, 0.2, 0.1], pose=Pose(p=[0.4, -0.2, 0.05]))
planner.make_planner(["left", "right"], {"planner_id": "xECBS", "time_limit": 30})

over_a, over_b = (Pose.from_rpy([0.4, y, 0.2], [pi, 0, 0]) for y in (0.2, -0.2))  # fingers down
ready = planner.get_group_states("left")["ready"]
starts = {
    "left": planner.compute_ik("left", over_a, reference=ready)[0],
    "right": planner.compute_ik("right", over_b, reference=ready)[0],
}
goals = {"left": GoalConstraint(GoalType.POSE, over_b), "right": GoalConstraint(GoalType.POSE, over_a)}


def show(trajectory):
    """Prints the motion of each robot; all of them start at the same time."""
    for name, motion in trajectory.items():
        print(f"{name}: {motion.duration:.17g} s, {motion.certificate.clearance:.17g} m clear")
        for q in motion.waypoints:
            print(*(f"{x:.17g}" for x in q))


trajectory = planner.plan_multi(starts, goals)
show(trajectory)

# Only the left robot has a goal; the right one is in its way, and may move to any configuration.
show(planner.plan_multi(starts, {"left": goals["left"], "right": GoalConstraint.any()}))

# If the right robot must not move, no motion of the left one is collision-free.
try:
    planner.plan_multi(starts, {"left": goals["left"], "right": GoalConstraint.hold()})
except srmp.PlanningError as error:
    print(f"{error.status.name}: {error}")
