"""MuJoCo: two robots face to face swap places, each end effector over the tray that the other one leaves.

    python examples/simulators/two_arms_in_mujoco.py [IMAGE.png]

Needs mujoco (pip install ".[mujoco]"). The image needs an OpenGL that renders without a screen (MUJOCO_GL=egl or
osmesa).
"""

import sys
from math import pi
from pathlib import Path

import mujoco

import srmp
from srmp import GoalConstraint, GoalType, Pose

urdf = Path(srmp.data_path("arm7.urdf")).read_text()
urdf = urdf.replace('<robot name="arm7">', '<robot name="arm7"><mujoco><compiler fusestatic="false"/></mujoco>')
spec, box = mujoco.MjSpec(), mujoco.mjtGeom.mjGEOM_BOX
spec.worldbody.add_light(pos=[0.4, -1, 3], dir=[0, 0.3, -1])
spec.worldbody.add_geom(name="table", type=box, size=[0.7, 0.5, 0.05], pos=[0.4, 0, -0.05], rgba=[0.8, 0.8, 0.8, 1])
for name, y in (("tray_a", 0.2), ("tray_b", -0.2)):
    tray = spec.worldbody.add_body(name=name, pos=[0.4, y, 0.05])
    tray.add_geom(type=box, size=[0.1, 0.1, 0.05], rgba=[0.6, 0.7, 0.8, 1])
for name, x, rotation in (("left", 0.0, [1, 0, 0, 0]), ("right", 0.8, [0, 0, 0, 1])):
    frame = spec.worldbody.add_frame(pos=[x, 0, 0], quat=rotation)
    spec.attach(mujoco.MjSpec.from_string(urdf), prefix=f"{name}/", frame=frame)
model = spec.compile()
data = mujoco.MjData(model)

planner = srmp.PlannerInterface()
arm = {
    "urdf_path": srmp.data_path("arm7.urdf"),
    "srdf_path": srmp.data_path("arm7.srdf"),
    "end_effector": "arm7_hand",
}
world = planner.read_sim((model, data), "mujoco", articulations={"left": arm, "right": arm})
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

if len(sys.argv) > 1:
    import matplotlib.image

    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = [0.4, 0, 0.25], 1.9, 60, -25
    with mujoco.Renderer(model, 480, 640) as renderer:
        renderer.update_scene(data, camera)
        matplotlib.image.imsave(sys.argv[1], renderer.render())

for name, position in (("left", over_b.p), ("right", over_a.p)):
    assert abs(data.body(f"{name}/arm7_hand").xpos - position).max() < 0.01, name
print("both end effectors are where the other one was")
