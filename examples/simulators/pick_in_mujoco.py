"""MuJoCo: the robot picks up a cube, carries it over a wall and puts it down.

    python examples/simulators/pick_in_mujoco.py [IMAGE.png]

Needs mujoco (pip install ".[mujoco]"). The image needs an OpenGL that renders without a screen (MUJOCO_GL=egl or
osmesa).
"""

import sys
from math import pi
from pathlib import Path

import mujoco
import numpy as np

import srmp
from srmp import GoalConstraint, GoalType, Pose


def build():
    """The robot from its URDF, a floor, two stands, a wall between them, a cube, and a weld constraint to grasp it."""
    urdf = Path(srmp.data_path("arm7.urdf")).read_text()
    # Without this, MuJoCo merges links that are joined by fixed joints, and the base with the world.
    urdf = urdf.replace('<robot name="arm7">', '<robot name="arm7"><mujoco><compiler fusestatic="false"/></mujoco>')
    spec, box = mujoco.MjSpec(), mujoco.mjtGeom.mjGEOM_BOX
    world = spec.worldbody
    world.add_light(pos=[1, -1, 3], dir=[-0.3, 0.3, -1])
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.1], rgba=[0.8, 0.8, 0.8, 1])
    for name, size, position in (
        ("stand_left", [0.1, 0.1, 0.15], [0.55, 0.3, 0.15]),
        ("stand_right", [0.1, 0.1, 0.2], [0.55, -0.3, 0.2]),
        ("wall", [0.2, 0.01, 0.35], [0.6, 0, 0.35]),
    ):
        world.add_body(name=name, pos=position).add_geom(type=box, size=size, rgba=[0.6, 0.7, 0.8, 1])
    cube = world.add_body(name="cube", pos=[0.55, 0.3, 0.33])
    cube.add_freejoint()
    cube.add_geom(type=box, size=[0.03, 0.03, 0.03], density=300, rgba=[0.9, 0.4, 0.2, 1])
    spec.attach(mujoco.MjSpec.from_string(urdf), prefix="arm/", frame=world.add_frame())
    weld = spec.add_equality(name="grip", type=mujoco.mjtEq.mjEQ_WELD, active=False)
    weld.objtype, weld.name1, weld.name2 = mujoco.mjtObj.mjOBJ_BODY, "arm/arm7_hand", "cube"
    model = spec.compile()
    return model, mujoco.MjData(model)


def grip(model, data):
    """Welds the cube to the end effector at its current relative pose."""
    end_effector, cube = (
        Pose.from_wxyz(data.body(name).xpos, data.body(name).xquat) for name in ("arm/arm7_hand", "cube")
    )
    x, y, z, w = (relative := end_effector.inverse() @ cube).q
    # The pose of the cube's frame in the end effector's.
    model.eq_data[model.eq("grip").id, :10] = [0, 0, 0, *relative.p, w, x, y, z]
    data.eq_active[model.eq("grip").id] = 1


def draw(path, model, data):
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = [0.3, 0, 0.4], 2.0, 150, -20
    with mujoco.Renderer(model, 480, 640) as renderer:
        renderer.update_scene(data, camera)
        pixels = renderer.render()
    import matplotlib.image

    matplotlib.image.imsave(path, pixels)


model, data = build()
planner = srmp.PlannerInterface()
arm = {
    "urdf_path": srmp.data_path("arm7.urdf"),
    "srdf_path": srmp.data_path("arm7.srdf"),
    "end_effector": "arm7_hand",
}
world = planner.read_sim((model, data), "mujoco", articulations={"arm": arm})


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

grip(model, data)
world.grasp("cube", "arm", touch_links=["arm7_palm"])
planner.set_allowed_collision("cube", "stand_left")  # the cube stands on it
move_to("lift", end_effector_at([0.55, 0.3, 0.4]))
planner.set_allowed_collision("cube", "stand_left", allowed=False)
# A shortest path grazes what it passes, and no controller follows it that exactly.
move_to("carry", end_effector_at([0.55, -0.3, 0.45]), clearance=0.01)
if len(sys.argv) > 1:
    draw(sys.argv[1], model, data)

data.eq_active[model.eq("grip").id] = 0
world.release("cube")
move_to("retreat", end_effector_at([0.42, -0.3, 0.45]))
assert abs(data.body("cube").xpos - [0.55, -0.3, 0.43]).max() < 0.02, data.body("cube").xpos
print("the cube lies at", np.round(data.body("cube").xpos, 3))
