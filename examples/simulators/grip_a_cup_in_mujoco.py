"""MuJoCo: two fingers grip a cup, hold it by friction alone while the arm carries it upright, and put it down.

    python examples/simulators/grip_a_cup_in_mujoco.py [IMAGE.png]

Needs mujoco (pip install ".[mujoco]"). The image needs an OpenGL that renders without a screen (MUJOCO_GL=egl or
osmesa).
"""

import sys
from math import pi, radians
from pathlib import Path

import mujoco
import numpy as np

import srmp
from srmp import PathConstraint, Pose, Segment, SegmentType, Trajectory

START, GOAL = [0.55, 0.6, 0.35], [0.55, 0.1, 0.45]  # of the cup's middle [m]
RADIUS, OPEN, GRIP = 0.028, 0.075, 0.05  # [m] of the cup; widths between the fingers, the last one of a firm grip
FINGER = "left_finger_joint1"  # that the other one follows


def build():
    """The robot from its URDF, two stands, a cup, and a position servo for the fingers."""
    urdf = Path(srmp.data_path("two_arms.urdf")).read_text()
    # Without this, MuJoCo merges links that are joined by fixed joints, and the base with the world.
    header = '<robot name="two_arms">'
    urdf = urdf.replace(header, header + '<mujoco><compiler fusestatic="false"/></mujoco>')
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth = 1280
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10  # for grasps
    world = spec.worldbody
    world.add_light(pos=[2, 0, 3], dir=[-0.6, 0, -1])
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, pos=[0, 0, -0.11], size=[2, 2, 0.1])
    for name, (x, y, z) in (("stand_left", START), ("stand_right", GOAL)):
        stand = world.add_body(name=name, pos=[x, y, z / 2 - 0.08])
        stand.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.08, 0.08, z / 2 + 0.03], rgba=[0.6, 0.7, 0.8, 1])
    cup = world.add_body(name="cup", pos=START)
    cup.add_freejoint()
    grip = {"condim": 4, "friction": [1, 0.02, 0.0001]}  # soft pads resist turning about where they touch
    cup.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[RADIUS, 0.05, 0], density=300, rgba=[0.9, 0.4, 0.2, 1], **grip
    )
    spec.attach(mujoco.MjSpec.from_string(urdf), prefix="robot/", frame=world.add_frame())
    servo = spec.add_actuator(name=FINGER, target=f"robot/{FINGER}", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.set_to_position(kp=4000, kv=40)
    model = spec.compile()
    return model, mujoco.MjData(model)


def fingers_to(width, data):
    """The motion of the fingers to a width between them, in half a second, from where they are."""
    now = float(data.joint(f"robot/{FINGER}").qpos[0])
    return Trajectory([FINGER], positions=[[now], [width / 2]], times=[0, 0.5], velocities=[[0], [0]])


def draw(path, model, pictures):
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = [0.35, 0.3, 0.35], 1.6, 130, -25
    drawn = []
    with mujoco.Renderer(model, 420, 420) as renderer:
        for qpos in pictures:
            data = mujoco.MjData(model)
            data.qpos[:] = qpos
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            drawn.append(renderer.render())
    import matplotlib.image

    matplotlib.image.imsave(path, np.concatenate(drawn, axis=1))


def forward(p):
    """The left hand at p, its z axis forward, fingers left and right."""
    return Pose.from_rpy(p, [0, pi / 2, 0])


model, data = build()
data.joint("robot/left_joint4").qpos[:] = data.joint("robot/left_joint6").qpos[:] = pi / 2
mujoco.mj_forward(model, data)
planner = srmp.PlannerInterface()
robot = {
    "urdf_path": srmp.data_path("two_arms.urdf"),
    "srdf_path": srmp.data_path("two_arms.srdf"),
    "group": "left_arm",
}
world = planner.read_sim((model, data), "mujoco", articulations={"robot": robot})
planner.make_planner("robot", srmp.Auto(time_limit=10))
world.refresh()

upright = PathConstraint.cone([-1, 0, 0], [0, 0, 1], radians(5))  # the hand's -x stays within 5 degrees of up
touching = ["left_finger1", "left_finger2"]
segments = [
    Segment.gripper(OPEN, end_effector="left_gripper"),
    Segment.move(forward(np.add(START, [-0.13, 0, 0]))),
    Segment.linear(forward(START)),
    Segment.attach("cup", "left_hand", touch_links=touching),
    Segment.allow("cup", "stand_left"),
    Segment.gripper(2 * RADIUS, end_effector="left_gripper"),
    Segment.linear(offset=[0, 0, 0.08]),
    Segment.allow("cup", "stand_left", allowed=False),
    Segment.move(forward(np.add(GOAL, [0, 0, 0.08])), constraints=[upright]),
    Segment.allow("cup", "stand_right"),
    Segment.linear(offset=[0, 0, -0.08]),
    Segment.gripper(OPEN, end_effector="left_gripper"),
    Segment.detach("cup"),
    Segment.linear(offset=[-0.13, 0, 0]),
]
result = planner.plan_sequence(planner.get_qpos("robot"), segments)
print(f"planned: {result.trajectory.duration:.2f} s, {result.trajectory.certificate}")

largest_tilt, pictures = 0.0, [data.qpos.copy()]


def watch(_):
    """How far the cup tilts."""
    global largest_tilt
    largest_tilt = max(largest_tilt, np.arccos(min(1.0, data.body("cup").xmat[8])))


widths = iter([OPEN, GRIP, OPEN])
for segment, part in zip(segments, result.parts, strict=True):
    if segment.type == SegmentType.gripper:
        world.execute(fingers_to(next(widths), data), robot="robot", on_step=watch)
    elif part.motion is not None:
        execution = world.execute(part.motion, on_step=watch)
        for contact in execution.unexpected_contacts:
            raise SystemExit(f"{part}: {contact}")
        print(f"{part}: at most {execution.largest_error:.4f} rad off the trajectory")
    elif segment.type == SegmentType.attach:
        world.grasp("cup", "robot", link="left_hand", touch_links=segment.touch_links)
    elif segment.type == SegmentType.detach:
        world.release("cup")
    elif segment.type == SegmentType.allow:
        planner.set_allowed_collision(segment.object, segment.other, allowed=segment.allowed)
    if segment.type in (SegmentType.attach, SegmentType.move):
        pictures.append(data.qpos.copy())
pictures.append(data.qpos.copy())
if len(sys.argv) > 1:
    draw(sys.argv[1], model, [pictures[0], *pictures[2:]])
print(f"the cup tilted by at most {np.degrees(largest_tilt):.2f} degrees")
assert abs(data.body("cup").xpos - GOAL).max() < 0.02, data.body("cup").xpos
print("the cup stands at", np.round(data.body("cup").xpos, 3))
