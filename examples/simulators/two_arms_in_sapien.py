"""SAPIEN: two robots face to face swap places, each end effector over the tray that the other one leaves.

    python examples/simulators/two_arms_in_sapien.py

Needs sapien (pip install ".[sapien]"). SAPIEN renders only with a GPU, so this program draws no image.
"""

from math import pi

import sapien

import srmp
from srmp import GoalConstraint, GoalType, Pose

scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
scene.set_timestep(1 / 240)
for name, half_size, position in (
    ("table", [0.7, 0.5, 0.05], [0.4, 0, -0.05]),
    ("tray_a", [0.1, 0.1, 0.05], [0.4, 0.2, 0.05]),
    ("tray_b", [0.1, 0.1, 0.05], [0.4, -0.2, 0.05]),
):
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=half_size)
    builder.set_initial_pose(sapien.Pose(position))
    builder.build_static(name)
arms = {}
for name, x, rotation in (("left", 0.0, [1, 0, 0, 0]), ("right", 0.8, [0, 0, 0, 1])):
    arms[name] = scene.create_urdf_loader().load(srmp.data_path("arm7.urdf"))
    arms[name].name = name
    arms[name].root_pose = sapien.Pose([x, 0, 0], rotation)

planner = srmp.PlannerInterface()
arm = {
    "urdf_path": srmp.data_path("arm7.urdf"),
    "srdf_path": srmp.data_path("arm7.srdf"),
    "end_effector": "arm7_hand",
}
world = planner.read_sim(scene, "sapien", articulations={"left": arm, "right": arm})
planner.make_planner(["left", "right"], {"planner_id": "xECBS", "time_limit": 30})


def move_to(what, goals):
    """Plans from the current state of the simulation and executes the trajectories there."""
    world.refresh()
    trajectory = planner.plan_multi({name: planner.get_qpos(name) for name in goals}, goals)
    execution = world.execute(trajectory)
    print(f"{what}: {trajectory.duration:.2f} s, at most {execution.largest_error:.4f} rad off the trajectories")
    for contact in execution.unexpected_contacts:
        raise SystemExit(f"{what}: {contact}")


over_a, over_b = (Pose.from_rpy([0.4, y, 0.2], [pi, 0, 0]) for y in (0.2, -0.2))  # fingers down
for what, goals in (("over the trays", (over_a, over_b)), ("swapped", (over_b, over_a))):
    move_to(what, {n: GoalConstraint(GoalType.POSE, goal) for n, goal in zip(("left", "right"), goals, strict=True)})

for name, position in (("left", over_b.p), ("right", over_a.p)):
    end_effector = arms[name].find_link_by_name("arm7_hand").entity
    assert abs(end_effector.pose.p - position).max() < 0.01, name
print("both end effectors are where the other one was")
