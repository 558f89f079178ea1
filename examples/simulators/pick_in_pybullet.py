"""PyBullet: the robot picks up a cube, carries it over a wall and puts it down.

    python examples/simulators/pick_in_pybullet.py [IMAGE.png]

Needs pybullet (pip install ".[pybullet]"), which renders the image without a screen or a GPU.
"""

import sys
from math import pi

import numpy as np
import pybullet

import srmp
from srmp import GoalConstraint, GoalType, Pose


def box(name, half, position, color, mass=0.0):
    """Adds a box. The planner uses the name given here."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
    visual = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=half, rgbaColor=color)
    body = pybullet.createMultiBody(mass, shape, visual, position)
    pybullet.addUserData(body, "name", name)
    return body


def build():
    """The robot from its URDF, a floor, two stands, a wall between them and a cube. Returns the robot and the cube."""
    pybullet.setGravity(0, 0, -9.81)
    arm = pybullet.loadURDF(srmp.data_path("arm7.urdf"), useFixedBase=True)
    pybullet.addUserData(arm, "name", "arm")
    floor = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=[0, 0, 1]))
    pybullet.addUserData(floor, "name", "floor")
    blue = [0.6, 0.7, 0.8, 1]
    box("stand_left", [0.1, 0.1, 0.15], [0.55, 0.3, 0.15], blue)
    box("stand_right", [0.1, 0.1, 0.2], [0.55, -0.3, 0.2], blue)
    box("wall", [0.2, 0.01, 0.35], [0.6, 0, 0.35], blue)
    return arm, box("cube", [0.03] * 3, [0.55, 0.3, 0.33], [0.9, 0.4, 0.2, 1], mass=0.1)


def grip(arm, cube):
    """Fixes the cube to the end effector at its current relative pose."""
    link = pybullet.getNumJoints(arm) - 1
    state = pybullet.getLinkState(arm, link)
    end_effector, body = Pose(p=state[0], q=state[1]), Pose(*pybullet.getBasePositionAndOrientation(cube))
    relative = end_effector.inverse() @ body
    fixed = pybullet.JOINT_FIXED
    return pybullet.createConstraint(arm, link, cube, -1, fixed, [0, 0, 0], relative.p, [0, 0, 0], relative.q)


def draw(path):
    view = pybullet.computeViewMatrixFromYawPitchRoll([0.3, 0, 0.35], 1.7, 60, -20, 0, 2)
    lens = pybullet.computeProjectionMatrixFOV(50, 640 / 480, 0.1, 10)
    pixels = pybullet.getCameraImage(640, 480, view, lens, renderer=pybullet.ER_TINY_RENDERER)[2]
    import matplotlib.image

    matplotlib.image.imsave(path, np.reshape(pixels, (480, 640, 4)).astype(np.uint8)[:, :, :3])


client = pybullet.connect(pybullet.DIRECT)
arm, cube = build()
planner = srmp.PlannerInterface()
description = {
    "urdf_path": srmp.data_path("arm7.urdf"),
    "srdf_path": srmp.data_path("arm7.srdf"),
    "end_effector": "arm7_hand",
}
world = planner.read_sim(client, "pybullet", articulations={"arm": description})


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

grasp = grip(arm, cube)
world.grasp(cube, "arm", touch_links=["arm7_palm"])
planner.set_allowed_collision("cube", "stand_left")  # the cube stands on it
move_to("lift", end_effector_at([0.55, 0.3, 0.4]))
planner.set_allowed_collision("cube", "stand_left", allowed=False)
# A shortest path grazes what it passes, and no controller follows it that exactly.
move_to("carry", end_effector_at([0.55, -0.3, 0.45]), clearance=0.01)
if len(sys.argv) > 1:
    draw(sys.argv[1])

pybullet.removeConstraint(grasp)
world.release(cube)
move_to("retreat", end_effector_at([0.42, -0.3, 0.45]))
position = pybullet.getBasePositionAndOrientation(cube)[0]
assert np.abs(np.subtract(position, [0.55, -0.3, 0.43])).max() < 0.02, position
print("the cube lies at", np.round(position, 3))
