"""MuJoCo: a robot with two arms takes a box between its hands and carries it.

    python examples/simulators/both_hands_in_mujoco.py [IMAGE.png]

MuJoCo's own kinematics say how far the hands leave their pose on the box, at 1 kHz. Needs mujoco
(pip install ".[mujoco]"). The image needs an OpenGL that renders without a screen (MUJOCO_GL=egl or osmesa).
"""

import sys
from math import pi, radians, sqrt
from pathlib import Path

import mujoco
import numpy as np

import srmp
from srmp import PathConstraint, Pose

SIZE = np.array([0.2, 0.3, 0.2])  # of the box [m]
START, GOAL = Pose(p=[0.5, 0, 0.4]), Pose.from_rpy([0.42, 0.1, 0.6], [0, 0, 0.2])
# The hands in the frame of the box: 1 mm beside its sides, pointing inwards.
LEFT, RIGHT = Pose.from_rpy([0, 0.151, 0], [pi / 2, 0, 0]), Pose.from_rpy([0, -0.151, 0], [-pi / 2, 0, 0])
HANDS = ("robot/left_hand", "robot/right_hand")


def build():
    """The robot from its URDF, a table, the box on it, and a weld of each hand to the box."""
    urdf = Path(srmp.data_path("two_arms.urdf")).read_text()
    # Without this, MuJoCo merges links that are joined by fixed joints, and the base with the world.
    header = '<robot name="two_arms">'
    urdf = urdf.replace(header, header + '<mujoco><compiler fusestatic="false"/></mujoco>')
    spec, shape = mujoco.MjSpec(), mujoco.mjtGeom.mjGEOM_BOX
    spec.visual.global_.offwidth = 1280
    spec.option.timestep = 0.001
    world = spec.worldbody
    world.add_light(pos=[2, 0, 3], dir=[-0.6, 0, -1])
    world.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, pos=[0, 0, -0.11], size=[2, 2, 0.1])
    table = world.add_body(name="table", pos=[START.p[0], 0, 0.1])
    table.add_geom(type=shape, size=[0.1, 0.1, 0.2], rgba=[0.6, 0.7, 0.8, 1])
    box = world.add_body(name="box", pos=START.p)
    box.add_freejoint()
    box.add_geom(type=shape, size=SIZE / 2, density=20, rgba=[0.9, 0.4, 0.2, 1])
    spec.attach(mujoco.MjSpec.from_string(urdf), prefix="robot/", frame=world.add_frame())
    for hand in HANDS:
        weld = spec.add_equality(name=hand, type=mujoco.mjtEq.mjEQ_WELD, active=False)
        weld.objtype, weld.name1, weld.name2 = mujoco.mjtObj.mjOBJ_BODY, hand, "box"
    model = spec.compile()
    return model, mujoco.MjData(model)


def pose_of(data, body):
    return Pose.from_wxyz(data.body(body).xpos, data.body(body).xquat)


def grip(model, data):
    """Welds the box to both hands at its current relative poses."""
    for hand in HANDS:
        x, y, z, w = (relative := pose_of(data, hand).inverse() @ pose_of(data, "box")).q
        model.eq_data[model.eq(hand).id, :10] = [0, 0, 0, *relative.p, w, x, y, z]
        data.eq_active[model.eq(hand).id] = 1


def hands_on(box):
    """Goals of both hands, for a pose of the box."""
    return {"left_hand": box @ LEFT, "right_hand": box @ RIGHT}


def largest_error(model, motion):
    """How far the right hand leaves its pose in the frame of the left one, at 1 kHz: [m], [rad]."""
    data, wanted = mujoco.MjData(model), LEFT.inverse() @ RIGHT
    joints = [model.joint(f"robot/{name}").qposadr[0] for name in motion.joint_names]
    distance = angle = 0.0
    for q in motion.sample(np.arange(0, motion.duration, 0.001)):
        data.qpos[joints] = q
        mujoco.mj_kinematics(model, data)
        error = wanted.inverse() @ (pose_of(data, HANDS[0]).inverse() @ pose_of(data, HANDS[1]))
        distance = max(distance, np.linalg.norm(error.p))
        angle = max(angle, 2 * np.arcsin(min(1.0, np.linalg.norm(error.q[:3]))))
    return distance, angle


def draw(path, model, pictures):
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = [0.3, 0, 0.4], 2.2, 145, -20
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


def execute(world, what, motion):
    """Plays it in MuJoCo, and refuses contacts that were not planned."""
    execution = world.execute(motion)
    for contact in execution.unexpected_contacts:
        raise SystemExit(f"{what}: {contact}")
    print(f"{what}: {motion.duration:.2f} s, at most {execution.largest_error:.4f} rad off the trajectory")


model, data = build()
planner = srmp.PlannerInterface()
robot = {
    "urdf_path": srmp.data_path("two_arms.urdf"),
    "srdf_path": srmp.data_path("two_arms.srdf"),
    "group": "both_arms",
}
ready = [data.joint(f"robot/{side}_joint{k}") for side in ("left", "right") for k in (4, 6)]
for joint in ready:
    joint.qpos[:] = pi / 2  # the elbows up, the grippers in front of the arms
mujoco.mj_forward(model, data)
world = planner.read_sim((model, data), "mujoco", articulations={"robot": robot})
planner.make_planner("robot", srmp.Auto(time_limit=30))
world.refresh()
pictures = [data.qpos.copy()]

grasp = planner.plan(planner.get_qpos("robot"), hands_on(START))
execute(world, "to the box", grasp)
pictures.append(data.qpos.copy())

grip(model, data)
fingers = [f"{side}_finger{k}" for side in ("left", "right") for k in (1, 2)]
world.grasp("box", "robot", link="left_hand", touch_links=["right_hand", *fingers])
planner.set_allowed_collision("box", "table", allowed=True)
# Along and about each axis: to what makes 1 mm and half a degree in all.
closed = PathConstraint.pose(
    LEFT.inverse() @ RIGHT, 1e-3 / sqrt(3), radians(0.5) / sqrt(3), link="right_hand", frame="left_hand"
)
start = planner.get_qpos("robot")
carry = planner.plan(start, hands_on(GOAL), constraints=[closed])
metres, angle = largest_error(model, carry)
print(f"carry: the hands leave their pose by at most {1000 * metres:.2f} mm and {np.degrees(angle):.2f} degrees")
assert metres <= 1e-3
assert angle <= radians(0.5)
execute(world, "carry", carry)
pictures.append(data.qpos.copy())

box = pose_of(data, "box")
print("the box is at", np.round(box.p, 3), "and was to be at", GOAL.p)
assert np.abs(box.p - GOAL.p).max() < 0.01
if len(sys.argv) > 1:
    draw(sys.argv[1], model, pictures)
