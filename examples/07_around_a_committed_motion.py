"""Plans one robot around a motion to which another robot is committed.

The C++ program 07_around_a_committed_motion.cpp does the same and prints the same numbers. With the name of an image
file as its argument, this one draws both robots from above (docs/committed-motion.png).
"""

import sys
from math import pi

import numpy as np

import srmp
from srmp import GoalConstraint, GoalType, Pose

planner = srmp.PlannerInterface()
for name, pose in (("left", Pose()), ("right", Pose.from_rpy([0.6, 0, 0], [0, 0, pi]))):
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name=name,
        end_effector="arm7_hand",
        base_pose=pose,
    )
planner.add_box("table", size=[3, 3, 0.1], pose=Pose(p=[0.3, 0, -0.051]))


def turned(angle):
    """The group state "ready" with the base joint at this angle."""
    q = np.array(planner.get_group_states("left")["ready"])
    q[0] = angle
    return q


# The right robot's motion may come from anywhere: another planner, another computer. Here it is planned first.
planner.set_qpos("left", turned(-pi / 2))
planner.make_planner("right", srmp.WAStar(time_limit=30))
committed = planner.plan("right", turned(-0.9), GoalConstraint(GoalType.JOINTS, turned(0.9)))

# The left robot crosses the same region in the other direction. It waits, moves away or takes another path.
planner.make_planner("left", {"planner_id": "xECBS", "time_limit": 30})
goals = {"left": GoalConstraint(GoalType.JOINTS, turned(0.9))}
trajectory = planner.plan_multi({"left": turned(-0.9)}, goals, obstacles={"right": committed})["left"]

print(f"right: {committed.duration:.17g} s")
print(f"left: {trajectory.duration:.17g} s")
print(f"proved free: {'yes' if trajectory.certificate.proved_free else 'no'}")
for q in trajectory.waypoints:
    print(*(f"{x:.17g}" for x in q))


def draw(path):
    """Both robots from above at six instants, with the paths of their end effectors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 3), dpi=110, layout="constrained")
    instants = np.linspace(0, max(trajectory.duration, committed.duration), 6)
    for axes, time in zip(figure.subplots(1, 6, sharey=True), instants, strict=True):
        for name, motion, colour in (("left", trajectory, "#1f6fb4"), ("right", committed, "#d0621b")):
            links = [link for link in planner.get_link_names(name) if "finger" not in link]
            chain = np.array([planner.compute_fk(name, motion.sample(time), link).p for link in links])
            end_effector = np.array([planner.compute_fk(name, q).p for q in motion.positions])
            axes.plot(end_effector[:, 0], end_effector[:, 1], color=colour, linewidth=1, alpha=0.4)
            axes.plot(chain[:, 0], chain[:, 1], color=colour, linewidth=5, solid_capstyle="round", label=name)
            axes.plot(*chain[0, :2], "o", color=colour, markersize=11)
        axes.set_title(f"{time:.1f} s", fontsize=10)
        axes.margins(0.15)
        axes.set_aspect("equal")
        axes.set_axis_off()
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right center", frameon=False)
    figure.savefig(path)


if len(sys.argv) > 1:
    draw(sys.argv[1])
