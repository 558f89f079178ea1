"""Genesis: the robot picks up a cube, carries it over a wall and puts it down.

    python examples/simulators/pick_in_genesis.py [IMAGE.png]

Needs torch and genesis-world (pip install ".[genesis]"). The image needs an OpenGL that renders without a screen.
Genesis compiles for minutes the first time and caches what it has compiled.
"""

import sys
from math import pi

import genesis as gs
import numpy as np

import srmp
from srmp import GoalConstraint, GoalType, Pose


def build():
    """The robot from its URDF, a floor, two stands, a wall between them, and a cube."""
    gs.init(backend=gs.cpu, precision="64", logging_level="error")
    scene = gs.Scene(show_viewer=False, rigid_options=gs.options.RigidOptions(use_gjk_collision=True))
    # Genesis merges links that are joined by fixed joints, except those that it is told to keep.
    urdf = gs.morphs.URDF(file=srmp.data_path("arm7.urdf"), fixed=True, links_to_keep=["arm7_palm", "arm7_hand"])
    scene.add_entity(urdf, surface=gs.surfaces.Default(vis_mode="collision", color=(0.9, 0.9, 0.9)), name="arm")
    scene.add_entity(gs.morphs.Plane(), name="floor")
    for name, size, position in (
        ("stand_left", (0.2, 0.2, 0.3), (0.55, 0.3, 0.15)),
        ("stand_right", (0.2, 0.2, 0.4), (0.55, -0.3, 0.2)),
        ("wall", (0.4, 0.02, 0.7), (0.6, 0, 0.35)),
    ):
        box = gs.morphs.Box(size=size, pos=position, fixed=True)
        scene.add_entity(box, surface=gs.surfaces.Default(color=(0.6, 0.7, 0.8)), name=name)
    cube = gs.morphs.Box(size=(0.06, 0.06, 0.06), pos=(0.55, 0.3, 0.33))
    wood, orange = gs.materials.Rigid(rho=300), gs.surfaces.Default(color=(0.9, 0.4, 0.2))
    scene.add_entity(cube, material=wood, surface=orange, name="cube")
    camera = scene.add_camera(res=(640, 480), pos=(1.9, -1.1, 1.1), lookat=(0.3, 0, 0.4)) if len(sys.argv) > 1 else None
    scene.build()
    return scene, camera


def draw(path, camera):
    import matplotlib.image

    matplotlib.image.imsave(path, camera.render()[0])


scene, camera = build()
arm, cube = scene.get_entity("arm"), scene.get_entity("cube")
arm.set_dofs_kp([4500, 4500, 3500, 3500, 2000, 2000, 2000])
arm.set_dofs_kv([450, 450, 350, 350, 200, 200, 200])
planner = srmp.PlannerInterface()
description = {
    "urdf_path": srmp.data_path("arm7.urdf"),
    "srdf_path": srmp.data_path("arm7.srdf"),
    "end_effector": "arm7_hand",
}
world = planner.read_sim(scene, "genesis", articulations={"arm": description})


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

grip = cube.base_link.idx, arm.get_link("arm7_hand").idx
scene.rigid_solver.add_weld_constraint(*grip)
world.grasp("cube", "arm", touch_links=["arm7_palm"])
planner.set_allowed_collision("cube", "stand_left")  # the cube stands on it
move_to("lift", end_effector_at([0.55, 0.3, 0.4]))
planner.set_allowed_collision("cube", "stand_left", allowed=False)
# A shortest path grazes what it passes, and no controller follows it that exactly.
move_to("carry", end_effector_at([0.55, -0.3, 0.45]), clearance=0.01)
if camera:
    draw(sys.argv[1], camera)

scene.rigid_solver.delete_weld_constraint(*grip)
world.release("cube")
move_to("retreat", end_effector_at([0.42, -0.3, 0.45]))
position = cube.get_pos().numpy()
assert abs(position - [0.55, -0.3, 0.43]).max() < 0.02, position
print("the cube lies at", np.round(position, 3))
