"""Four robots around four bins: each end effector moves to the next bin, which another one is leaving, and back.

The C++ program 06_four_arms_over_bins.cpp does the same and prints the same numbers; figures.py draws it.
"""

from math import pi

import srmp
from srmp import GoalConstraint, GoalType, Pose

ROBOTS = {"east": (0.5, 0, pi), "north": (0, 0.5, -pi / 2), "west": (-0.5, 0, 0), "south": (0, -0.5, pi / 2)}
BINS = ((0.18, 0.18), (-0.18, 0.18), (-0.18, -0.18), (0.18, -0.18))

planner = srmp.PlannerInterface()
for name, (x, y, yaw) in ROBOTS.items():
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name=name,
        end_effector="arm7_hand",
        base_pose=Pose.from_rpy([x, y, 0], [0, 0, yaw]),
    )
planner.add_box("table", size=[1.6, 1.6, 0.1], pose=Pose(p=[0, 0, -0.051]))
for i, (x, y) in enumerate(BINS):
    planner.add_box(f"bin{i}", size=[0.16, 0.16, 0.14], pose=Pose(p=[x, y, 0.07]))
planner.make_planner(list(ROBOTS), {"planner_id": "xECBS", "time_limit": 30})

over = [Pose.from_rpy([x, y, 0.25], [pi, 0, 0]) for x, y in BINS]  # fingers down
ready = planner.get_group_states("east")["ready"]
at = {name: planner.compute_ik(name, over[i], reference=ready)[0] for i, name in enumerate(ROBOTS)}
next_bins = {name: GoalConstraint(GoalType.POSE, over[(i + 3) % 4]) for i, name in enumerate(ROBOTS)}
own_bins = {name: GoalConstraint(GoalType.JOINTS, q) for name, q in at.items()}

for goals in (next_bins, own_bins):
    trajectory = planner.plan_multi(at, goals)
    for name, motion in trajectory.items():
        print(f"{name}: {motion.duration:.17g} s, {motion.certificate.clearance:.17g} m clear")
        for q in motion.waypoints:
            print(*(f"{x:.17g}" for x in q))
        at[name] = motion.positions[-1]
    statistics = planner.get_planning_stats()
    print(f"{statistics['path_cost_rad']:.17g} rad, at most {statistics['bound']:.17g} times the optimum")
