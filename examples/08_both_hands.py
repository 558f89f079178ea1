"""A robot with two arms takes a box between its hands and carries it, tilted by no more than its grip allows.

The C++ program 08_both_hands.cpp does the same and prints the same numbers.
"""

from math import pi, radians, sqrt

import srmp
from srmp import PathConstraint, Pose

planner = srmp.PlannerInterface()
planner.add_articulation(
    urdf_path=srmp.data_path("two_arms.urdf"),
    srdf_path=srmp.data_path("two_arms.srdf"),
    name="robot",
    group="both_arms",
)
planner.make_planner("robot", {"planner_id": "auto", "time_limit": 30})
ready = planner.get_group_states("robot")["ready"]

# The hands, in the frame of the box: 1 mm beside its sides, pointing inwards.
left, right = Pose.from_rpy([0, 0.151, 0], [pi / 2, 0, 0]), Pose.from_rpy([0, -0.151, 0], [-pi / 2, 0, 0])
here, there = Pose(p=[0.5, 0, 0.45]), Pose.from_rpy([0.42, 0.1, 0.6], [0, 0, 0.2])


def hands_on(box):
    """Goals of both hands, for a pose of the box."""
    return {"left_hand": box @ left, "right_hand": box @ right}


def show(what, motion):
    """Prints a motion, with what is proved of it."""
    print(f"{what}: {motion.duration:.17g} s, {motion.certificate.clearance:.17g} m clear")
    for kept in motion.certificate.constraints:
        print(f"{kept.constraint}: {kept.deviation:.17g} of {kept.tolerance:.17g}")
    for q in motion.waypoints:
        print(*(f"{x:.17g}" for x in q))


grasp = planner.plan(ready, hands_on(here))
show("grasp", grasp)

planner.add_box("box", size=[0.2, 0.3, 0.2], pose=here)
planner.set_qpos("robot", grasp.positions[-1])
planner.attach_object("box", "robot", "left_hand", touch_links=["right_hand"])

# The right hand keeps its pose in the frame of the left one at every instant: along and about each axis to what makes
# 1 mm and half a degree in all.
closed = PathConstraint.pose(
    left.inverse() @ right, 1e-3 / sqrt(3), radians(0.5) / sqrt(3), link="right_hand", frame="left_hand"
)
show("carry", planner.plan(grasp.positions[-1], hands_on(there), constraints=[closed]))
