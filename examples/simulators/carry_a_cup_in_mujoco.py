"""MuJoCo: the robot picks up a cup, carries it upright over a wall and puts it down, planned as one sequence.

    python examples/simulators/carry_a_cup_in_mujoco.py [IMAGE.png]

Needs mujoco (pip install ".[mujoco]"). The image needs an OpenGL that renders without a screen (MUJOCO_GL=egl or
osmesa).
"""

import sys
from math import pi, radians
from pathlib import Path

import mujoco
import numpy as np

import srmp
from srmp import PathConstraint, Pose, Segment, SegmentType

START, GOAL = [0.55, 0.3, 0.35], [0.55, -0.3, 0.45]  # of the cup's middle


def build():
    """The robot from its URDF, a floor, two stands, a wall, a cup, and a weld to grasp the cup."""
    urdf = Path(srmp.data_path("arm7.urdf")).read_text()
    # Without this, MuJoCo merges links that are joined by fixed joints, and the base with the world.
    urdf = urdf.replace('<robot name="arm7">', '<robot name="arm7"><mujoco><compiler fusestatic="false"/></mujoco>')
    spec, box = mujoco.MjSpec(), mujoco.mjtGeom.mjGEOM_BOX
    spec.visual.global_.offwidth = 1280
    world = spec.worldbody
    world.add_light(pos=[1, -1, 3], dir=[-0.3, 0.3, -1])
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.1], rgba=[0.8, 0.8, 0.8, 1])
    for name, size, position in (
        ("stand_left", [0.1, 0.1, 0.15], [0.55, 0.3, 0.15]),
        ("stand_right", [0.1, 0.1, 0.2], [0.55, -0.3, 0.2]),
        ("wall", [0.2, 0.01, 0.35], [0.6, 0, 0.35]),
    ):
        world.add_body(name=name, pos=position).add_geom(type=box, size=size, rgba=[0.6, 0.7, 0.8, 1])
    cup = world.add_body(name="cup", pos=START)
    cup.add_freejoint()
    cup.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.028, 0.05, 0], density=300, rgba=[0.9, 0.4, 0.2, 1])
    spec.attach(mujoco.MjSpec.from_string(urdf), prefix="arm/", frame=world.add_frame())
    weld = spec.add_equality(name="grip", type=mujoco.mjtEq.mjEQ_WELD, active=False)
    weld.objtype, weld.name1, weld.name2 = mujoco.mjtObj.mjOBJ_BODY, "arm/arm7_hand", "cup"
    model = spec.compile()
    return model, mujoco.MjData(model)


def grip(model, data):
    """Welds the cup to the end effector at its current relative pose."""
    hand, cup = (Pose.from_wxyz(data.body(name).xpos, data.body(name).xquat) for name in ("arm/arm7_hand", "cup"))
    x, y, z, w = (relative := hand.inverse() @ cup).q
    model.eq_data[model.eq("grip").id, :10] = [0, 0, 0, *relative.p, w, x, y, z]
    data.eq_active[model.eq("grip").id] = 1


def draw(path, pictures):
    import matplotlib.image

    matplotlib.image.imsave(path, np.concatenate(pictures, axis=1))


def picture(model, data):
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = [0.45, 0, 0.35], 1.7, 180, -38
    with mujoco.Renderer(model, 420, 420) as renderer:
        renderer.update_scene(data, camera)
        return renderer.render()


def forward(p):
    """The end effector at p, its z axis forward, fingers left and right."""
    return Pose.from_rpy(p, [0, pi / 2, 0])


model, data = build()
planner = srmp.PlannerInterface()
arm = {"urdf_path": srmp.data_path("arm7.urdf"), "srdf_path": srmp.data_path("arm7.srdf"), "end_effector": "arm7_hand"}
world = planner.read_sim((model, data), "mujoco", articulations={"arm": arm})
# The simulated controllers leave the trajectory by a hundredth of a radian, so the planned one stays away from things.
planner.make_planner("arm", srmp.Auto(time_limit=10, preferred_clearance=0.02))
world.refresh()

upright = PathConstraint.cone([-1, 0, 0], [0, 0, 1], radians(5))  # the hand's -x stays within 5 degrees of up
segments = [
    Segment.move(forward(np.add(START, [-0.13, 0, 0]))),
    Segment.linear(forward(START)),
    Segment.attach("cup", "arm7_hand", touch_links=["arm7_palm"]),
    Segment.allow("cup", "stand_left"),
    Segment.linear(offset=[0, 0, 0.08]),
    Segment.allow("cup", "stand_left", allowed=False),
    Segment.move(forward(np.add(GOAL, [0, 0, 0.08])), constraints=[upright]),
    Segment.allow("cup", "stand_right"),
    Segment.linear(offset=[0, 0, -0.08]),
    Segment.detach("cup"),
    Segment.linear(offset=[-0.13, 0, 0]),
]
result = planner.plan_sequence(planner.get_qpos("arm"), segments)
print(f"planned: {result.trajectory.duration:.2f} s, {result.trajectory.certificate}")

pictures, largest_tilt = [], 0.0


def photograph():
    if len(sys.argv) > 1:
        pictures.append(picture(model, data))


def watch(_):
    """How far the cup tilts while the robot moves."""
    global largest_tilt
    largest_tilt = max(largest_tilt, np.arccos(min(1.0, data.body("cup").xmat[8])))


for segment, part in zip(segments, result.parts, strict=True):
    if part.motion is not None:
        execution = world.execute(part.motion, on_step=watch)
        for contact in execution.unexpected_contacts:
            raise SystemExit(f"{part}: {contact}")
        print(f"{part}: at most {execution.largest_error:.4f} rad off the trajectory")
    elif segment.type == SegmentType.attach:
        grip(model, data)
        world.grasp(segment.object, "arm", touch_links=segment.touch_links)
        photograph()
    elif segment.type == SegmentType.detach:
        data.eq_active[model.eq("grip").id] = 0
        world.release(segment.object)
    elif segment.type == SegmentType.allow:
        planner.set_allowed_collision(segment.object, segment.other, allowed=segment.allowed)
    if segment.type == SegmentType.move:
        photograph()
photograph()
if pictures:
    draw(sys.argv[1], pictures)
print(f"the cup tilted by at most {np.degrees(largest_tilt):.2f} degrees")
assert abs(data.body("cup").xpos - GOAL).max() < 0.02, data.body("cup").xpos
print("the cup stands at", np.round(data.body("cup").xpos, 3))
