"""SAPIEN: the robot picks up a cube, carries it over a wall and puts it down.

    python examples/simulators/pick_in_sapien.py

Needs sapien (pip install ".[sapien]"). SAPIEN renders only with a GPU, so this program draws no image.
"""

from math import pi

import numpy as np
import sapien

import srmp
from srmp import GoalConstraint, GoalType, Pose


def build():
    """The robot from its URDF, a floor, two stands, a wall between them, and a cube."""
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    scene.set_timestep(1 / 240)
    scene.add_ground(0, render=False)
    for name, half_size, position in (
        ("stand_left", [0.1, 0.1, 0.15], [0.55, 0.3, 0.15]),
        ("stand_right", [0.1, 0.1, 0.2], [0.55, -0.3, 0.2]),
        ("wall", [0.2, 0.01, 0.35], [0.6, 0, 0.35]),
        ("cube", [0.03, 0.03, 0.03], [0.55, 0.3, 0.33]),
    ):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=half_size, density=300)
        builder.set_initial_pose(sapien.Pose(position))
        builder.build(name) if name == "cube" else builder.build_static(name)
    arm = scene.create_urdf_loader().load(srmp.data_path("arm7.urdf"))
    arm.name = "arm"
    return scene, arm


def grip(scene, end_effector, cube):
    """Fixes the cube to the end effector at its current relative pose, until the drive is removed."""
    drive = scene.create_drive(end_effector, end_effector.pose.inv() * cube.pose, cube, sapien.Pose())
    for lock in (drive.set_limit_x, drive.set_limit_y, drive.set_limit_z):
        lock(0, 0)
    drive.set_drive_property_slerp(stiffness=100, damping=10)  # SAPIEN cannot lock rotations
    return drive


scene, arm = build()
end_effector = arm.find_link_by_name("arm7_hand").entity
cube = next(entity for entity in scene.entities if entity.name == "cube")
planner = srmp.PlannerInterface()
description = {
    "urdf_path": srmp.data_path("arm7.urdf"),
    "srdf_path": srmp.data_path("arm7.srdf"),
    "end_effector": "arm7_hand",
}
world = planner.read_sim(scene, "sapien", articulations={"arm": description})


def move_to(what, goal, **options):
    """Plans from the current state of the simulation and executes the trajectory there."""
    planner.make_planner("arm", srmp.Auto(time_limit=10, **options))
    world.refresh()
    trajectory = planner.plan("arm", planner.get_qpos("arm"), goal)
    execution = world.execute(trajectory)
    print(f"{what}: {trajectory.duration:.2f} s, at most {execution.largest_error:.4f} rad off the trajectory")
    for contact in execution.unexpected_contacts:
        raise SystemExit(f"{what}: {contact}")


def end_effector_at(p):
    """End effector at p, its z axis forward, fingers left and right."""
    return GoalConstraint(GoalType.POSE, Pose.from_rpy(p, [0, pi / 2, 0]))


ready = planner.get_group_states("arm")["ready"]
move_to("to ready", GoalConstraint(GoalType.JOINTS, ready))
move_to("approach", end_effector_at([0.42, 0.3, 0.345]))
move_to("reach", end_effector_at([0.55, 0.3, 0.345]))

drive = grip(scene, end_effector, cube)
world.grasp("cube", "arm", touch_links=["arm7_palm"])
planner.set_allowed_collision("cube", "stand_left")  # the cube stands on it
move_to("lift", end_effector_at([0.55, 0.3, 0.4]))
planner.set_allowed_collision("cube", "stand_left", allowed=False)
# A shortest path grazes what it passes, and no controller follows it that exactly.
move_to("carry", end_effector_at([0.55, -0.3, 0.45]), clearance=0.01)

cube.remove_component(drive)
for _ in range(60):  # the cube falls the last millimetres
    scene.physx_system.step()
world.release("cube")
move_to("retreat", end_effector_at([0.42, -0.3, 0.45]))
assert abs(cube.pose.p - [0.55, -0.3, 0.43]).max() < 0.02, cube.pose.p
print("the cube lies at", np.round(cube.pose.p, 3))
